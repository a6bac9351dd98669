"""What to do about sound that crackles: facts about a machine and measurements enter, sentences leave.

Nothing is measured or looked up here, so that every piece of advice can be tested with made-up facts.
"""

import dataclasses

GOOD_LOAD = 0.7  # of a block's period, that 999 of 1000 blocks should stay below (a choice)
FULL_LOAD = 1.0
FEW_PERCENT = 0.01  # missing callbacks that nobody need care about: one in ten thousand (a choice)
SLOW_MS = 20.0  # from key to sound; guitarists notice about this much (a choice)
PROBLEM, HINT, GOOD = "problem", "hint", "good"
_RANKS = (PROBLEM, HINT, GOOD)


@dataclasses.dataclass(frozen=True)
class Advice:
    """One sentence or two, and how much it matters: ``"problem"``, ``"hint"`` or ``"good"``."""

    severity: str
    words: str


def advise(machine, output, cells, delays):
    """All advice, the gravest first.

    Parameters
    ----------
    machine : dict
        From `ukrt.drivers.doctor.system_facts.system_facts`.
    output : dict
        With ``realtime``: whether the audio server runs with real-time priority, None if there is none.
    cells : list of dict
        One for each block size and stress, with ``block_frames``, ``stress``, ``within_range`` and, by source,
        ``sources`` (from `ukrt.drivers.doctor.measure.summarize`).
    delays : dict
        From block size [frames] to the delay from key to sound, as `key_to_sound` gives it.

    Returns
    -------
    list of Advice
    """
    found = [*_on_scheduling(machine), *_on_processor(machine), *_on_software(machine), *_on_devices(machine)]
    if output["realtime"] is False:
        words = "The audio server runs without real-time priority; start it with (jackd -R), or tick it in qjackctl."
        found.append(Advice(PROBLEM, words))
    for cell in cells:
        found += _on_cell(cell)
    found += _on_choice(cells, delays)
    return sorted(found, key=lambda one: _RANKS.index(one.severity))


def key_to_sound(block_frames, rate, latency, lead_frames, margin=0.0):
    """The delay from a key to the string's release, in its parts and as a sum (dict) [ms].

    Parameters
    ----------
    block_frames : float
        Frames a callback: a message is played one block after it came (on JACK's own driver it waits so long for the
        cycle that brings it).
    rate : float [Hz]
    latency : float [s]
        Of the output, as its server tells it.
    lead_frames : int
        In which a pluck's force grows before it lets the string go.
    margin : float [s]
        What the MIDI process adds for its own way.
    """
    parts = {
        "midi_ms": 1e3 * (block_frames / rate + margin),
        "output_ms": 1e3 * latency,
        "pluck_ms": 1e3 * lead_frames / rate,
    }
    return parts | {"total_ms": sum(parts.values())}


def recommend(cells):
    """The smallest block size that went well under every stress it was measured with; None where none did."""
    bad = {cell["block_frames"] for cell in cells if not _went_well(cell)}
    good = {cell["block_frames"] for cell in cells} - bad
    return min(good, default=None)


def clearly_more(mine, nothing):
    """Whether two counts of the same time differ by more than chance: by three standard deviations of rare events."""
    return mine - nothing > 3.0 * (mine + nothing) ** 0.5


def _went_well(cell):
    mine = cell["sources"]["compiled"]
    loads = mine["load"]
    return mine["missing_percent"] <= FEW_PERCENT and (loads is None or loads["p99.9"] <= GOOD_LOAD)


def _on_scheduling(machine):
    scheduling, lock = machine["scheduling"], machine["memory_lock"]
    if scheduling["allowed"] is False:
        yield Advice(PROBLEM, f"Sound waits behind every other program: {scheduling['reason']}.")
    elif scheduling["allowed"]:
        yield Advice(GOOD, "Real-time priority is allowed.")
    if scheduling["allowed"] and scheduling["rttime_limit_us"] not in (None, -1):
        limit = 1e-3 * scheduling["rttime_limit_us"]
        yield Advice(
            HINT, f"The system ends real-time programs that compute for {limit:.0f} ms without a pause (RLIMIT_RTTIME)."
        )
    if lock["allowed"] is False:
        yield Advice(HINT, f"Sound may stop while memory is fetched from the disk: {lock['reason']}.")


def _on_processor(machine):
    processor = machine["processor"]
    slow = [name for name in processor["governors"] or () if name != "performance"]
    if slow:
        yield Advice(
            HINT,
            f"The processor slows down when it has little to do (governor {', '.join(slow)}), which costs time when a "
            "chord begins. As root: cpupower frequency-set -g performance",
        )
    if processor["cores"] == 1:
        yield Advice(HINT, "There is only one processor core, which sound shares with everything else.")
    load = processor["load_average"]
    if load is not None and load > processor["cores"]:
        yield Advice(
            PROBLEM, f"Other programs want {load:.1f} cores and there are {processor['cores']}: end what is not needed."
        )
    if processor["hypervisor"]:
        yield Advice(HINT, "This is a virtual machine: it stands still now and then, whatever is done inside.")


def _on_software(machine):
    cache, libraries = machine["jit_cache"], machine["libraries"]
    if not cache["writable"]:
        yield Advice(
            PROBLEM,
            f"Compiled code cannot be kept in {cache['folder']}, so that each start takes a minute: set "
            "UKRT_CACHE_DIR to a folder that you may write to.",
        )
    elif not cache["warm"]:
        yield Advice(HINT, f"The first start compiles for about a minute, into {cache['folder']}.")
    if libraries["portaudio"] is None:
        words = "PortAudio is missing: pip install 'ukrt[live]' (on Debian also: apt-get install libportaudio2)."
        yield Advice(PROBLEM, words)
    if libraries["rtmidi"] is None:
        yield Advice(PROBLEM, "MIDI input is missing: pip install 'ukrt[live]'.")


def _on_devices(machine):
    if machine["audio_outputs"] == []:
        yield Advice(PROBLEM, "No audio output was found: plug one in, or start an audio server.")
    if machine["midi_inputs"] == []:
        yield Advice(HINT, "No MIDI input was found: plug a keyboard in (`ukrt devices` lists what there is).")


def _on_cell(cell):
    """What one block size under one stress tells: the instrument's fault, the machine's, or nobody's."""
    mine, nothing = cell["sources"]["compiled"], cell["sources"]["empty"]
    where = f"At {cell['block_frames']} frames" + (f" ({cell['words']})" if cell["stress"] != "none" else "")
    load = mine["load"]["p99.9"] if mine["load"] else 0.0
    if load > FULL_LOAD:
        yield Advice(
            PROBLEM,
            f"{where} the instrument takes longer than a block lasts in more than one of 1000 blocks: larger blocks "
            "(--block), or fewer contacts in the preset.",
        )
    elif load > GOOD_LOAD:
        yield Advice(
            HINT, f"{where} one block in 1000 takes {100 * load:.0f} % of its time: little is left for surprises."
        )
    if any(clearly_more(mine[kind], nothing[kind]) for kind in ("missing", "xruns")):
        yield Advice(
            PROBLEM if mine["missing_percent"] > FEW_PERCENT else HINT,
            f"{where} the instrument loses {mine['missing']} of {mine['blocks']} callbacks and has {mine['xruns']} "
            f"xruns; a callback that plays nothing loses {nothing['missing']} and has {nothing['xruns']}. The "
            "difference is the instrument's own: larger blocks help.",
        )
    elif nothing["missing_percent"] > FEW_PERCENT:
        gap = nothing["longest_gap_ms"]
        pause = f", with pauses up to {gap:.1f} ms" if gap is not None else ""
        yield Advice(
            PROBLEM if nothing["missing_percent"] > 1.0 else HINT,
            f"{where} even a callback that plays nothing loses {nothing['missing_percent']:.2g} % of its calls{pause}: "
            "it is the machine or its audio server, not the instrument.",
        )


def _on_choice(cells, delays):
    """Which block size to play with, and how late a key is heard then."""
    if not cells:
        return
    best = recommend(cells)
    if best is None:
        largest = max(cell["block_frames"] for cell in cells)
        yield Advice(PROBLEM, f"No block size went well; try larger blocks, such as --block {2 * largest}.")
        return
    total = delays[best]["total_ms"]
    words = f"{best} frames are the smallest blocks that went well: {total:.1f} ms from key to sound."
    yield Advice(HINT if total > SLOW_MS else GOOD, f"{words} Play with --block {best} (on JACK: the server's period).")

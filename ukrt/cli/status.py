"""The line of `ukrt play` on a terminal: a `Moment` enters, one line of text that fits leaves; news stand above it.

Where the terminal is narrow, words are abbreviated first and then left out, the least needed first. Elsewhere than on a
terminal only the news are printed.
"""

from dataclasses import dataclass

from .common import clock_time, make_console, say

FLOOR_DB = -60.0  # left end of the bar
_LONGEST_BAR, _SHORTEST_BAR = 24, 6
_GAP = "  "
_ECHO_CELLS = 3  # left free for the ^C that terminals show, which would otherwise break the line in two


@dataclass
class Moment:
    """What there is to tell, all of it now or in the last seconds.

    Attributes
    ----------
    seconds : float [s]
        Since the session began.
    output, rate_hz, block : str, float, int
        The output's name, sample rate and frames per block (0: not known).
    loads : tuple of float, or None
        Median, 99 % and largest load of a block's period [1].
    xruns, late, missing : int
        Interruptions told by the server; blocks that took too long; blocks nobody asked for.
    ports, messages_per_s : int, float
        MIDI inputs connected.
    notes : int
        Strings that sound.
    peak_db : float [dBFS]
        The loudest sample since the last moment.
    limiter_db : float [dB]
        The limiter's largest reduction since the session began, not above 0.
    shed : int
        How much is left out to save time (0: nothing).
    recording_s : float or None [s]
    piece_s, piece_of_s : float or None [s]
        Where in the piece we are.
    trouble : bool
        Whether any of xruns, late or missing has just grown.
    """

    seconds: float
    output: str = ""
    rate_hz: float = 0.0
    block: int = 0
    loads: tuple | None = None
    xruns: int = 0
    late: int = 0
    missing: int = 0
    ports: int = 0
    messages_per_s: float = 0.0
    notes: int = 0
    peak_db: float = -200.0
    limiter_db: float = 0.0
    shed: int = 0
    recording_s: float | None = None
    piece_s: float | None = None
    piece_of_s: float | None = None
    trouble: bool = False


@dataclass
class _Signs:
    """The characters a terminal can show."""

    note: str = "♪"
    dot: str = "●"
    full: str = "█"
    empty: str = "░"
    cut: str = "…"


ASCII_SIGNS = _Signs("n", "REC", "#", ".", "~")
SIGNS = _Signs()

# Which part is shortened, in this order, until the line fits; a part named twice goes through its next shorter form.
_SACRIFICES = (
    "output", "counts", "piece", "limiter", "load", "shed", "midi", "level", "output", "counts", "piece", "output",
    "limiter", "midi", "load",
)  # fmt: skip


def compose(moment, width, signs=SIGNS):
    """The line (rich.text.Text) of at most ``width`` cells."""
    from rich.text import Text

    parts = {name: forms for name, forms in _parts(moment, signs).items() if forms}
    cuts = _cuts(parts, width)
    line = {name: words for name, forms in parts.items() if (words := forms[cuts[name]])}
    bar = max(0, min(_room(line.values(), width), _LONGEST_BAR))
    text = Text(no_wrap=True, overflow="crop", end="")
    for name, words in line.items():
        text.append(_GAP if text else "")
        for piece, style in words:
            text.append(piece, style)
        if name == "level":
            text.append(" ")
            _append_bar(text, moment.peak_db, bar, signs)
    text.truncate(width)
    return text


def _cuts(parts, width):
    """Which form of each part to take so that the line fits (dict of int)."""
    cuts = dict.fromkeys(parts, 0)

    def fits():
        return _room([forms[cuts[name]] for name, forms in parts.items()], width) >= _SHORTEST_BAR

    made = []
    for name in _SACRIFICES:
        if fits():
            break
        if cuts.get(name, -1) + 1 in range(len(parts.get(name, ()))):
            cuts[name] += 1
            made.append(name)
    for name in made:  # a large cut may have made an earlier one needless
        cuts[name] -= 1
        cuts[name] += not fits()
    return cuts


def _room(line, width):
    """Cells that are left for the bar."""
    from rich.cells import cell_len

    line = [words for words in line if words]
    return width - 1 - len(_GAP) * (len(line) - 1) - sum(cell_len(text) for words in line for text, _ in words)


def _parts(moment, signs):
    """By name, each part of the line in forms from long to short; a form is a list of (text, style)."""
    m = moment
    return {
        "time": [[(clock(m.seconds), "bold")]],
        "piece": _piece(m),
        "output": _output(m, signs),
        "load": _load(m.loads),
        "counts": _counts(m),
        "shed": [[(f"shedding {m.shed}", "bold yellow")], [(f"shed {m.shed}", "bold yellow")]] if m.shed else [],
        "midi": _midi(m),
        "notes": [[(f"{signs.note} {m.notes}", "cyan" if m.notes else "dim")]],
        "level": [[(f"{_db(m.peak_db):>5} dBFS", "")], [(f"{_db(m.peak_db):>5}", "")]],
        "limiter": _limiter(m.limiter_db),
        "recording": [] if m.recording_s is None else [[(f"{signs.dot} {clock(m.recording_s)}", "bold red")]],
    }


def _piece(m):
    if m.piece_s is None:
        return []
    now = clock(m.piece_s)
    return [[("piece ", "dim"), (f"{now} of {clock(m.piece_of_s)}", "")], [("piece ", "dim"), (now, "")], []]


def _output(m, signs):
    rate = f" {m.rate_hz / 1000:g} kHz" if m.rate_hz else ""
    name, short = (m.output if len(m.output) <= n else m.output[: n - 1] + signs.cut for n in (24, 12))
    return [[(name, ""), (f"{rate}, {m.block}" if m.block else rate, "dim")], [(name, "")], [(short, "")], []]


def _load(loads):
    if loads is None:
        return []
    style = "red" if loads[2] > 1.0 else "yellow" if loads[1] > 0.8 else "green"
    numbers = " ".join(f"{100 * load:2.0f}" for load in loads)
    return [[("load ", "dim"), (numbers, style), (" %", "dim")], [(f"{numbers}%", style)], []]


def _counts(m):
    style = "bold red" if m.trouble else "yellow" if m.xruns or m.late or m.missing else ""
    numbers = (("xruns", m.xruns), ("late", m.late), ("missing", m.missing))
    long = [part for name, n in numbers for part in ((f"{name} ", "dim"), (f"{n} ", style if n else ""))]
    long[-1] = (long[-1][0].rstrip(), long[-1][1])
    short = "/".join(str(n) for _, n in numbers)
    return [long, [("xruns ", "dim"), (short, style)], [("x ", "dim"), (short, style)]]


def _midi(m):
    speed = f"{m.messages_per_s:3.0f}/s"
    ports = f"{m.ports} in" if m.ports else "none"
    return [[("MIDI ", "dim"), (f"{ports}, {speed}", "")], [("MIDI ", "dim"), (speed, "")], []]


def _limiter(db):
    if db > -0.05:
        return []
    return [[("limiter ", "dim"), (f"{db:.1f} dB", "yellow")], [("lim ", "dim"), (f"{db:.1f}", "yellow")], []]


def _db(level):
    return f"{level:.1f}" if level > -100.0 else "-inf"


def _append_bar(text, level_db, cells, signs):
    full = round(max(0.0, min(1.0, 1.0 - level_db / FLOOR_DB)) * cells)
    style = "red" if level_db > -1.0 else "yellow" if level_db > -6.0 else "green"
    text.append(signs.full * full, style)
    text.append(signs.empty * (cells - full), "dim")


def clock(seconds):
    """A time as on a display: ``0:07``, ``12:03``, ``1:00:00``."""
    seconds = int(seconds)
    return clock_time(seconds) if seconds >= 60 else f"0:{seconds:02d}"


class StatusLine:
    """Prints news, and below them the line, if standard error is a terminal.

    Parameters
    ----------
    wanted : bool
        False: no line even on a terminal.
    console : rich.console.Console, optional
    """

    def __init__(self, wanted=True, console=None):
        self._console = console or (make_console() if wanted else None)
        self._live = None
        self.shown = bool(wanted and self._console.is_terminal and not self._console.is_dumb_terminal)

    def __enter__(self):
        if self.shown:
            from rich.live import Live

            utf = (self._console.encoding or "").lower().startswith("utf")
            self._signs = SIGNS if utf else ASCII_SIGNS
            options = {"auto_refresh": False, "transient": True, "redirect_stdout": False, "redirect_stderr": False}
            self._live = Live(console=self._console, **options)
            self._live.start()
        return self

    def __exit__(self, *_):
        if self._live is not None:
            self._guarded(self._live.stop)
            self._live = None

    def show(self, moment):
        """Draw the line anew."""
        if self._live is not None:
            line = compose(moment, max(1, self._console.width - _ECHO_CELLS), self._signs)
            self._guarded(self._live.update, line, refresh=True)

    def say(self, sentence):
        """A line of news, above."""
        if self._live is None:
            self._guarded(say, sentence)
        else:
            self._guarded(self._console.print, f"ukrt: {sentence}", markup=False, highlight=False)

    def _guarded(self, draw, *arguments, **options):
        """A terminal that has gone away must not end the music."""
        try:
            draw(*arguments, **options)
        except OSError:
            self._live = None

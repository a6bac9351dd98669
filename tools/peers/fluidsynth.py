"""FluidSynth with a General MIDI sound font: dry, and with reverb and chorus."""

import ctypes
import ctypes.util
import functools
import pathlib
import re

from . import piece
from .peer import BLOCK, SAMPLE_RATE, Peer, PeerError, Ready, called, program_path

FONT = "/usr/share/sounds/sf2/FluidR3_GM.sf2"
PACKAGES = ("fluidsynth", "fluid-soundfont-gm")


def _prepare(effects, work):
    program = program_path("fluidsynth")
    if not pathlib.Path(FONT).is_file():
        raise PeerError(f"{FONT} is not there")
    version = re.search(r"version (\S+)", called("fluidsynth", "--version"))
    options = ["-n", "-i", "-q", "-r", str(SAMPLE_RATE), "-z", str(BLOCK)]
    options += ["-R", str(int(effects)), "-C", str(int(effects)), "-o", "synth.cpu-cores=1", "-O", "float", "-T", "wav"]
    return Ready(
        lambda seconds, target: [program, *options, "-F", target, FONT, work.midi(seconds)],
        version[1] if version else "?",
        note="" if effects else _voices_in_words(work.notes),
    )


def _voices_in_words(notes):
    """How many voices FluidSynth played, where its library can be asked; else nothing."""
    try:
        return f"FluidSynth plays {mean_voices(notes):.1f} sampled voices on average"
    except OSError:
        return ""


def mean_voices(notes):
    """Voices that are active on average while the piece is played (float); asks the library, block by block."""
    library = ctypes.CDLL(ctypes.util.find_library("fluidsynth") or "libfluidsynth.so.3")
    for name in ("new_fluid_settings", "new_fluid_synth"):
        getattr(library, name).restype = ctypes.c_void_p
    settings = ctypes.c_void_p(library.new_fluid_settings())
    library.fluid_settings_setnum(settings, b"synth.sample-rate", ctypes.c_double(SAMPLE_RATE))
    synth = ctypes.c_void_p(library.new_fluid_synth(settings))
    library.fluid_synth_sfload(synth, FONT.encode(), 1)
    library.fluid_synth_program_change(synth, 0, piece.NYLON_GUITAR)
    sound = (ctypes.c_float * BLOCK)(), (ctypes.c_float * BLOCK)()
    waiting, counts = piece.events(notes), []
    for block in range(int(max(note.end for note in notes) * SAMPLE_RATE) // BLOCK):
        while waiting and waiting[0][0] * SAMPLE_RATE < block * BLOCK:
            _, is_on, note = waiting.pop(0)
            if is_on:
                library.fluid_synth_noteon(synth, 0, note.key, note.velocity)
            else:
                library.fluid_synth_noteoff(synth, 0, note.key)
        library.fluid_synth_write_float(synth, BLOCK, sound[0], 0, 1, sound[1], 0, 1)
        counts.append(library.fluid_synth_get_active_voice_count(synth))
    library.delete_fluid_synth(synth)
    library.delete_fluid_settings(settings)
    return sum(counts) / len(counts)


PEERS = (
    Peer("FluidSynth, dry", "sampled voices", PACKAGES, functools.partial(_prepare, False)),
    Peer(
        "FluidSynth, reverb and chorus",
        "sampled voices, reverb, chorus",
        PACKAGES,
        functools.partial(_prepare, True),
    ),
)

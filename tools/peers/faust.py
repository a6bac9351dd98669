"""Faust: six of its nylon guitar strings, and a bank of 800 mode filters, as compiled offline programs.

The bank is compiled as one scalar loop, Faust's default: with loops apart (``-vec``) g++ takes six minutes over it.
"""

import functools

from .modes import modes
from .peer import SOURCES, Peer, Ready, called, program_path

PACKAGES = ("faust", "g++")
STRINGS = """\
import("stdfaust.lib");
string(i) = pm.nylonGuitar(pm.f2l(hslider("freq%i", 110, 50, 1000, 0.01)), 0.8,
                           hslider("gain%i", 0.8, 0, 1, 0.01), button("gate%i"));
process = par(i, 6, string(i)) :> *(0.3);
"""


def bank():
    """The bank of modes as a Faust program (str)."""
    filters = ",\n    ".join(f"pm.modeFilter({hz:.4f}, {t60:.4f}, {gain:.6f})" for hz, t60, gain in modes())
    return f'import("stdfaust.lib");\nprocess = _ <: {filters} :> *(0.003);\n'


def _prepare(name, text, work):
    program_path("faust")
    source, made = work.path(f"faust-{name}.dsp"), work.path(f"faust-{name}.cpp")
    source.write_text(text(), encoding="ascii")
    called("faust", "-lang", "cpp", "-a", str(SOURCES / "faust_offline.cpp"), str(source), "-o", str(made))
    program = work.program(made)
    version = called("faust", "--version").split()[2]
    return Ready(lambda seconds, target: [program, work.events(seconds), target], version)


def _peer(name, computes, program, text):
    return Peer(name, computes, PACKAGES, functools.partial(_prepare, program, text))


PEERS = (
    _peer("Faust nylonGuitar", "6 waveguides, always on", "nylon", lambda: STRINGS),
    _peer("Faust modal bank, 800 modes", "uncoupled fixed filters", "bank", bank),
)

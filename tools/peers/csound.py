"""Csound's opcode ``mode``, 800 of them in one instrument that is always on."""

import math
import re

from . import piece
from .modes import modes
from .peer import BLOCK, SAMPLE_RATE, Peer, Ready, called, program_path

GAIN = 1e-2  # the opcode's output grows with the square of the period
HEAD = f"""\
sr = {SAMPLE_RATE}
ksmps = {BLOCK}
nchnls = 1
0dbfs = 1
gastrike init 0
instr 1
  astrike mpulse p4, 0
  gastrike = gastrike + astrike
endin
instr 2
  asum init 0
  asum = 0
"""
TAIL = f"""\
  out asum * {GAIN}
  gastrike = 0
endin
"""


def orchestra():
    """The instruments (str): one strikes, one rings. The quality factor is pi f t60 / ln 1000."""
    lines = []
    for hz, t60, gain in modes():
        quality = math.pi * hz * t60 / math.log(1000.0)
        lines.append(f"  aring mode gastrike, {hz:.4f}, {quality:.3f}\n  asum = asum + {gain:.6f} * aring\n")
    return HEAD + "".join(lines) + TAIL


def score(notes, seconds):
    """The score (str): the bank for ``seconds``, a strike of one block at each note."""
    strikes = [f"i 1 {note.start:.6f} {BLOCK / SAMPLE_RATE:.6f} {note.velocity / 127:.4f}" for note in notes]
    return "\n".join([f"i 2 0 {seconds:g}", *strikes, "e", ""])


def _prepare(work):
    program = program_path("csound")
    version = re.search(r"version (\S+)", called("csound", "--version"))
    instruments = work.file("bank.orc", lambda path: path.write_text(orchestra(), encoding="ascii"))

    def command(seconds, target):
        played = score(piece.first_seconds(work.notes, seconds), seconds)
        path = work.file(f"bank-{seconds:g}.sco", lambda path: path.write_text(played, encoding="ascii"))
        return [program, "-d", "-m0", "-W", "-f", "-o", target, instruments, path]

    return Ready(command, version[1] if version else "?")


PEERS = (Peer("Csound mode, 800 modes", "uncoupled fixed filters", ("csound",), _prepare),)

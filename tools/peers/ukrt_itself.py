"""ukrt: its engine alone, as live playing runs it, and the whole command that renders a file."""

import sys

import ukrt

from .peer import Peer, Ready, worker

NAME = "ukrt, engine"
COMPUTES = "coupled strings, two polarizations, body, contacts, convolution"


def _engine(_work):
    return Ready(lambda seconds, target: worker("ukrt_engine", seconds, target), ukrt.__version__, counts_itself=True)


def _command(work):
    def command(seconds, target):
        whole = [sys.executable, "-m", "ukrt", "render", work.midi(seconds), "-o", target, "--bits", "32f"]
        return [*whole, "--to", f"{seconds:g}"]

    return Ready(command, ukrt.__version__)


PEERS = (
    Peer(NAME, COMPUTES, (), _engine),
    Peer("ukrt render", "the same; and fingering with the whole piece in view, in Python", (), _command),
)

"""The Synthesis ToolKit: its guitar and its plucked strings, through a program that is compiled here."""

import functools

from .peer import SOURCES, Peer, Ready, debian_version


def _prepare(kind, work):
    program = work.program(SOURCES / "stk_offline.cpp", "-lstk", name=f"stk-{kind}")
    return Ready(
        lambda seconds, target: [program, kind, work.events(seconds), target],
        debian_version("libstk-dev"),
    )


PACKAGES = ("libjack-jackd2-dev", "libstk-dev", "g++")  # the first one first: see peers.install
PEERS = (
    Peer("STK Guitar", "6 waveguides, coupled at the bridge", PACKAGES, functools.partial(_prepare, "guitar")),
    Peer("STK Plucked", "6 waveguides (Karplus-Strong)", PACKAGES, functools.partial(_prepare, "plucked")),
)

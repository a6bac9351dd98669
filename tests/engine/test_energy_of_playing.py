"""Seconds of random playing on the meter: no joule but what hands have brought, whatever they do at once."""

import itertools

import numpy as np
import pytest
from engine.meter import (
    CONSTRAINT,
    FRAME,
    JUMP_DOWN,
    JUMP_UP,
    LARGEST_ENERGY,
    LARGEST_ERROR,
    LOSS,
    PLUCK,
    metered_steps,
)
from engine.storm import CONTROL, ON, random_messages
from engine.swap_bench import RATE, instance, note_log

from ukrt.engine import controller_layout as cc
from ukrt.engine import layout as at
from ukrt.engine.kernels.energy import total_energy
from ukrt.engine.kernels.player import player_message, player_tick
from ukrt.engine.kernels.player_vibrato import follow_vibrato
from ukrt.model.presets import load_preset

STEP = 16  # frames between two looks at the books: less than between two steps of a bend
PHRASE = (  # a note begun in each way, before the storm
    *((0, CONTROL, cc.LEGATO, 127), (100, ON, 52, 90), (4000, ON, 54, 90), (8000, ON, 53, 90)),
    *((9000, CONTROL, cc.GLIDE, 127), (12000, ON, 57, 90)),
    *((15000, CONTROL, cc.LEGATO, 0), (15000, CONTROL, cc.GLIDE, 0)),
    *((16000, CONTROL, cc.HARMONIC, 127), (16000, ON, 64, 90), (18000, CONTROL, cc.HARMONIC, 0)),
    *((18000, CONTROL, cc.MUTE, 64), (18000, ON, 45, 90), (20000, CONTROL, cc.NOTES_OFF, 0)),
)
WAYS = ("pluck", "hammer-on", "pull-off", "slide", "harmonic", "muted")


class Metered:
    """An instance that is played on the meter.

    Attributes
    ----------
    gifts, bends, bound, excess : float [J]
        Jumps of the energy upwards while no tension changes; what changes of tension brought or took, and the most
        that they can bring; the most by which what was there and what was lost exceeded all work put in.
    """

    def __init__(self, guitar):
        self.one = instance(guitar)
        self.ledger, self._saved = np.zeros(8), np.zeros(at.D_SIZE)
        self.gifts = self.bends = self.bound = self.excess = 0.0

    def play(self, messages, n_frames):
        d, i, read = self.one.d, self.one.i, 0
        times = np.union1d(messages[:, 0], np.arange(0, n_frames + 1, STEP))
        for now, then in itertools.pairwise(times[times <= n_frames].tolist()):
            while read < len(messages) and messages[read, 0] <= now:
                player_message(d, i, now, *messages[read, 1:])
                read += 1
            if now % at.CHUNK == 0:
                player_tick(d, i, now)
                follow_vibrato(d, i, now)
            self._advance(then - now)

    def _advance(self, n_frames):
        d, i, ledger = self.one.d, self.one.i, self.ledger
        up, down, energy, tensions = ledger[JUMP_UP], ledger[JUMP_DOWN], total_energy(d, i), self._tensions()
        metered_steps(d, i, n_frames, ledger, self._saved)
        after, rise = total_energy(d, i), np.max(self._tensions() / tensions - 1.0)
        if np.array_equal(tensions, self._tensions()):
            self.gifts += ledger[JUMP_UP] - up
        else:
            self.bends += ledger[JUMP_UP] - up - (ledger[JUMP_DOWN] - down)
            self.bound += max(rise, 0.0) * max(energy, after)
        self.excess = max(self.excess, after + ledger[LOSS] - self.brought - self.bends)

    def _tensions(self):
        strings = self.one.d[at.STRING : at.STRING + at.MAX_STRINGS * at.STRING_D_SIZE].reshape(at.MAX_STRINGS, -1)
        return strings[: self.one.i[at.H_STRINGS], at.S_RATIO].copy()

    @property
    def brought(self):
        """Work of plucks and fingers so far [J]."""
        return self.ledger[PLUCK] + self.ledger[CONSTRAINT]


@pytest.mark.parametrize("seed, per_second", [(1, 1000.0), (4, 300.0)])
def test_there_is_never_more_energy_than_hands_have_brought(seed, per_second):
    """What is there and what was lost is at most the work of plucks, fingers and bends, at any time.

    Bends bring at most what a tension can that rises by so much. Pseudo-modes that are made anew as a finger lands
    weigh the motion a little anew, most on a string that is just being pulled far: less than 1e-3 of the work even in
    a storm of notes that take each other's strings, and always less than what the others took.
    """
    metered, n_frames = Metered(load_preset("classical")), 96000
    messages = random_messages(np.random.default_rng(seed), 2500, per_second, RATE)
    messages[:, 0] += PHRASE[-1][0]
    metered.play(np.concatenate([PHRASE, messages]), n_frames)
    ledger = metered.ledger
    assert ledger[FRAME] == n_frames
    assert ledger[LARGEST_ERROR] < 1e-10 * ledger[LARGEST_ENERGY]
    assert metered.excess <= 1e-9 * metered.brought
    assert metered.gifts < 1e-3 * metered.brought
    assert metered.bends < metered.bound
    assert [note["articulation"] for note in note_log(metered.one)][: len(WAYS)] == list(WAYS)

"""A guitarist on a bench: the compiled player with the real timeline, and strings that only note what is done to them.

Messages go in as the engine sends them; gestures come out in order and are carried out on plain Python records, so that
tests can ask what each string was doing at any time without any sound being computed.
"""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from ukrt.engine import gestures as do
from ukrt.engine import layout
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.player import player_message, player_reset, player_tick
from ukrt.engine.kernels.timeline import timeline_drop_first, timeline_next
from ukrt.engine.note_log import read_counters, read_note_log
from ukrt.engine.player_tables import make_player_tables
from ukrt.model.presets import load_preset

RATE = 48000.0
FAR = 1 << 60


@dataclass
class BenchString:
    """What has been done to one string."""

    place: float = 0.0  # of the stopping finger [m], 0: none
    damped: bool = False
    tension: float = 1.0
    sounding: int = -1  # number of the note that was plucked last and not damped since
    events: list = field(default_factory=list)


class Bench:
    """A player with its strings.

    Parameters
    ----------
    overrides : dict, optional
        Settings of the preset ``classical``.
    tick : bool
        Whether time is told to the player every 64 frames, as the engine does.
    """

    def __init__(self, overrides=None, preset="classical", tick=False):
        self.guitar = load_preset(preset, overrides)
        frets = range(self.guitar.playing.frets + 1)
        self.places = np.array([[s.length * (1 - 2 ** (-n / 12)) for n in frets] for s in self.guitar.strings])
        self.d = np.zeros(layout.D_SIZE)
        self.i = np.zeros(layout.I_SIZE, dtype=np.int64)
        player_reset(self.d, self.i)
        make_player_tables(self.guitar, SimpleNamespace(places=self.places), RATE, self.d, self.i)
        self.open = [s.note for s in self.guitar.strings]
        self.strings = [BenchString() for _ in self.open]
        self.lead = int(self.i[at.I_LEAD])
        self.tick, self.frame, self.gestures = tick, 0, []
        self.d_start, self.i_start = at.D_STATE, at.I_STATE

    def send(self, frame, status, data1=0, data2=0):
        """Carry out what is due before ``frame``, then hand over one message."""
        self.run(frame)
        player_message(self.d, self.i, frame, status, data1, data2)

    def on(self, frame, key, velocity=80, channel=0):
        self.send(frame, 0x90 | channel, key, velocity)

    def off(self, frame, key, channel=0):
        self.send(frame, 0x80 | channel, key, 0)

    def cc(self, frame, controller, value, channel=0):
        self.send(frame, 0xB0 | channel, controller, value)

    def bend(self, frame, value, channel=0):
        self.send(frame, 0xE0 | channel, (value + 8192) & 127, (value + 8192) >> 7)

    def run(self, frame):
        """Carry out every gesture due before ``frame``."""
        if self.tick:
            first = -(-self.frame // 64) * 64
            for at_frame in range(first, frame, 64):
                self._execute(at_frame)
                player_tick(self.d, self.i, at_frame)
        self._execute(frame)
        self.frame = max(self.frame, frame)

    def _execute(self, before):
        while timeline_next(self.i, FAR) < before:
            row, values = layout.GESTURES_I, layout.GESTURES
            frame, kind, s = (int(v) for v in self.i[row : row + 3])
            p = tuple(float(v) for v in self.d[values : values + 5])
            timeline_drop_first(self.d, self.i)
            self.gestures.append((frame, kind, s, p))
            self._do(frame, kind, self.strings[s], p)

    @staticmethod
    def _do(frame, kind, string, p):
        string.events.append((frame, kind, p))
        if kind == do.PLUCK:
            string.sounding = int(p[4])
        elif kind == do.PRESS:
            string.place = p[0]
        elif kind == do.LIFT:
            string.place = 0.0
        elif kind == do.DAMP:
            string.damped, string.sounding = True, -1
        elif kind == do.UNDAMP:
            string.damped = False
        elif kind == do.TENSION:
            string.tension = p[0]

    def finish(self):
        """Let everything that is still on the timeline happen."""
        self.run(FAR // 2 if not self.tick else self.frame + 48000)

    def held(self):
        """String -> (key, channel, fret) of the notes that sound."""
        found = {}
        for s, note in enumerate(self.open):
            if self.i[at.S_STATE + s] in (at.HELD, at.PEDALLED):
                key, channel = int(self.i[at.S_KEY + s]), int(self.i[at.S_CHANNEL + s])
                found[s] = (key, channel, int(self.i[at.S_PITCH + s]) - note)
        return found

    @property
    def counters(self):
        return read_counters(self.i)

    @property
    def log(self):
        return read_note_log(self.d, self.i, RATE)

    @property
    def hand(self):
        return int(self.i[at.I_HAND])

    def plucks(self):
        return [(frame, s, p) for frame, kind, s, p in self.gestures if kind == do.PLUCK]


def check_plucks(bench):
    """Every release finds finger, damper and tension as its note wants them; gestures never go back in time."""
    place, damped, due = [0.0] * 6, [False] * 6, [None] * 6
    log = dict(enumerate(bench.log))
    frames = [frame for frame, _, _, _ in bench.gestures]
    assert frames == sorted(frames)

    def check_releases(now):
        for s, note in enumerate(due):
            if note and note["release_frame"] <= now:
                assert place[s] == (bench.places[s][note["fret"]] if note["fret"] else 0.0) and not damped[s]
                due[s] = None

    for frame, kind, s, p in bench.gestures:
        check_releases(frame)
        if kind == do.PRESS:
            assert place[s] == 0.0, "a finger lands on a string that has none"
            place[s] = p[0]
        elif kind == do.LIFT:
            assert place[s] > 0.0
            place[s] = 0.0
        elif kind == do.DAMP:
            damped[s], due[s] = True, None  # damped before its release: all sound off
        elif kind == do.UNDAMP:
            damped[s] = False
        elif kind == do.PLUCK:
            note = log[int(p[4])]
            assert note["string"] == s and note["release_frame"] == frame + bench.lead and not damped[s]
            due[s] = note
    check_releases(FAR)

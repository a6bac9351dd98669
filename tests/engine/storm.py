"""Random messages of every kind, played on a whole engine, and what is left once every key and pedal is up.

Enter an engine and a seed; leave what came of it, and sentences that say what is not as it was before the first
message, or should never be.
"""

from dataclasses import dataclass

import numpy as np

from ukrt.engine import controller_layout as cc
from ukrt.engine import layout as at
from ukrt.engine import player_layout as player
from ukrt.engine.kernels.midi_bytes import midi_byte
from ukrt.engine.kernels.motion import flow_back
from ukrt.engine.kernels.player_strings import rest_ratio

OFF, ON, KEY_PRESSURE, CONTROL, PROGRAM, PRESSURE, BEND, SYSTEM = range(0x80, 0x100, 0x10)
# How often each kind comes: notes most of all, so that something sounds that the others can act on.
KINDS = {OFF: 22, ON: 30, KEY_PRESSURE: 6, CONTROL: 24, PROGRAM: 2, PRESSURE: 5, BEND: 9, SYSTEM: 2}
PEDALS = (cc.PEDAL, cc.SOSTENUTO)  # what holds notes when no key does
BLOCK = 4096  # frames computed before more is sent
MOST_SENT = 8192  # messages: half of what a lane of the stage holds
SETTLING_SECONDS = 0.5  # in which dampers have done their work, and fingers, dampers and bends have gone
ALONG = 0.01  # of the most energy there was: what idle strings, which ring along, may hold when the others are damped


def random_messages(rng, count, per_second, rate):
    """Messages of every kind in every channel, with bytes of any value.

    Half of them are what an instrument in the hands of someone gets: two channels, keys that a guitar has, and of the
    controllers those that are followed. One in eight belongs to a registered parameter (RPN 0 to 6) and its data; SysEx
    comes among them, whole and broken off. Half of the messages come at the same frame as the one before.

    Parameters
    ----------
    rng : numpy.random.Generator
    count : int
    per_second, rate : float [Hz]
        Messages and frames in a second.

    Returns
    -------
    ndarray (count, 4) int64
        Frame, status and two data bytes, in order of time.
    """
    kinds, weights = list(KINDS), np.array(list(KINDS.values()), float)
    kind = rng.choice(kinds, count, p=weights / weights.sum())
    sane = rng.random(count) < 0.5
    channel = np.where(sane, rng.integers(0, 2, count), rng.integers(0, 16, count))
    data = rng.integers(0, 128, (count, 2))
    keyed = sane & np.isin(kind, (ON, OFF, KEY_PRESSURE))
    data[keyed, 0] = rng.integers(36, 92, np.count_nonzero(keyed))
    _meet_notes(rng, np.flatnonzero(keyed & (kind != ON)), np.flatnonzero(kind == ON), channel, data)
    played = sane & (kind == CONTROL)
    data[played, 0] = rng.choice(_followed(), np.count_nonzero(played))
    data[played & (data[:, 0] == cc.HARMONIC) & (rng.random(count) < 0.8), 1] = 0  # which are never slurred
    system = kind == SYSTEM
    channel[system] = rng.integers(0, 15, np.count_nonzero(system))
    channel[system & (rng.random(count) < 0.01)] = 15  # FF, which ends everything, not too often
    _registered(rng, kind, channel, data)
    gaps = np.where(rng.random(count) < 0.5, 0.0, rng.exponential(2.0 * rate / per_second, count))
    rows = np.column_stack([np.cumsum(gaps), kind + channel, data]).astype(np.int64)
    return _with_sysex(rng, rows)


def _with_sysex(rng, rows):
    """The same number of rows, some of them replaced by the pieces that SysEx leaves a parser in, if it leaves any."""
    state, found = np.zeros(1, np.int64), []
    for first in range(0, len(rows), 256):
        found.append(rows[first : first + 256])
        words = [midi_byte(state, 0, byte) for byte in _sysex(rng)]
        pieces = [[word >> 16, word >> 8 & 0xFF, word & 0xFF] for word in words if word >= 0]
        frame = np.full((len(pieces), 1), found[-1][-1, 0])
        found.append(np.hstack([frame, np.array(pieces, np.int64).reshape(-1, 3)]))
    return np.concatenate(found)[: len(rows)]


def _sysex(rng):
    """Bytes of a SysEx: volume and tunings of the whole guitar, of keys and scales, General MIDI, or anything; one in
    four is broken off."""
    what = (
        (0x7F, 0x7F, 4, rng.integers(1, 5), *rng.integers(0, 128, 2)),
        (0x7F, 0x7F, 8, 2, 0, 2, *rng.integers(0, 128, 8)),
        (0x7E, 0x7F, 8, 8, *rng.integers(0, 128, 15)),
        (0x7F, 0x7F, 8, 9, *rng.integers(0, 128, 27)),
        (0x7E, 0x7F, 9, rng.integers(1, 4)),
        tuple(rng.integers(0, 128, rng.integers(0, 40))),
    )[rng.integers(0, 6)]
    end = (0xF7,) if rng.random() < 0.75 else ()
    return [int(byte) for byte in (0xF0, *what, *end)]


def _meet_notes(rng, followers, begun, channel, data):
    """Give note-offs and pressures the channel and key of one of the six notes that began last."""
    which = np.searchsorted(begun, followers) - 1 - rng.integers(0, 6, len(followers))
    followers, which = followers[which >= 0], which[which >= 0]
    channel[followers], data[followers, 0] = channel[begun[which]], data[begun[which], 0]


def _followed():
    """Numbers of the controllers that mean something, but for those that end notes."""
    numbers = {value for name, value in vars(cc).items() if name.isupper() and isinstance(value, int)}
    return sorted(numbers - {cc.SOUND_OFF, cc.RESET, cc.NOTES_OFF})


def _registered(rng, kind, channel, data):
    """Put whole registered parameters among the messages: which one, in two bytes, and its data, in two more."""
    for first in range(0, len(kind) - 4, 32):
        kind[first : first + 4], channel[first : first + 4] = CONTROL, channel[first] % 16
        data[first : first + 4, 0] = cc.RPN_MSB, cc.RPN_LSB, cc.DATA_MSB, cc.DATA_LSB
        data[first, 1], data[first + 1, 1] = 0, rng.integers(0, 7)


@dataclass(frozen=True)
class Outcome:
    """What came of a storm.

    Attributes
    ----------
    sound_s : float [s]
        Its length.
    largest : float
        Largest sample of the sound, infinity where one was no number.
    held_after_off, pedalled : int
        Strings whose key is down after CC 123 on every channel, and those that only pedals held then.
    left : list of str
        What is not as it was before the first message, `SETTLING_SECONDS` after the last pedal came up.
    loudest_j, before_j, after_j : float [J]
        The most energy there was, that when the keys came up, and that when the settling time was over.
    rests_j : ndarray [J]
        Energy from then on, every 10 ms.
    bound_j : ndarray [J]
        And the most there may be, if nothing decays more slowly than its slowest mode does.
    counters : dict
    """

    sound_s: float
    largest: float
    held_after_off: int
    pedalled: int
    left: list
    loudest_j: float
    before_j: float
    after_j: float
    rests_j: np.ndarray
    bound_j: np.ndarray
    counters: dict

    def complaints(self):
        """What should not be, in words (list of str)."""
        counts, found = self.counters, list(self.left)
        heard = counts["notes_played"] + counts["notes_dropped"] + counts["notes_percussion"]
        wrong = {
            "a sample is no number": not np.isfinite(self.largest) or counts["nonfinite_resets"] > 0,
            f"{self.held_after_off} keys are down after CC 123": self.held_after_off > 0,
            f"{counts['notes_on']} notes came, {heard} were played, dropped or percussion": counts["notes_on"] != heard,
            "messages were lost": counts["midi_dropped"] > 0,
            "gestures were refused": counts["gestures_refused"] > 0,
            f"of {self.loudest_j:.1e} J there are {self.after_j:.1e} J": self.after_j > ALONG * self.loudest_j,
            "energy rises though nothing moves": bool(np.any(np.diff(self.rests_j) > 0.0)),
            "energy falls too slowly": bool(np.any(self.rests_j > 1.001 * self.bound_j)),
        }
        return found + [words for words, is_so in wrong.items() if is_so]


def storm(engine, seed, count, per_second, rest_seconds=1.0):
    """Play ``count`` random messages, let everything go, listen to what is left (Outcome)."""
    engine.reset()
    messages = random_messages(np.random.default_rng(seed), count, per_second, engine.sample_rate)
    largest, loudest = play(engine, messages)
    before = engine.energy()
    held, pedalled = let_go(engine)
    engine.process(round(SETTLING_SECONDS * engine.sample_rate))
    left, rests = leftovers(engine), energies(engine, rest_seconds)
    falls = np.exp(-2.0 * slowest_decay(engine) * 0.01 * np.arange(len(rests)))
    sound_s = messages[-1, 0] / engine.sample_rate
    found = (left, loudest, before, rests[0], rests, rests[0] * falls, engine.counters())
    return Outcome(sound_s, largest, held, pedalled, *found)


def play(engine, messages):
    """Play messages from where the engine is on: the largest sample of the sound, or infinity, and the most energy."""
    start, sent, largest, loudest = engine.frame, 0, 0.0, 0.0
    frames = messages[:, 0]
    while sent < len(messages):
        due = min(int(np.searchsorted(frames, engine.frame - start + BLOCK)), sent + MOST_SENT)
        for frame, *message in messages[sent:due].tolist():
            assert engine.send(max(start + frame, engine.frame), *message), "the engine's queue is full"
        sent = due
        until = BLOCK if due == len(messages) or frames[due] >= engine.frame - start + BLOCK else 1
        block = engine.process(until)
        largest = max(largest, np.abs(block).max()) if np.isfinite(block).all() else np.inf
        loudest = max(loudest, engine.energy())
    return largest, loudest


def let_go(engine):
    """Every key up, then every pedal: strings that are held after the first, and strings that only pedals held."""
    _send_all(engine, cc.NOTES_OFF)
    engine.process(1)
    states = engine._i[player.S_STATE : player.S_STATE + len(engine.guitar.strings)]
    held, pedalled = (int(np.count_nonzero(states == state)) for state in (player.HELD, player.PEDALLED))
    for pedal in PEDALS:
        _send_all(engine, pedal)
    engine.process(1)
    return held, pedalled


def _send_all(engine, controller):
    for channel in range(16):
        engine.send(engine.frame, CONTROL | channel, controller, 0)


def leftovers(engine):
    """What is not as it was before the first message (list of str): notes, hands, ramps, gestures, tensions."""
    d, i, found = engine._d, engine._i, []
    damped = engine.guitar.playing.idle_strings == "damped"
    at_rest = rest_ratio(i)
    if i[at.H_GESTURES] or i[at.H_BUSY]:
        found.append(f"{i[at.H_GESTURES]} gestures wait, busy {i[at.H_BUSY]}")
    for s in range(len(engine.guitar.strings)):
        own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
        state = {
            "the player's state": i[player.S_STATE + s] != player.IDLE,
            "a finger": i[own_i + at.SI_FINGER] > 0,
            "a pluck": i[own_i + at.SI_PLUCK] > 0,
            "no damper" if damped else "a damper": (i[own_i + at.SI_DAMPER] > 0) != damped,
            "a touch": d[own + at.S_TOUCH_PLACE] > 0.0,
            "a vibrato": d[player.D_DEPTH + s] != 0.0,
            "a bend": not np.allclose((d[own + at.S_RATIO], d[player.D_TENSION + s]), at_rest, rtol=1e-12, atol=0.0),
        }
        found += [f"string {s} has {what}" for what, there in state.items() if there]
    return found


def slowest_decay(engine):
    """The least decay rate of all modes of strings and body [1/s]: nothing that sounds dies away more slowly."""
    d, i = engine._d, engine._i
    losses = [d[at.BODY_B : at.BODY_B + 8 * i[at.H_BODY]]]
    for s in range(len(engine.guitar.strings)):
        own_i = at.STRING_I + s * at.STRING_I_SIZE
        tiles = range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES])
        losses.append([flow_back(d, at.COEF + t * at.COEF_TILE + lane) for t in tiles for lane in range(at.TILE)])
    b = np.concatenate(losses)
    return float(np.min(-0.5 * np.log(-b[b < 0.0])) * engine.sample_rate)


def energies(engine, seconds):
    """Energy [J] now and after every 10 ms of ``seconds`` (ndarray)."""
    found = [engine.energy()]
    for _ in range(round(100 * seconds)):
        engine.process(round(0.01 * engine.sample_rate))
        found.append(engine.energy())
    return np.array(found)

"""What the probe plays: numbers enter; frames, messages and marks leave, the same for the same seed."""

import random

RATE = 48000
_NOTES = (40, 45, 50, 55, 59, 64)  # the open strings
_PRESSURE, _NOTE_ON, _NOTE_OFF = 0xA0, 0x90, 0x80
COUNTED = 1 << 18  # what channel and two data bytes of a polyphonic pressure can count to


def single_notes(count, gap, spread, seed=1):
    """Single notes of 10 ms, marked, ``gap`` to ``gap + spread`` frames apart, which is silence for the most part."""
    chance, frames, messages, marks, now = random.Random(seed), [], [], [], 0
    for k in range(count):
        note = _NOTES[k % len(_NOTES)] + chance.randrange(4)
        frames += [now, now + RATE // 100]
        messages += [bytes((_NOTE_ON, note, 100)), bytes((_NOTE_OFF, note, 64))]
        marks += [True, False]
        now += gap + chance.randrange(spread)
    return frames, messages, marks


def steady(rate, seconds, seed=1):
    """``rate`` messages a second, evenly: numbered ones, and notes on and off on six strings among them."""
    count = int(rate * seconds)
    frames = [k * RATE // rate for k in range(count)]
    return frames, _numbered(count, seed), [False] * count


def bursts(size, count, pause, seed=1):
    """``count`` bursts of ``size`` messages, each burst at one frame, ``pause`` [s] apart."""
    frames = [int(k * pause * RATE) for k in range(count) for _ in range(size)]
    return frames, _numbered(size * count, seed), [False] * (size * count)


def _numbered(count, seed):
    """Each message tells its number; each twentieth pair is a note on and the same note's off instead."""
    chance, messages = random.Random(seed), []
    note = _NOTES[0]
    for k in range(count):
        place = k % 40
        if place == 0:
            note = chance.choice(_NOTES) + chance.randrange(4)
            messages.append(bytes((_NOTE_ON, note, chance.randrange(40, 120))))
        elif place == 20:
            messages.append(bytes((_NOTE_OFF, note, 64)))
        else:
            messages.append(bytes((_PRESSURE | k >> 14 & 0x0F, k >> 7 & 0x7F, k & 0x7F)))
    return messages


SCHEDULES = {"single_notes": single_notes, "steady": steady, "bursts": bursts}

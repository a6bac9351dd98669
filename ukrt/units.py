"""Musical and audio units: MIDI note numbers, hertz, cents, decibels; scalars or arrays enter, the same leave."""

import numpy as np

MIDI_A4 = 69  # MIDI 1.0: note 60 is middle C, so the A above it is 69
A4_HZ = 440.0  # ISO 16


def midi_to_hz(note, a4_hz=A4_HZ):
    """Frequency of an equal-tempered (possibly fractional) MIDI note."""
    return _out(a4_hz * np.exp2((np.asarray(note, float) - MIDI_A4) / 12.0))


def hz_to_midi(hz, a4_hz=A4_HZ):
    """Fractional MIDI note of a frequency."""
    return _out(MIDI_A4 + 12.0 * np.log2(np.asarray(hz, float) / a4_hz))


def ratio_to_cents(ratio):
    """Hundredths of an equal-tempered semitone in a ratio of frequencies."""
    return _out(1200.0 * np.log2(np.asarray(ratio, float)))


def cents_to_ratio(cents):
    """Ratio of frequencies of an interval in cents."""
    return _out(np.exp2(np.asarray(cents, float) / 1200.0))


def db_to_gain(db):
    """Amplitude ratio of a level difference in decibels."""
    return _out(10.0 ** (np.asarray(db, float) / 20.0))


def gain_to_db(gain):
    """Level difference in decibels of an amplitude ratio; 0 gives minus infinity."""
    with np.errstate(divide="ignore"):
        return _out(20.0 * np.log10(np.abs(np.asarray(gain, float))))


def _out(value):
    return float(value) if np.ndim(value) == 0 else value

"""Measuring poles in signals: sub-band, matrix pencil, pitch of notes, poles of a stepped linear system."""

from .kernel_poles import poles_from_records, poles_from_steps
from .poles_from_signal import Component, cents_above, fit_pole, fit_poles, note_components, note_pitch_cents

__all__ = [
    "Component",
    "cents_above",
    "fit_pole",
    "fit_poles",
    "note_components",
    "note_pitch_cents",
    "poles_from_records",
    "poles_from_steps",
]

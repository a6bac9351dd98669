"""Independent check of the instrument: poles and admittances of the coupled guitar from continuous receptances, without
the model."""

from .admittance import OnBridge, OnString, admittance, admittance_residues, bridge_forces
from .constants import BODY, STRINGS, BodyData, ContactData, StringData, make_body, make_guitar
from .continuous import System, decay, frequency, make_system, poles
from .contour import poles_between
from .loudness import bridge_residues, loudest_near, loudest_partials, span_share
from .partials import body_poles, rigid_guess, string_like, string_partials

__all__ = [
    "BODY", "STRINGS", "BodyData", "ContactData", "OnBridge", "OnString", "StringData", "System", "admittance",
    "admittance_residues", "body_poles", "bridge_forces", "bridge_residues", "decay", "frequency", "loudest_near",
    "loudest_partials", "make_body", "make_guitar", "make_system", "poles", "poles_between", "rigid_guess",
    "span_share", "string_like", "string_partials",
]

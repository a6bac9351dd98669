"""Independent check of the instrument: poles of the coupled guitar from continuous receptances, without the model."""

from .constants import BODY, STRINGS, BodyData, ContactData, StringData, make_body, make_guitar
from .continuous import System, decay, frequency, make_system, poles
from .contour import poles_between
from .partials import body_poles, bridge_residues, span_share, string_like, string_partials

__all__ = [
    "BODY", "STRINGS", "BodyData", "ContactData", "StringData", "System", "body_poles", "bridge_residues", "decay",
    "frequency", "make_body", "make_guitar", "make_system", "poles", "poles_between", "span_share", "string_like",
    "string_partials",
]

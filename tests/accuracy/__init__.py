"""Either solver's poles against the oracle's, note by note: what tools/pole_table.py prints and the tests bound."""

from .compare import (
    PAPER,
    PAPER_STEP,
    Comparison,
    Scheme,
    Theory,
    cents_between,
    compare,
    errors,
    nearest_poles,
    note_system,
)
from .engine_records import engine_record
from .limits import broken_limits, limits
from .notes import ALL_FRETS, CONTACTS, PARTIALS, Note, all_notes, linear_guitar
from .reference_records import reference_record
from .truth import cut_poles, oracle_poles, oracle_system

__all__ = [
    "ALL_FRETS",
    "CONTACTS",
    "PAPER",
    "PAPER_STEP",
    "PARTIALS",
    "Comparison",
    "Note",
    "Scheme",
    "Theory",
    "all_notes",
    "broken_limits",
    "cents_between",
    "compare",
    "cut_poles",
    "engine_record",
    "errors",
    "limits",
    "linear_guitar",
    "nearest_poles",
    "note_system",
    "oracle_poles",
    "oracle_system",
    "reference_record",
]

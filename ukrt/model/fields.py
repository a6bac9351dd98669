"""Declaring a parameter once: its unit, its legal range and one line of words live on the dataclass field as data, and
construction, presets, command line and tables all read them from there."""

import dataclasses
import math
import numbers
from dataclasses import MISSING

from ..errors import ParameterError


@dataclasses.dataclass(frozen=True)
class Legal:
    """What a field may hold.

    Attributes
    ----------
    kind : str
        ``number``, ``integer``, ``flag``, ``text``, ``choice``, ``numbers`` or ``texts`` (tuples), ``part`` (another
        dataclass) or ``parts`` (a tuple of them).
    unit : str
        SI unit, empty for a pure number or words.
    low, high : float
        Range, both ends legal. For ``parts``, ``numbers`` and ``texts`` ``count`` bounds their number.
    """

    kind: str
    doc: str
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    count: tuple = (0, 0)
    choices: tuple = ()
    part: type = None

    @property
    def words(self):
        """The legal values as the end of a sentence."""
        unit = f" {self.unit}" if self.unit else ""
        span = f"from {self.low:g} to {self.high:g}{unit}"
        match self.kind:
            case "number":
                return f"a number {span}"
            case "integer":
                return f"a whole number {span}"
            case "flag":
                return "true or false"
            case "text":
                return "text in quotes"
            case "choice":
                return " or ".join(f'"{c}"' for c in self.choices)
            case "numbers":
                return f"a list of {self.count[0]} to {self.count[1]} numbers {span}"
            case "texts":
                return f"a list of {self.count[0]} to {self.count[1]} texts in quotes"
            case "part":
                return "a table"
            case _:
                return f"a list of {self.count[0]} to {self.count[1]} tables"


def number(unit, low, high, doc, default=MISSING):
    """A real number; ``unit`` is empty where it has none."""
    return _declare(Legal("number", doc, unit, low, high), default)


def integer(low, high, doc, default=MISSING, unit=""):
    return _declare(Legal("integer", doc, unit, low, high), default)


def flag(doc, default=MISSING):
    return _declare(Legal("flag", doc), default)


def text(doc, default=MISSING):
    return _declare(Legal("text", doc), default)


def choice(choices, doc, default=MISSING):
    return _declare(Legal("choice", doc, choices=tuple(choices)), default)


def numbers_list(unit, low, high, count, doc, default=MISSING):
    """A tuple of ``count = (fewest, most)`` numbers."""
    return _declare(Legal("numbers", doc, unit, low, high, count), default)


def texts_list(count, doc, default=MISSING):
    """A tuple of ``count = (fewest, most)`` texts."""
    return _declare(Legal("texts", doc, count=count), default)


def part(cls, doc, default=MISSING):
    """Another parameter class."""
    return _declare(Legal("part", doc, part=cls), default)


def parts(cls, count, doc, default=MISSING):
    """A tuple of ``count = (fewest, most)`` objects of another parameter class."""
    return _declare(Legal("parts", doc, count=count, part=cls), default)


def legal(cls, name):
    """The `Legal` of field ``name`` of parameter class ``cls``."""
    return cls.__dataclass_fields__[name].metadata["legal"]


def describe(cls, prefix=""):
    """Every field of ``cls`` and of its parts as ``(dotted key, Legal, default)``, lists shown with ``N`` as index."""
    for field in dataclasses.fields(cls):
        rule, key = field.metadata["legal"], prefix + field.name
        if rule.kind == "part":
            yield from describe(rule.part, f"{key}.")
        elif rule.kind == "parts":
            yield from describe(rule.part, f"{key}.N.")
        else:
            yield key, rule, None if field.default is MISSING else field.default


class Checked:
    """Base of parameter classes: on construction every field is checked against its `Legal` and brought to plain Python
    numbers, then `cross_check` may refuse combinations."""

    def __post_init__(self):
        for field in dataclasses.fields(self):
            value = check(field.metadata["legal"], getattr(self, field.name), field.name)
            object.__setattr__(self, field.name, value)
        self.cross_check()

    def cross_check(self):
        """Refuse combinations of values that are legal one by one."""


def check(rule, value, key):
    """``value`` as plain Python data of ``rule.kind``, or `ParameterError` naming ``key``."""
    match rule.kind:
        case "number" | "integer":
            return _checked_number(rule, value, key)
        case "flag":
            ok = isinstance(value, bool)
        case "text":
            ok = isinstance(value, str) and value.encode("utf-8", "replace").decode() == value  # no lone surrogates
        case "choice":
            ok = value in rule.choices
        case "part":
            ok = isinstance(value, rule.part)
        case _:
            return _checked_tuple(rule, value, key)
    if not ok:
        raise ParameterError(key, value, f"it must be {rule.words}")
    return value


def _declare(rule, default):
    return dataclasses.field(default=default, metadata={"legal": rule})


def _checked_number(rule, value, key, words=None):
    legal_words = f"it must be {words or rule.words}"
    whole = rule.kind == "integer"
    if isinstance(value, bool) or not isinstance(value, numbers.Integral if whole else numbers.Real):
        raise ParameterError(key, value, legal_words)
    value = int(value) if whole else float(value) + 0.0  # + 0.0 turns -0.0 into 0.0
    if not rule.low <= value <= rule.high:  # also refuses NaN
        raise ParameterError(key, value, legal_words)
    return value


def _checked_tuple(rule, value, key):
    fewest, most = rule.count
    if isinstance(value, (str, bytes, dict)) or not hasattr(value, "__len__") or not fewest <= len(value) <= most:
        raise ParameterError(key, value, f"it must be {rule.words}")
    if rule.kind == "numbers":
        one = Legal("number", rule.doc, rule.unit, rule.low, rule.high)
        return tuple(_checked_number(one, v, f"{key}.{n}") for n, v in enumerate(value))
    if rule.kind == "texts":
        return tuple(check(Legal("text", rule.doc), v, f"{key}.{n}") for n, v in enumerate(value))
    for n, v in enumerate(value):
        if not isinstance(v, rule.part):
            raise ParameterError(f"{key}.{n}", v, f"it must be a {rule.part.__name__}")
    return tuple(value)

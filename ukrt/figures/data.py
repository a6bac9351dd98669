"""What a figure is made of: arrays behind its curves, numbers to compare with the paper's, and sounds."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Number:
    """One number that can be compared.

    Attributes
    ----------
    what : str
        In words.
    value : float
    unit : str
    paper : str
        What the paper says or shows, in words; how it was read from it.
    agrees : bool or None
        None where the paper gives nothing to agree with.
    note : str
        Why it differs, or how it was taken.
    """

    what: str
    value: float
    unit: str
    paper: str
    agrees: bool | None = None
    note: str = ""


@dataclass(frozen=True)
class FigureData:
    """A figure before it is drawn.

    Attributes
    ----------
    arrays : dict of str to ukrt.experiment.result.Quantity
        The data behind every curve, axes included.
    numbers : tuple of Number
    sounds : dict of str to (float [Hz], ndarray (n,) or (n, channels))
        Name of the file without its ending; samples within -1 and 1.
    cases : tuple of ukrt.experiment.case.Case
        What was run.
    """

    arrays: dict
    numbers: tuple = ()
    sounds: dict = field(default_factory=dict)
    cases: tuple = ()

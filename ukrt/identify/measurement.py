"""Measured responses of the bridge: arrays enter, are checked, and leave as one `Measurement` of a few paths, each from
the end of the bridge that is driven to the end whose motion is measured."""

import dataclasses

import numpy as np

from ..errors import MeasurementError

ENDS = ("bass", "treble")
POWERS = {"displacement": 0, "velocity": 1, "acceleration": 2}  # of s, over the receptance
UNITS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}
PATHS = {f"{drive}-{response}": (d, r) for d, drive in enumerate(ENDS) for r, response in enumerate(ENDS)}
# What responses are when nothing says which: by their number
DEFAULT_PATHS = {
    1: ("bass-bass",),
    2: ("bass-bass", "bass-treble"),
    3: ("bass-bass", "bass-treble", "treble-treble"),
    4: ("bass-bass", "bass-treble", "treble-bass", "treble-treble"),
}
CEILING_SAMPLES = (
    8  # at the largest value, of them CEILING_RUN in a row: no free decay does that, a full converter does
)
CEILING_RUN = 3


@dataclasses.dataclass(frozen=True)
class Record:
    """What one file holds.

    Attributes
    ----------
    samples : ndarray (n, k)
        Impulse responses in the file's unit.
    sample_rate : float [Hz]
    source : str
        The file, for messages.
    names : tuple of str, optional
        Paths such as ``bass-treble``, where the file itself tells.
    periodic : bool
        The responses come from admittances: what rings longer than the record is folded to its beginning.
    """

    samples: np.ndarray
    sample_rate: float
    source: str
    names: tuple | None = None
    periodic: bool = False


@dataclasses.dataclass(frozen=True)
class Measurement:
    """Impulse responses between the two ends of the bridge.

    Attributes
    ----------
    responses : ndarray (n, k) [m, m/s or m/s^2 per N s]
    sample_rate : float [Hz]
    paths : tuple of str
        For each response ``drive-response``, a key of `PATHS`.
    quantity : str
        A key of `POWERS`.
    periodic : bool
    sources : tuple of str
        Files, for what is said about the result.
    """

    responses: np.ndarray
    sample_rate: float
    paths: tuple
    quantity: str = "velocity"
    periodic: bool = False
    sources: tuple = ()

    @property
    def seconds(self):
        """Length of the record [s]."""
        return len(self.responses) / self.sample_rate

    def spectra(self):
        """Transfer functions of the whole record, [m, m/s or m/s^2 per N].

        Returns
        -------
        frequencies : ndarray (m,) [Hz]
        values : ndarray (m, k) complex
        """
        values = np.fft.rfft(self.responses, axis=0) / self.sample_rate
        return np.fft.rfftfreq(len(self.responses), 1.0 / self.sample_rate), values


def make_measurement(records, paths=None, quantity="velocity", scale=1.0, taps=False):
    """Join records of one instrument.

    Parameters
    ----------
    records : list of Record
    paths : list of (tuple of str or None), optional
        Per record the paths of its responses; where it is None the record's own names count, and where no record has
        any, `DEFAULT_PATHS` by the number of all responses.
    quantity : str
    scale : float
        Unit of the quantity per N s (with ``taps`` per N) for each unit in the file.
    taps : bool
        The samples answer to 1 N that lasts one sample, as `ukrt ir` writes them, not to 1 N s.

    Returns
    -------
    Measurement

    Raises
    ------
    MeasurementError
        Rates or lengths differ, a path comes twice, no driving point, silence, overload, values that are no numbers.
    """
    if not records:
        raise MeasurementError("no measurement was given, but at least the response of one driving point is needed")
    paths = list(paths or [None] * len(records))
    _check_alike(records)
    names = _names(records, paths)
    for record in records:
        check_signal(record.samples, record.source)
    rate = records[0].sample_rate
    responses = np.concatenate([record.samples for record in records], axis=1) * (scale * (rate if taps else 1.0))
    sources = tuple(dict.fromkeys(record.source for record in records))
    return Measurement(responses, rate, names, quantity, records[0].periodic, sources)


def check_signal(samples, source):
    """Refuse what is not finite, silent or overloaded; ``samples`` (n, k), full scale 1 where that means anything."""
    if not np.isfinite(samples).all():
        raise MeasurementError(f"{source} holds values that are not finite numbers, but every one must be a number")
    for n, column in enumerate(samples.T):
        where = source if samples.shape[1] == 1 else f"{source}, response {n + 1}"
        if np.ptp(column) == 0.0:
            raise MeasurementError(f"{where} is silent: every sample is {column[0]:g}, but a signal is needed")
        if is_clipped(column):
            raise MeasurementError(
                f"{where} is clipped: it stays at its largest value {np.abs(column).max():g} for many samples, but a "
                "response must fit into the converter's range"
            )


def is_clipped(column):
    """Whether a signal (n,) sits on a ceiling (bool)."""
    size = np.abs(column)
    top = (size >= size.max() * (1.0 - 1e-6)).astype(int)
    runs = np.convolve(top, np.ones(CEILING_RUN, int), "valid")
    return bool(top.sum() >= CEILING_SAMPLES and runs.max(initial=0) == CEILING_RUN)


def _check_alike(records):
    first = records[0]
    for other in records[1:]:
        if other.periodic != first.periodic:
            raise MeasurementError(
                f"{first.source} and {other.source} are an impulse response and an admittance, mixed"
            )
        if other.sample_rate != first.sample_rate:
            raise MeasurementError(
                f"{other.source} has a sample rate of {other.sample_rate:g} Hz, but {first.source} has "
                f"{first.sample_rate:g} Hz: all must have the same"
            )
        if len(other.samples) != len(first.samples):
            raise MeasurementError(
                f"{other.source} has {len(other.samples)} samples, but {first.source} has {len(first.samples)}: all "
                "must have the same length"
            )


def _names(records, paths):
    """The path of every response, in order (tuple of str)."""
    given = [path or record.names for path, record in zip(paths, records, strict=True)]
    count = sum(record.samples.shape[1] for record in records)
    if all(one is None for one in given):
        if count not in DEFAULT_PATHS:
            raise MeasurementError(f"there are {count} responses, but two ends of a bridge have 1 to 4")
        return DEFAULT_PATHS[count]
    for one, record in zip(given, records, strict=True):
        found = record.samples.shape[1]
        if one is None:
            raise MeasurementError(
                f"{record.source} does not say what it is while others do: write {record.source}@bass-treble for force "
                "at the bass and motion at the treble end, for every file or for none"
            )
        if len(one) != found:
            raise MeasurementError(f"{record.source} holds {found} responses, but {len(one)} paths are named for it")
    names = tuple(name for one in given for name in one)
    for n, name in enumerate(names):
        if name not in PATHS:
            raise MeasurementError(f"{name} is no path from drive to response, legal are {', '.join(PATHS)}")
        if name in names[:n]:
            raise MeasurementError(f"the response {name} is given twice, but each path from drive to response once")
    if not {"bass-bass", "treble-treble"} & set(names):
        raise MeasurementError(
            f"only {', '.join(names)} is given, but masses need a driving point: bass-bass or treble-treble"
        )
    return names

"""A case on the real-time engine's own compiled loop: a `Case` enters, a `Result` leaves. Players, hosts and radiation
stay outside; strings keep the tensions that the case gives them."""

import time
from types import SimpleNamespace

import numpy as np

from ..engine import layout as at
from ..engine.discretize import fill_instance, make_arrays
from ..engine.kernels.advance import advance
from ..engine.kernels.hands import perform
from ..errors import ParameterError
from ..experiment.result import Result
from ..model.body import body_modes
from ..model.strings import string_modes
from .observe import KEPT_AT_ONCE, EngineObserver
from .schedule import gestures_of

SAME_BASIS = 1e-9  # of the cut modes' compliance is left where there shall be none: none at all has no Cholesky factor


def simulate(case, residual=True, progress=None):
    """Run a case at ``case.sample_rate``.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
        Times are rounded to whole samples.
    residual : bool
        False: without pseudo-modes for what the basis cuts, so that the engine has the reference's basis and no more.
    progress : callable, optional
        Called with the share that is done, 0 to 1.

    Returns
    -------
    ukrt.experiment.result.Result
        Positions and forces at the same instants; energies are the scheme's own, see ukrt/simulate/README.md.

    Raises
    ------
    ParameterError
        Two plucks at once on one string, a contact on the nut, a sample rate too low for the basis.
    """
    began = time.perf_counter()
    rate = case.sample_rate
    todo = gestures_of(case, rate)
    d, i = make_arrays()
    _fill(d, i, case, 1.0 if residual else SAME_BASIS)
    n_steps = int(round(case.duration * rate))
    keep = max(1, int(np.ceil(rate / case.record.rate_hz - 1e-9)))
    hands, observer = _Hands(d, i, todo), EngineObserver(case, d, i, keep / rate)
    n_kept, busy = n_steps // keep + 1, True
    for k in range(n_kept):
        observer.before(busy)
        busy = hands.advance_to(k * keep + 1)
        observer.after()
        busy |= hands.advance_to((k + 1) * keep)
        if progress and (k + 1) % KEPT_AT_ONCE == 0:
            progress((k + 1) / n_kept)
    observer.flush()
    if progress:
        progress(1.0)
    facts = {
        "steps": n_steps,
        "step_s": 1.0 / rate,
        "modes": _count_modes(case),
        "residual": residual,
        "largest_drift_m": observer.largest_drift,
        "seconds_taken": time.perf_counter() - began,
    }
    return Result(case, "engine", observer.times, observer.quantities(), facts)


class _Hands:
    """Advances the instance, gestures included."""

    def __init__(self, d, i, todo):
        self._d, self._i, self._todo, self._frame = d, i, todo, 0

    def advance_to(self, frame):
        """Compute up to ``frame``; returns whether a gesture was under way."""
        d, i, todo, now, busy = self._d, self._i, self._todo, self._frame, False
        while now < frame:
            while todo and todo[0].frame <= now:
                one = todo.pop(0)
                perform(d, i, one.kind, one.string, *one.numbers)
            stop = min(frame, now + at.CHUNK, todo[0].frame if todo else frame)
            busy = busy or i[at.H_BUSY] != 0
            advance(d, i, stop - now)
            now = stop
        self._frame = now
        return busy


def _fill(d, i, case, residual):
    """Write the instance at the strings' own tensions; complaints name the case's keys."""
    guitar = case.instrument
    tensions = SimpleNamespace(tensions=[string.tension for string in guitar.strings])
    try:
        fill_instance(d, i, guitar, tensions, case.sample_rate, residual)
    except ParameterError as error:
        raise error.under("guitar") if error.key.startswith("basis.") else error from None


def _count_modes(case):
    """Modal coordinates of strings, body and the fingers there at the end; pseudo-modes not counted."""
    guitar = case.instrument
    strings = sum(string_modes(string, guitar.basis.bandwidth_hz).count for string in guitar.strings)
    fingers = sum(point.has_mode for row in case.held_points(case.duration) for point in row)
    return 2 * strings + body_modes(guitar.body).count + 2 * fingers

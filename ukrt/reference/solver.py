"""A case integrated by the paper's scheme: a `Case` enters, a `Result` leaves. Every set of held points is one
`ReferenceSystem`; where it changes, strings and body go on from where they are."""

import time
from dataclasses import dataclass

import numpy as np

from ..errors import ParameterError
from ..experiment.result import Result
from . import compiled, definition
from .landing import Landing
from .observe import Observer
from .system import make_system

FORMS = {"compiled": compiled.run, "numpy": definition.run}
CHUNK = 256  # kept samples that are computed at once
UNBOUNDED = 1e3  # m: no string goes that far


@dataclass(frozen=True)
class Stretch:
    """A part of a run in which the same points are held: steps from ``first`` to before ``last``."""

    first: int
    last: int
    held: tuple


def simulate(case, form="compiled", damping_velocity="predicted", progress=None):
    """Run a case.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
    form : {"compiled", "numpy"}
        The same steps: quick, or as they are defined.
    damping_velocity : {"predicted", "half-step"}
        See `ukrt.reference.definition`.
    progress : callable, optional
        Called with the share that is done, 0 to 1.

    Returns
    -------
    ukrt.experiment.result.Result

    Raises
    ------
    ParameterError
        A step too long for the basis (Verlet is stable below omega dt = 2), or with which the motion grew without end.
    """
    began = time.perf_counter()
    guitar, step = case.instrument, case.step
    n_steps = int(round(case.duration / step))
    keep = max(1, int(np.ceil(1.0 / (case.record.rate_hz * step) - 1e-9)))
    check_step(make_system(guitar, case.held_points(0.0)), step)
    observer, system, motion, landing = Observer(case), None, None, None
    for part in stretches(case, n_steps):
        system, motion, landing = _next_system(case, part, system, motion, landing)
        if not len(observer.times):
            observer.start(system, motion)
        pushes, shapes = _pushes(case, system)
        first = part.first
        while first < part.last:
            last = min(first + CHUNK * keep, part.last)
            at = step * np.arange(first + 1, last + 1)
            b = landing.accelerations(at, step)
            kept = range((-first - 1) % keep, last - first, keep)
            found = FORMS[form](system, motion, step, pushes(at), shapes, b, kept, damping_velocity)
            check_motion(motion, step, last * step)
            observer.observe(system, at[kept.start :: keep], *found, landing)
            first = last
            if progress:
                progress(last / n_steps)
    facts = {
        "steps": n_steps,
        "step_s": step,
        "modes": int(system.count),
        "form": form,
        "damping_velocity": damping_velocity,
        "largest_drift_m": observer.largest_drift,
        "seconds_taken": time.perf_counter() - began,
    }
    return Result(case, "reference", observer.times, observer.quantities(), facts)


def check_step(system, step):
    """Refuse a step that velocity-Verlet cannot make stably: omega dt must stay below 2."""
    highest = float(np.sqrt(np.max(system.stiffness / system.mass)))
    if highest * step >= 2.0:
        words = f"it must be below {2.0 / highest:.3g} s, the limit of velocity-Verlet for the fastest mode"
        raise ParameterError("step", step, words)


def check_motion(motion, step, time):
    """Refuse a step with which the motion (3, n) has grown beyond all bounds: dampers and stretching may ask for less.

    Of a pure damper alone the limit is c h phi M^-1 phi^T < 1 with the predicted velocity.
    """
    if not (np.abs(motion[0]) < UNBOUNDED).all():
        words = f"it is too long for this case: at {time:.3g} s the motion had grown beyond all bounds"
        raise ParameterError("step", step, words)


def stretches(case, n_steps):
    """Parts of the run with constant held points, cut at whole steps (list of Stretch)."""
    times = {0.0} | {one.start for one in case.held} | {one.end for one in case.held}
    cuts = sorted({int(round(t / case.step)) for t in times if t < case.duration} | {n_steps})
    parts = []
    for first, last in zip(cuts[:-1], cuts[1:], strict=True):
        held = case.held_points(0.5 * (first + last) * case.step)
        if parts and parts[-1].held == held:
            first = parts.pop().first
        parts.append(Stretch(first, last, held))
    return parts


def _next_system(case, part, before, motion, landing):
    """System, motion and landings of a part of the run: strings and body go on, fingers that stay keep their motion."""
    guitar, time = case.instrument, part.first * case.step
    system = make_system(guitar, part.held)
    fresh = np.zeros((3, system.count))
    if before is None:
        return system, fresh, Landing.none(system, guitar.finger.landing_time)
    same = before.body.stop
    fresh[:, :same] = motion[:, :same]
    known = {point: k for k, point in enumerate(before.points)}
    stays = {k: known[point] for k, point in enumerate(system.points) if point in known}
    for k, old in stays.items():
        if system.finger_of[k] is not None:
            for new_on, old_on in ((system.fingers_y, before.fingers_y), (system.fingers_z, before.fingers_z)):
                there, here = old_on.start + before.finger_of[old], new_on.start + system.finger_of[k]
                fresh[:, here] = motion[:, there]
    landing = landing.onto(system, fresh, stays, time)
    pushes, shapes = _pushes(case, system)
    at = np.array([time])
    push = pushes(at)[0] @ shapes
    fresh[2], _ = definition.accelerations(system, fresh[0], fresh[1], push, landing.accelerations(at, case.step)[0])
    return system, fresh, landing


def _pushes(case, system):
    """Forces [N] of the plucks as a function of times, (n_times, 2 n_plucks), and where they push."""
    guitar = case.instrument
    shapes, forces = np.zeros((2 * len(case.plucks), system.count)), case.plucks
    for k, pluck in enumerate(forces):
        string = case.string_number(pluck.string)
        place = pluck.place * guitar.strings[string].length
        shapes[2 * k], shapes[2 * k + 1] = (system.shape(string, place, direction) for direction in "YZ")

    def pushes(times):
        columns = [ramp(times, one.start, one.duration) for one in forces]
        return np.array(
            [share * peak for one, share in zip(forces, columns, strict=True) for peak in (one.force_y, one.force_z)]
        ).T.reshape(len(times), -1)

    return pushes, shapes


def ramp(times, start, duration):
    """Share of a pluck's peak force: a linear rise, then nothing; the mean of both sides where it jumps.

    Parameters
    ----------
    times : ndarray (n,) [s]
    start, duration : float [s]

    Returns
    -------
    ndarray (n,) [1]
    """
    share = (times - start) / duration
    jump = np.abs(share - 1.0) * duration < 1e-9
    return np.where(jump, 0.5, np.where((share > 0.0) & (share < 1.0), share, 0.0))

"""CPU time of commands, taken in turns on one core.

The price of starting is taken out by difference: a system renders one second of the piece and all of it, and what the
second costs more than the first is the price of the seconds by which it is longer. Both are child processes of ours,
whose user and system time the system counts, all their threads included. Where starting costs as much as rendering (a
Python with a compiler), that difference is uncertain, and the program counts its own CPU time while it renders.
"""

import os
import statistics
import subprocess
import tempfile

import numpy as np
import soundfile

from .peer import PeerError, last_line, program_path

SILENCE = 1e-5  # full scale is 1; what peaks below it is broken
TIMED_OUT = 124  # exit code of coreutils' timeout
LONGEST_TAIL_S = 10.0  # some let the last notes die away; what both renders have of it cancels
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def cpu_seconds(command, timeout=900):
    """User and system time of a command and its threads [s], and what it said (str).

    Raises
    ------
    PeerError
        It failed, or ran for longer than ``timeout`` [s].
    """
    with tempfile.TemporaryFile() as words:
        streams = {"stdout": words, "stderr": subprocess.STDOUT, "stdin": subprocess.DEVNULL}
        limited = [program_path("timeout"), str(timeout), *command]
        child = subprocess.Popen(limited, env=os.environ | ONE_THREAD, **streams)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        words.seek(0)
        said = words.read().decode(errors="replace")
    if child.returncode:
        why = f"took more than {timeout} s" if child.returncode == TIMED_OUT else last_line(said)
        raise PeerError(why or f"failed with exit code {child.returncode}")
    return usage.ru_utime + usage.ru_stime, said


def check_sound(path, seconds):
    """The peak of a rendered file and its length [s]; PeerError where it is silent, not finite or too short."""
    sound, rate = soundfile.read(path, dtype="float32")
    peak, length = float(np.max(np.abs(sound), initial=0.0)), len(sound) / rate
    if not np.isfinite(peak) or peak < SILENCE:
        raise PeerError(f"what it renders is no sound (peak {peak:g})")
    if not seconds - 0.1 < length < seconds + LONGEST_TAIL_S:
        raise PeerError(f"it rendered {length:.2f} s instead of {seconds:g} s")
    return peak, length


def times_real_time(short, long):
    """Speed from (seconds rendered, CPU seconds) of a short and a long render."""
    cost = long[1] - short[1]
    if cost <= 0.0:
        raise PeerError("the long render took no more than the short one: too short to be timed")
    return (long[0] - short[0]) / cost


def in_turns(ready, seconds, runs, work, say):
    """Time all systems in turns.

    Parameters
    ----------
    ready : dict of str to Ready
    seconds : (float, float)
        Lengths of the short and the long render [s], where a system has none of its own.
    runs : int
    work : Work
    say : callable (str)

    Returns
    -------
    results : dict of str to dict
        ``runs`` (times real time), ``start_s`` (CPU time of starting; median), ``peak``.
    failed : dict of str to str
        Those left out, and why.
    """
    results, failed = {}, {}
    for turn in range(-1, runs):  # -1: nothing is counted; fills caches and shows what does not work
        for name, one in ready.items():
            if name in failed:
                continue
            lengths = one.seconds or seconds
            try:
                took = [_render(one, length, work, name) for length in (lengths if turn >= 0 else lengths[:1])]
                if turn < 0:
                    results[name] = {"runs": [], "starts": []}
                    continue
                speed = times_real_time(took[0], took[1])
                results[name]["runs"].append(speed)
                results[name]["starts"].append(took[0][2] - took[0][0] / speed)
                results[name]["peak"] = took[1][3]
                say(f"turn {turn + 1}, {name}: {speed:.4g} times real time")
            except PeerError as error:
                failed[name] = str(error)
                results.pop(name, None)
    for result in results.values():
        result["start_s"] = statistics.median(result.pop("starts"))
    return results, failed


def _render(ready, seconds, work, name):
    """One render: seconds of sound, CPU time to go by, that of the whole process [s], and peak."""
    target = work.path("".join(c if c.isalnum() else "-" for c in name) + ".wav")
    target.unlink(missing_ok=True)
    whole, said = cpu_seconds(ready.command(seconds, str(target)))
    if not target.exists():
        raise PeerError("it wrote no sound file")
    peak, length = check_sound(target, seconds)
    return length, float(said.split()[-1]) if ready.counts_itself else whole, whole, peak


def median_ratio(runs, others):
    """Median over the turns of how many times as fast as the others (of the same turns)."""
    return statistics.median(a / b for a, b in zip(runs, others, strict=True))

"""What lets an audio thread come first: a thread's number enters, its real-time scheduling or a reason leaves; and the
same for keeping memory from being paged out.

Both are asked of the operating system and often refused. A refusal is a sentence with what would allow it, never an
error: the guitar plays on, with less safety against other programs.
"""

import ctypes
import os
import platform

PRIORITY = 60  # a choice: above Linux's threaded interrupts (50), below what sound servers take for themselves (65-88)
_CAP_IPC_LOCK, _CAP_SYS_NICE = 14, 23  # linux/capability.h
_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4  # sys/mman.h of Linux on all but a few old machines
_ALLOW = (
    "add the lines '@audio - rtprio 95' and '@audio - memlock unlimited' to /etc/security/limits.d/audio.conf, join"
    " the group audio and log in again"
)


def raise_thread(thread, priority=PRIORITY):
    """Schedule a thread before all ordinary ones, unless somebody has done so already.

    Parameters
    ----------
    thread : int
        The operating system's number of the thread (``threading.get_native_id()`` of a Python one).
    priority : int
        Of the ordinary FIFO class, 1 to 99; lowered to what the user's limit allows.

    Returns
    -------
    str or None
        Why it could not be done, in a sentence; None where it is done or done by the sound system itself.
    """
    if not hasattr(os, "sched_setscheduler"):
        return None  # macOS and Windows: the sound system raises the threads that it calls from
    try:
        if os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK in (os.SCHED_FIFO, os.SCHED_RR):
            return None
        limit = -1 if _has_capability(_CAP_SYS_NICE) else _raise_limit("RLIMIT_RTPRIO")
        if limit == 0:
            return f"the audio thread runs at ordinary priority: the limit of real-time priorities is 0; {_advice()}"
        parameters = os.sched_param(min(priority, limit) if limit > 0 else priority)
        os.sched_setscheduler(thread, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, parameters)
    except PermissionError as error:
        return f"the audio thread runs at ordinary priority: {error.strerror}; {_advice()}"
    except OSError as error:
        return f"the audio thread runs at ordinary priority: thread {thread}: {error.strerror}"
    return None


def lock_memory():
    """Keep this process's memory from being paged out; what it gets from now on is there before it is used.

    What it has already and never used, such as the greater part of every library, stays where it is: call this before
    the arrays that matter are made or attached.

    Returns
    -------
    str or None
        Why it could not be done, in a sentence; None where it is done.
    """
    lock = getattr(_c_library(), "mlockall", None)
    if lock is None or platform.system() == "Darwin":  # where the function exists and does nothing
        return "the engine's memory is not locked: this system has no call for it"
    limit = _raise_limit("RLIMIT_MEMLOCK")
    if limit >= 0 and not _has_capability(_CAP_IPC_LOCK):
        # Locking the future under a limit would let ordinary allocations fail once it is reached: all or nothing.
        return f"the engine's memory is not locked: the limit is {limit // 1024} KiB, no limit is needed; {_advice()}"
    present = _MCL_CURRENT | (_MCL_ONFAULT if platform.system() == "Linux" else 0)
    if lock(present) != 0 or lock(_MCL_FUTURE) != 0:
        return f"the engine's memory is not locked: {os.strerror(ctypes.get_errno())}; {_advice()}"
    return None


def unlock_memory():
    """Undo `lock_memory`."""
    unlock = getattr(_c_library(), "munlockall", None)
    if unlock is not None:
        unlock()


def _advice():
    return f"to allow it {_ALLOW}" if platform.system() == "Linux" else "the system's administrator can allow it"


def _raise_limit(name):
    """Raise a soft limit of this process to its hard one; returns it, -1 for none."""
    import resource

    number = getattr(resource, name, None)
    if number is None:
        return 0
    soft, hard = resource.getrlimit(number)
    if soft != hard:
        resource.setrlimit(number, (hard, hard))
    return -1 if hard == resource.RLIM_INFINITY else hard


def _has_capability(number):
    """Whether this process may do what the limits forbid (Linux's capabilities; elsewhere: is it root's)."""
    try:
        with open("/proc/self/status") as status:
            words = next(line for line in status if line.startswith("CapEff")).split()
        return bool(int(words[1], 16) >> number & 1)
    except (OSError, StopIteration, ValueError):
        return getattr(os, "geteuid", lambda: 1)() == 0


def _c_library():
    try:
        return ctypes.CDLL(None, use_errno=True)
    except TypeError:  # Windows
        return None

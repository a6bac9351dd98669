"""Real-time scheduling and locked memory: done where the system allows, told in a sentence where it does not."""

import os
import subprocess
import sys
import threading

import pytest

from ukrt.drivers.sound import scheduling

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the sound system sees to it")

_AS_NOBODY = """
import os, resource, sys, threading
from ukrt.drivers.sound import scheduling
if os.geteuid() == 0:
    os.setgid(65534); os.setuid(65534)
for limit, most in ((resource.RLIMIT_RTPRIO, {rtprio}), (resource.RLIMIT_MEMLOCK, 65536)):
    soft, hard = resource.getrlimit(limit)
    if hard == resource.RLIM_INFINITY or hard > most:
        resource.setrlimit(limit, (most, most))
print(scheduling.raise_thread(threading.get_native_id(), 60))
print(scheduling.lock_memory())
print(os.sched_getscheduler(0), os.sched_getparam(0).sched_priority)
"""


def run_as_nobody(rtprio):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", _AS_NOBODY.format(rtprio=rtprio)]
    return subprocess.run(command, capture_output=True, text=True, env=environment, check=True).stdout.splitlines()


def test_without_permission_both_are_refused_with_advice():
    scheduled, locked, policy = run_as_nobody(0)
    assert scheduled.startswith("the audio thread runs at ordinary priority: the limit of real-time priorities is 0;")
    assert "'@audio - rtprio 95'" in scheduled and "'@audio - memlock unlimited'" in locked
    assert locked.startswith("the engine's memory is not locked: the limit is 64 KiB")
    assert policy == f"{os.SCHED_OTHER} 0"


def test_a_thread_that_has_ended_is_told():
    assert f"thread {2**30}: No such process" in scheduling.raise_thread(2**30)


@pytest.fixture
def thread():
    """A thread that sleeps until the test is over; its number."""
    over = threading.Event()
    sleeper = threading.Thread(target=over.wait)
    sleeper.start()
    yield sleeper.native_id
    over.set()
    sleeper.join()


def test_a_thread_is_raised_where_that_is_allowed(thread):
    reason = scheduling.raise_thread(thread, 7)
    if reason is not None:
        pytest.skip(reason)
    assert os.sched_getscheduler(thread) == os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    assert scheduling.raise_thread(thread, 50) is None
    assert os.sched_getparam(thread).sched_priority == 7  # what has been raised already is left alone
    assert os.sched_getscheduler(0) == os.SCHED_OTHER  # and nobody else was


def test_memory_is_locked_where_that_is_allowed():
    reason = scheduling.lock_memory()
    try:
        if reason is not None:
            pytest.skip(reason)
        with open("/proc/self/status") as status:
            locked = next(line for line in status if line.startswith("VmLck"))
        assert int(locked.split()[1]) > 10_000  # KiB: all of the interpreter
    finally:
        scheduling.unlock_memory()

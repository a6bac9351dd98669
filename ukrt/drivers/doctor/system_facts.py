"""What this machine allows a sound program to do: nothing enters, plain facts as a dict leave, no advice.

What a system does not tell is None. Real-time scheduling is tried by a thread that ends at once, locking memory is
undone at once.
"""

import contextlib
import os
import pathlib
import platform
import shutil
import sys
import threading

from ukrt.drivers.sound.scheduling import lock_memory, raise_thread, unlock_memory
from ukrt.errors import UkrtError

_GOVERNORS = "/sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"


def system_facts():
    """All facts (dict of dicts), as `ukrt doctor --json` prints them under ``machine``."""
    return {
        "system": _system(),
        "scheduling": scheduling_facts(),
        "memory_lock": _memory_lock(),
        "processor": _processor(),
        "jit_cache": _jit_cache(),
        "libraries": _libraries(),
        "audio_outputs": _devices("sound.portaudio", "list_outputs"),
        "midi_inputs": _devices("midi.inputs", "list_inputs"),
    }


def _system():
    version = platform.version()
    realtime = _read("/sys/kernel/realtime") == "1" or "PREEMPT_RT" in version
    return {
        "name": f"{platform.system()} {platform.release()}",
        "realtime_kernel": realtime if sys.platform == "linux" else None,
        "python": platform.python_version(),
        "machine": platform.machine(),
    }


def scheduling_facts():
    """Whether a thread gets real-time priority, why not, and which limits there are."""
    reason = []
    thread = threading.Thread(target=lambda: reason.append(raise_thread(threading.get_native_id())))
    thread.start()
    thread.join()
    allowed = reason[0] is None if hasattr(os, "sched_setscheduler") else None
    limits = {"rtprio_limit": _limit("RLIMIT_RTPRIO"), "rttime_limit_us": _limit("RLIMIT_RTTIME")}
    return {"allowed": allowed, "reason": reason[0], **limits}


def _memory_lock():
    """Whether this process's memory can be locked, why not, and how much may be [bytes]."""
    reason = lock_memory()
    if reason is None:
        unlock_memory()
    return {"allowed": reason is None, "reason": reason, "limit_bytes": _limit("RLIMIT_MEMLOCK")}


def _processor():
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    governors = sorted({text for path in _glob(_GOVERNORS) if (text := _read(path))})
    return {
        "model": _model(),
        "cores": cores,
        "governors": governors or None,
        "load_average": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "hypervisor": "hypervisor" in (_read("/proc/cpuinfo") or "") if sys.platform == "linux" else None,
    }


def _model():
    for line in (_read("/proc/cpuinfo") or "").splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _jit_cache():
    """Where compiled code is kept, whether it is there already, and whether it can be kept at all."""
    from ukrt.engine.kernel_cache import cache_folder

    folder = pathlib.Path(cache_folder())
    parent = next(p for p in (folder, *folder.parents) if p.exists())
    files = list(folder.rglob("callback.callback-*.nbc"))
    return {"folder": str(folder), "warm": bool(files), "writable": os.access(parent, os.W_OK)}


def _libraries():
    """Version or presence of what live sound and MIDI need (None: absent)."""
    return {
        "portaudio": _portaudio_version(),
        "rtmidi": _module_version("rtmidi"),
        "jack_client": _module_version("jack"),
        "jack_server": shutil.which("jackd") or shutil.which("pipewire-jack") or shutil.which("pw-jack"),
    }


def _portaudio_version():
    from ukrt.drivers.sound.portaudio import _portaudio

    try:
        return _portaudio().get_portaudio_version()[1]
    except UkrtError:
        return None


def _module_version(name):
    """The version of an importable module ("present" where it has none); None where it cannot be imported."""
    import importlib

    from ukrt.drivers.quiet import quiet_stderr

    try:
        with quiet_stderr():
            module = importlib.import_module(name)
    except (ImportError, OSError):  # OSError: the module is there, its C library is not
        return None
    return str(getattr(module, "__version__", "present"))


def _devices(module, function):
    """Names of what a driver module lists (list of str); None where its library is missing."""
    import importlib

    try:
        found = getattr(importlib.import_module(f"ukrt.drivers.{module}"), function)()
    except UkrtError:
        return None
    return [f"{one.index}: {one.name} ({getattr(one, 'host_api', None) or one.api})" for one in found]


def _limit(name):
    """The soft limit of a resource (int; -1: unlimited); None where the system has no such limit."""
    try:
        import resource

        return resource.getrlimit(getattr(resource, name))[0]
    except (ImportError, AttributeError):
        return None


def _glob(pattern):
    return sorted(pathlib.Path("/").glob(pattern.lstrip("/")))


def _read(path):
    with contextlib.suppress(OSError, UnicodeDecodeError):
        return pathlib.Path(path).read_text(encoding="utf-8").strip()
    return None

"""``ukrt play`` in a process of its own, with whatever stress beside it in the same process; and its presets."""

import contextlib
import json
import pathlib
import signal
import sys
import threading

from .server import ProofError, answer, child

_END_SECONDS = 30.0


@contextlib.contextmanager
def playing(environment, stress, *arguments):
    """The instrument, playing until the context is left; yields its process, undisturbed until `disturb` is called."""
    with child("play-worker", "--stress", stress, "--", *arguments, environment=environment) as process:
        threading.Thread(target=process.stdout.read, daemon=True).start()
        yield process
        process.send_signal(signal.SIGINT)
        if process.wait(_END_SECONDS) != 0:
            raise ProofError(f"ukrt play {' '.join(map(str, arguments))} ended with exit code {process.returncode}")


def disturb(process):
    """Begin the stress; a start under it would only take long."""
    process.stdin.write("now\n")
    process.stdin.flush()


@contextlib.contextmanager
def probing(environment):
    """The probe, ready; yields a function that asks it something."""
    with child("probe-worker", environment=environment) as process:
        answer(process, "the probe")

        def ask(what, **arguments):
            process.stdin.write(json.dumps({"do": what, **arguments}) + "\n")
            process.stdin.flush()
            return answer(process, f"the probe ({what})")

        yield ask


def work(options):
    """In a process of its own: ``ukrt play`` in the main thread, the stress in another thread, over and over."""
    from ukrt.cli.main import run
    from ukrt.drivers.doctor.stress import run_stress

    def work_beside():
        sys.stdin.readline()
        while True:
            run_stress(options.stress, 1.0)

    if options.stress != "none":
        threading.Thread(target=work_beside, daemon=True).start()
    sys.argv = ["ukrt", "play", *options.arguments]
    run()


def make_dead_preset(folder):
    """A guitar whose notes die within a fifth of a second, without a room, so that nothing hides a note's first sample.

    Returns
    -------
    pathlib.Path
        The preset's file.
    """
    import numpy as np
    import soundfile

    from ukrt.model.preset_text import dump_preset
    from ukrt.model.presets import load_preset

    response = np.zeros((16, 2))
    response[0] = 0.5  # [Pa/N]: at once, as loud as it happens to be
    soundfile.write(folder / "at-once.wav", response, 48000, subtype="FLOAT")
    changes = {
        "playing.idle_strings": "damped",
        "damper.attack_time": "0.002",
        "body.damping_ratios": str([0.5] * 10),
        "radiation.impulse_response": str(folder / "at-once.wav"),
        **{f"strings.{s}.loss_air": "100" for s in range(6)},
    }
    path = pathlib.Path(folder) / "dead.toml"
    path.write_text(dump_preset(load_preset("classical", changes)))
    return path

"""Is a take what was heard? For tests of ``ukrt play`` that record as ``FILES`` says."""

import numpy as np
import soundfile

from ukrt.cli.main import main

FILES = ("--record", "take.mid", "--record-audio", "heard.wav", "--report", "report.json")


def assert_take_is_what_was_heard(folder):
    """Render the take and compare with the recording, bit for bit, at every sample rate there was."""
    assert main(["render", str(folder / "take.mid"), "-o", str(folder / "again.wav")]) == 0
    parts = sorted(path.name.removeprefix("heard") for path in folder.glob("heard*.wav"))
    assert (
        parts[-1] == ".wav" and sorted(path.name.removeprefix("again") for path in folder.glob("again*.wav")) == parts
    )
    for part in parts:
        heard, rate = soundfile.read(folder / f"heard{part}", dtype="float32", always_2d=True)
        again, again_rate = soundfile.read(folder / f"again{part}", dtype="float32", always_2d=True)
        assert rate == again_rate and heard.shape == again.shape and np.array_equal(heard, again)
        assert len(heard) > 4800 and np.abs(heard).max() > 0.001
    assert list(folder.glob(".*.part")) == []

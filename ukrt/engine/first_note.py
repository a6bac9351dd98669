"""Plays a note on machine code in a file, in proof of it: ``python -m ukrt.engine.first_note FILE``."""

import pathlib
import sys

import numpy as np


def main(path):
    """Exit code: 0 if there was a sound."""
    from ukrt.engine import compiled

    compiled.use(pathlib.Path(path))
    from ukrt.engine.engine import Engine
    from ukrt.model.presets import load_preset

    engine = Engine(load_preset("paper"), 48000.0)
    engine.send(0, 0x90, 64, 100)
    sound = engine.process(4800)
    return 0 if np.isfinite(sound).all() and np.any(sound) and engine.energy() > 0.0 else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))

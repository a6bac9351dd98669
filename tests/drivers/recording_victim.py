"""Records an engine in real time until it is killed or its files may not grow any more; tells on standard output how
many frames there are.

Arguments: folder, most bytes of a file (0: no bound).
"""

import pathlib
import sys
import time

from ukrt.drivers.takes.recorder import Recorder
from ukrt.engine import stage_layout as at
from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset

folder, most = pathlib.Path(sys.argv[1]), int(sys.argv[2])
engine = Engine(load_preset("classical"), 48000.0, shared=True)
engine.shed_budget, engine.output_gain = 0.0, 8.0
engine.process_card(0)
recorder = Recorder(engine, folder / "take.mid", folder / "take.wav")
if most:
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
recorder.start()
began, blocks = time.monotonic(), 0
while not most or engine.frame < 60_000:
    if blocks % 20 == 0:
        for lane in (at.LANE_PLAYER, at.LANE_MIDI):
            engine.send(at.AT_ONCE, 0x90, 40 + blocks * 7 % 40, 100, lane=lane)
    engine.process_card(64)
    blocks += 1
    print(engine.frame, flush=True)
    if not most:
        time.sleep(max(began + engine.frame / engine.sample_rate - time.monotonic(), 0.0))
recorder.close()
print("\n".join(recorder.news()))
engine.close()

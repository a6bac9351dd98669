"""A process that plays itself over whatever JACK library it was given; it tells what came of it as JSON lines.

The second line comes when the server has gone, which the process waits for.
"""

import json
import time

import numpy as np
from drivers.jack_world import PulseEngine, Recorder, Sender, wait_until

from ukrt.drivers.jack.client import JackOutput, server_rate


def onsets(output, sender, recorder, count=50):
    """Delays of ``count`` notes [frames] from their sender to the recording (list)."""
    begin = sender.client.frame_time + 9600
    sender.waiting += [(begin + 1000 * k + 37 * k % 512, bytes([0x90, 1 + k, 100])) for k in range(count)]
    wait_until(lambda: not sender.waiting)
    wait_until(lambda: recorder.blocks[-1][0] > sender.sent[-1][0] + 4096)
    first, sound = recorder.sound()
    sent = {data[1]: when for when, data in sender.sent}
    return [int(first + place - sent[round(float(sound[place, 0]) * 128)]) for place in np.flatnonzero(sound[:, 0])]


def main():
    engine = PulseEngine()
    engine.sample_rate = server_rate()
    output = JackOutput(engine)
    output.start()
    sender, recorder = Sender(), Recorder()
    wait_until(lambda: output.tend() or output.ports()["midi_in"])
    wait_until(lambda: output.ports()["midi_in"] == ["keyboard:out"])
    recorder.client.connect(output._outs[0], recorder.ports[0])
    time.sleep(0.2)
    delays = onsets(output, sender, recorder)
    recorder.close(), sender.close()
    print(json.dumps({"name": output.name, "running": output.running, "delays": delays}), flush=True)
    wait_until(lambda: not output.running)
    print(json.dumps({"reason": output.reason, "closed": output.close()}), flush=True)


if __name__ == "__main__":
    main()

"""The player of the proofs, a JACK client in a process of its own: a schedule enters, MIDI messages leave.

Whenever a message is marked, its very sample of the audio port ``marker`` is 1, so that a recording of that port beside
the guitar tells when it was sent. Lines of JSON enter through standard input and leave through standard output.
"""

import json
import sys
import time

CLIENT = "prober"
MIDI_PORT, MARKER_PORT = "keys", "marker"
_CONNECT_SECONDS = 60.0  # for programs that compile nothing and look for ports each second
_LEAD_SECONDS = 0.5


class Probe:
    """A client that sends what it is told."""

    def __init__(self):
        import jack

        from .compiled_probe import Sender
        from .witness import Witness

        self._jack = jack
        self.client = jack.Client(CLIENT, no_start_server=True)
        midi = self.client.midi_outports.register(MIDI_PORT, is_physical=True, is_terminal=True)
        self.sender = Sender(self.client, midi, self.client.outports.register(MARKER_PORT))
        self.client.activate()
        self.witness = Witness(f"{CLIENT}:{MIDI_PORT}")

    def play(self, frames, messages, marks):
        """Send ``messages`` (list of bytes) at ``frames`` from now on; returns when all have been sent."""
        start = self.client.frame_time + int(_LEAD_SECONDS * self.client.samplerate)
        self.sender.begin([start + frame for frame in frames], messages, marks)
        self.witness.heard()
        while not self.sender.over:
            time.sleep(0.05)
        time.sleep(_LEAD_SECONDS)
        sent, offsets, refused = self.sender.result()
        words = [int.from_bytes(message, "big") for message in messages]
        return {"sent": sent, "offsets": offsets, "words": words, "refused": refused, "witness": self.witness.heard()}

    def wait_for(self, port):
        """Names of what ``port`` of ours is connected to, as soon as there is something."""
        ends = time.monotonic() + _CONNECT_SECONDS
        while time.monotonic() < ends:
            names = [one.name for one in self.client.get_all_connections(f"{CLIENT}:{port}")]
            if found := [name for name in names if not name.startswith("witness:")]:
                return found
            time.sleep(0.05)
        return []

    def sounding(self):
        """Audio outputs of the guitar, in their order."""
        ends = time.monotonic() + _CONNECT_SECONDS
        while time.monotonic() < ends:
            ports = self.client.get_ports(is_audio=True, is_output=True, is_physical=False)
            found = [one.name for one in ports if not self.client.owns(one) and not one.name.startswith("system:")]
            if len(found) >= 2:
                return found
            time.sleep(0.05)
        return []

    def cards_latency(self):
        """Largest playback latency of the server's physical outputs [frames]."""
        ports = self.client.get_ports(is_audio=True, is_input=True, is_physical=True)
        return max((max(one.get_latency_range(self._jack.PLAYBACK)) for one in ports), default=0)


def work(_options):
    """Answer requests until standard input ends."""
    from .schedules import SCHEDULES

    probe = Probe()
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        if request["do"] == "wait":
            answer = {"connected": probe.wait_for(request["port"])}
        elif request["do"] == "outputs":
            answer = {"outputs": probe.sounding()}
        else:
            answer = probe.play(*SCHEDULES[request["schedule"]](**request["arguments"]))
        print(json.dumps(answer), flush=True)
    probe.witness.close()
    probe.client.deactivate()
    probe.client.close()

"""A live session for tests: devices of the test's making, parts that keep a diary."""

import dataclasses

from devices import wait_until

from ukrt.drivers.live.session import LiveSession
from ukrt.engine.engine import Engine
from ukrt.errors import DeviceError
from ukrt.model.presets import load_preset

GUITAR = load_preset("paper")
OTHER = dataclasses.replace(load_preset("drop-d"), name="other")


def make_engine():
    """An engine in shared memory, at its preset's loudness, that leaves nothing out on a slow machine."""
    engine = Engine(GUITAR, shared=True)
    engine.output_gain, engine.shed_budget = engine.instance.preset_gain, 0.0
    return engine


class Bench:
    """A session on devices of the test's making; `news` keeps all that was told."""

    def __init__(self, engine, *devices, **options):
        self.engine, self.devices, self.news = engine, list(devices), []
        self.attempts = 0
        self.session = LiveSession(engine, self.open, **options)

    def open(self):
        """The next device; an exception among them is raised, and so is the last one again and again."""
        self.attempts += 1
        device = self.devices.pop(0) if len(self.devices) > 1 else self.devices[0]
        if isinstance(device, Exception):
            raise device
        return device

    def turn(self):
        self.session.tend()
        self.news += self.session.news()

    def wait(self, condition):
        wait_until(condition, meanwhile=self.turn)
        self.turn()

    def advance(self, frames=4800):
        """Let that many frames go by."""
        end = self.engine.frame + frames
        self.wait(lambda: self.engine.frame >= end)


class Part:
    """Anything that is started and closed, with a diary."""

    def __init__(self, name, diary, failing=None):
        self.name, self._diary, self._failing = name, diary, failing

    def start(self):
        self._diary.append(f"{self.name} starts")
        if self._failing == "start":
            raise DeviceError(f"{self.name} cannot start")

    def close(self):
        self._diary.append(f"{self.name} closes")
        if self._failing == "close":
            raise KeyboardInterrupt


class Tape(Part):
    """A recorder that notes what it is told."""

    def __init__(self):
        super().__init__("tape", [])
        self.announced = []

    def announce(self, instance):
        self.announced.append(instance)

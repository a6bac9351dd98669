"""Running another process's engine: the manifest of its shared memory enters, a function and its user data leave."""

from ukrt.engine import stage_layout as at
from ukrt.engine.host import Host
from ukrt.engine.memory import Block


class Attached:
    """A stage of another process, to be run in this one.

    Parameters
    ----------
    manifest : dict
        From ``Engine.manifest()`` there.
    """

    def __init__(self, manifest):
        self._stage = Block.attach(manifest["stage"])
        self._host = Host(self._stage.arrays)
        self._slots = [None, None]
        self.channels = manifest["channels"]
        self.reload(manifest)

    def reload(self, manifest):
        """Take over the slots that have changed since; the one being played never has."""
        self.sample_rate = manifest["sample_rate"]
        for slot, described in enumerate(manifest["slots"]):
            name = described and described["name"]
            known, block = self._slots[slot] or (None, None)
            if name == known:
                continue
            fresh = Block.attach(described) if described else None
            self._host.point(slot, fresh.arrays if fresh else None)
            self._slots[slot] = (name, fresh) if fresh else None
            if block is not None:
                block.close()

    @property
    def callback_address(self):
        """Address of the C function with PortAudio's callback signature (int)."""
        return self._host.callback_address

    @property
    def userdata_address(self):
        """The callback's user data (int); valid while this object lives."""
        return self._host.userdata_address

    @property
    def frame(self):
        """The next frame to be computed (int)."""
        return int(self._stage.arrays["si"][at.G_FRAME])

    @property
    def thread_id(self):
        """The operating system's number of the thread that calls the callback (int), 0 where it is not known."""
        return int(self._stage.arrays["si"][at.G_THREAD])

    def close(self):
        """Detach; only after the driver has stopped calling."""
        self._host.close()
        for slot in self._slots:
            if slot is not None:
                slot[1].close()
        self._stage.close()

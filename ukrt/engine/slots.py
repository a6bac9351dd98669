"""The two places for instances on a stage: one is heard, the other is loaded and takes over while strings ring."""

from ukrt.engine import layout as instance_at
from ukrt.engine import stage_layout as at
from ukrt.errors import ParameterError, UkrtError


class Slots:
    """Who is heard on a stage, and who comes next.

    Parameters
    ----------
    stage : ukrt.engine.stage.Stage
    host : ukrt.engine.host.Host
        Of this process, told where the instances lie.
    instance : Instance
        Who is heard first.
    """

    def __init__(self, stage, host, instance):
        self._stage, self._host = stage, host
        self._instances = [instance, None]
        host.point(0, instance.block.arrays)

    @property
    def heard(self):
        """The instance that is heard (Instance)."""
        return self._instances[self._stage.si[at.G_SLOT]]

    @property
    def swapping(self):
        """Whether an instance is about to take over or is still being faded in (bool)."""
        return bool(self._stage.si[at.G_SWAP] or self._stage.si[at.G_FADE])

    def load(self, instance, gain=None):
        """Put ``instance`` into the free slot, for `swap`.

        Parameters
        ----------
        instance : Instance
            Of the same signal and channels.
        gain : float [1], optional
            Of what goes to a sound card; by default as its preset has it.
        """
        if self.swapping:
            raise UkrtError("the guitar cannot be changed while the last change is still being carried out")
        heard = self.heard
        if (instance.signal, instance.channels) != (heard.signal, heard.channels):
            found = f"{instance.signal} in {instance.channels} channels"
            raise ParameterError("instance", found, f"it must be {heard.signal} in {heard.channels} channels")
        free = 1 - int(self._stage.si[at.G_SLOT])
        instance.d[instance_at.METER + instance_at.M_GAIN] = instance.preset_gain if gain is None else gain
        before, self._instances[free] = self._instances[free], instance
        self._host.point(free, instance.block.arrays)
        if before is not None:
            before.close()

    def swap(self, frame=at.AT_ONCE):
        """Let the loaded instance take over: what rings goes on ringing on it, and it is faded in over 2048 frames.

        Parameters
        ----------
        frame : int
            When exactly; AT_ONCE: at the beginning of the next block.

        Returns
        -------
        int
            The number of this change, which the journal names.
        """
        si = self._stage.si
        if self._instances[1 - int(si[at.G_SLOT])] is None:
            raise UkrtError("there is no other guitar loaded that could take over")
        si[at.G_SWAP_NUMBER] += 1
        si[at.G_SWAP_FRAME] = frame
        si[at.G_SWAP] = 1
        return int(si[at.G_SWAP_NUMBER])

    def reset(self):
        """The instance that is heard at rest and in the first slot, where a reset stage looks for it."""
        heard = self.heard
        heard.reset()
        if self._instances[0] is not heard:
            self._instances.reverse()
            self._host.point(0, heard.block.arrays)
        if self._instances[1] is not None:
            self._host.point(1, self._instances[1].block.arrays)

    def manifest(self):
        """What another process needs to attach the instances (list of dict or None)."""
        return [instance and instance.block.manifest() for instance in self._instances]

    def close(self):
        """Give the instances' memory back; what they held last can still be read."""
        for instance in self._instances:
            if instance is not None:
                instance.close()

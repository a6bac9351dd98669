"""What one MIDI input holds down: its messages enter; when it falls silent for good, those that end it leave."""

_NOTE_OFF, _NOTE_ON, _CONTROL, _BEND = 0x80, 0x90, 0xB0, 0xE0
_PEDALS, _DOWN = range(64, 67), 64  # CC64 sustain to CC66 soft; values from 64 on are "down"
_SOUND_OFF, _RESET_CONTROLLERS = 120, 121  # from 120 on: channel mode messages, of which all but 121, 122 end notes
_LOCAL_CONTROL = 122
_RESET = 0xFF
_BEND_CENTRE = (0, 64)


class Held:
    """Keys, pedals and bends that an input has down.

    Attributes
    ----------
    keys : set of (channel, key)
    """

    def __init__(self):
        self.keys, self._pedals, self._bent = set(), set(), set()

    def take(self, status, data1, data2):
        """Take note of a message."""
        kind, channel = status & 0xF0, status & 0x0F
        if kind == _NOTE_ON and data2:
            self.keys.add((channel, data1))
        elif kind in (_NOTE_ON, _NOTE_OFF):
            self.keys.discard((channel, data1))
        elif kind == _CONTROL:
            self._take_control(channel, data1, data2)
        elif kind == _BEND:
            (self._bent.discard if (data1, data2) == _BEND_CENTRE else self._bent.add)(channel)
        elif status == _RESET:
            self.__init__()

    def _take_control(self, channel, number, value):
        if number in _PEDALS:
            (self._pedals.add if value >= _DOWN else self._pedals.discard)((channel, number))
        elif number == _RESET_CONTROLLERS:
            self._pedals = {pedal for pedal in self._pedals if pedal[0] != channel}
            self._bent.discard(channel)
        elif number >= _SOUND_OFF and number != _LOCAL_CONTROL:
            self.keys = {key for key in self.keys if key[0] != channel}

    def release(self, others=()):
        """The messages that let go of everything, but for the keys that ``others`` (of Held) hold down too.

        Returns
        -------
        list of (status, data1, data2)
        """
        elsewhere = set().union(*(other.keys for other in others))
        messages = [(_NOTE_OFF | channel, key, 0) for channel, key in sorted(self.keys - elsewhere)]
        messages += [(_CONTROL | channel, number, 0) for channel, number in sorted(self._pedals)]
        messages += [(_BEND | channel, *_BEND_CENTRE) for channel in sorted(self._bent)]
        self.__init__()
        return messages


def everything_off():
    """Pedals up and all notes off on all channels: what is left to say for a writer that died (list of messages)."""
    return [(_CONTROL | channel, number, 0) for channel in range(16) for number in (*_PEDALS, 123)]

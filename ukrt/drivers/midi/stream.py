"""Raw MIDI bytes of one input enter, in packets of any size; whole messages (status, data1, data2) leave.

MIDI 1.0 as it really arrives: running status, real-time bytes in the middle of messages and of SysEx, SysEx split over
packets, aborted or never ended, and data that belong to nothing. `engine/kernels/midi_bytes.py` is the compiled twin.
"""

from collections import namedtuple

Message = namedtuple("Message", "status data1 data2")

ACTIVE_SENSING, RESET = 0xFE, 0xFF
_REAL_TIME, _SYSTEM, _STATUS = 0xF8, 0xF0, 0x80
_ONE_DATA_BYTE = (0xC0, 0xD0)  # program change, channel pressure: the upper halves of their status
_DATA = bytes(range(_STATUS))


class MidiStream:
    """A parser that any bytes may be given to.

    What leaves are channel messages, active sensing (0xFE) and reset (0xFF). Clocks, positions and SysEx are passed
    over; SysEx needs no state of its own, since it cancels running status as every system message does.
    """

    def __init__(self):
        self._status = 0  # running status; 0: data bytes mean nothing
        self._first = -1  # the first of two data bytes, once it has come

    def feed(self, packet):
        """The messages that ``packet`` completes.

        Parameters
        ----------
        packet : sequence of int
            Bytes, 0..255.

        Returns
        -------
        list of Message
        """
        if len(packet) == 3 and _is_whole(*packet):  # nearly all there is
            self._status, self._first = packet[0], -1
            return [Message(*packet)]
        messages, at, packet = [], 0, bytes(packet)
        while at < len(packet):
            byte = packet[at]
            at += 1
            if byte < _STATUS:
                if self._status:
                    self._take_data(byte, messages)
                else:  # SysEx or stray: on to the next status at the speed of C
                    at = len(packet) - len(packet[at:].lstrip(_DATA))
            elif byte < _REAL_TIME:
                self._status, self._first = byte if byte < _SYSTEM else 0, -1
            elif byte >= ACTIVE_SENSING:
                if byte == RESET:
                    self._status, self._first = 0, -1
                messages.append(Message(byte, 0, 0))
        return messages

    def _take_data(self, byte, messages):
        if self._status & 0xF0 in _ONE_DATA_BYTE:
            messages.append(Message(self._status, byte, 0))
        elif self._first < 0:
            self._first = byte
        else:
            messages.append(Message(self._status, self._first, byte))
            self._first = -1


def _is_whole(status, data1, data2):
    """Whether three bytes are one channel message with two data bytes."""
    is_channel = _STATUS <= status < _SYSTEM and status & 0xF0 not in _ONE_DATA_BYTE
    return is_channel and data1 < _STATUS and data2 < _STATUS

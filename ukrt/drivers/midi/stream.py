"""Raw MIDI bytes of one input enter, in packets of any size; whole messages (status, data1, data2) leave.

MIDI 1.0 as it really arrives: running status, real-time bytes in the middle of messages and of SysEx, SysEx split over
packets, aborted or never ended, and data that belong to nothing. `engine/kernels/midi_bytes.py` is the compiled twin.
"""

from collections import namedtuple

from ukrt.engine.stage_layout import SYSEX_BEGIN, SYSEX_BYTES, SYSEX_END, SYSEX_MORE, SYSEX_SKIPPED, UNIVERSAL

Message = namedtuple("Message", "status data1 data2")

ACTIVE_SENSING, RESET = 0xFE, 0xFF
_REAL_TIME, _SYSTEM, _STATUS = 0xF8, 0xF0, 0x80
_ONE_DATA_BYTE = (0xC0, 0xD0)  # program change, channel pressure: the upper halves of their status
_DATA = bytes(range(_STATUS))


class MidiStream:
    """A parser that any bytes may be given to.

    What leaves are channel messages, active sensing (0xFE), reset (0xFF), and the pieces of universal SysEx that
    `stage_layout.py` describes; of other SysEx the piece that says so. Clocks and positions are passed over.
    """

    def __init__(self):
        self._status = 0  # running status, SYSEX_BEGIN or SYSEX_MORE; 0: data bytes mean nothing
        self._first = -1  # the first of two data bytes, once it has come
        self._size = 0  # data bytes of a SysEx that have left

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
                else:  # of no use or stray: on to the next status at the speed of C
                    at = len(packet) - len(packet[at:].lstrip(_DATA))
            elif byte < _REAL_TIME:
                if byte == SYSEX_END:
                    self._end_sysex(messages)
                self._status, self._first, self._size = byte if byte <= SYSEX_BEGIN else 0, -1, 0
            elif byte >= ACTIVE_SENSING:
                if byte == RESET:
                    self._status, self._first = 0, -1
                messages.append(Message(byte, 0, 0))
        return messages

    def _take_data(self, byte, messages):
        if self._status >= _SYSTEM:
            self._take_sysex(byte, messages)
        elif self._status & 0xF0 in _ONE_DATA_BYTE:
            messages.append(Message(self._status, byte, 0))
        elif self._first < 0:
            self._first = byte
        else:
            messages.append(Message(self._status, self._first, byte))
            self._first = -1


    def _take_sysex(self, byte, messages):
        if self._first < 0:
            self._first = byte
            if self._status == SYSEX_BEGIN and byte < UNIVERSAL:
                self._status = 0
                messages.append(Message(SYSEX_SKIPPED, 0, 0))
            return
        self._size += 2
        if self._size > SYSEX_BYTES:
            self._status = 0
            messages.append(Message(SYSEX_SKIPPED, 1, 0))
            return
        messages.append(Message(self._status, self._first, byte))
        self._status, self._first = SYSEX_MORE, -1

    def _end_sysex(self, messages):
        if self._status == SYSEX_MORE:
            messages.append(Message(SYSEX_END, max(self._first, 0), int(self._first >= 0)))
        elif self._status == SYSEX_BEGIN and self._first >= 0:
            messages.append(Message(SYSEX_SKIPPED, 1, 0))


def _is_whole(status, data1, data2):
    """Whether three bytes are one channel message with two data bytes."""
    is_channel = _STATUS <= status < _SYSTEM and status & 0xF0 not in _ONE_DATA_BYTE
    return is_channel and data1 < _STATUS and data2 < _STATUS

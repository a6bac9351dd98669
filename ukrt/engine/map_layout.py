"""What controllers of a player's own hardware mean: a message and the stage's tables enter, the message that counts
leaves.

Two tables lie in the stage, so that one can be written while the other is read; ``G_MAP`` says which counts. The
function is one text that runs twice: compiled in JACK's callback, interpreted in the MIDI process, each before the
message goes into its lane. So what is held down, what a full lane refuses, the journal and takes all know the mapped
message alone. Files, pieces and replays have lanes of their own and are never touched.
"""

from ukrt.engine import stage_layout as at

PRESSURE_SOURCE, BEND_SOURCE = 128, 129  # of a channel's row of at.MAP_SOURCES; below them its controllers
LAST_SOURCE = 119  # the last controller that may be mapped: from 120 on they are channel mode messages
DROPPED = -1  # an entry of the table, and what `mapped` gives for it
_CONTROL, _PRESSURE, _BEND = 0xB0, 0xD0, 0xE0


def map_entry(controller, low, high, channel=-1):
    """What a table holds for a source: its values 0 to 127 become ``low`` to ``high`` of ``controller`` on ``channel``
    (0 to 15; -1: the source's own). An entry of 0 leaves messages as they are."""
    return (channel + 2) << 21 | high << 14 | low << 7 | controller


def mapped(si, word):
    """The message (status << 16 | data1 << 8 | data2) that ``word`` means, `DROPPED` if none.

    Of channel pressure the value counts, of pitch bend its upper seven bits.
    """
    which = si[at.G_MAP]
    kind, source, value = (word >> 16) & 0xF0, (word >> 8) & 0x7F, word & 0x7F
    if which < 1 or which > at.MAP_TABLES or (kind != _CONTROL and kind != _PRESSURE and kind != _BEND):
        return word
    if kind == _PRESSURE:
        source, value = PRESSURE_SOURCE, source
    elif kind == _BEND:
        source = BEND_SOURCE
    channel = (word >> 16) & 0x0F
    entry = si[at.MAPS + at.MAP_SIZE * (which - 1) + at.MAP_SOURCES * channel + source]
    if entry == 0:
        return word
    if entry < 0:
        return DROPPED
    low, high = (entry >> 7) & 0x7F, (entry >> 14) & 0x7F
    if (entry >> 21) & 0x1F > 1:
        channel = ((entry >> 21) - 2) & 0x0F
    value = (low * (127 - value) + high * value + 63) // 127
    return (_CONTROL | channel) << 16 | (entry & 0x7F) << 8 | value

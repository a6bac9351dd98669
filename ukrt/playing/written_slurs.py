"""Which notes of a score are meant to be slurred: notes and the channels' controllers enter, each note learns which one
it should go on from, on that one's string.

The rule is the compiled player's (``engine/kernels/player_slur.py``): with legato or portamento on, a note that begins
while others of its channel are held goes on from the one that began last; of several new ones the highest does.
"""

from ukrt.playing.keyswitches import GLIDE, HARMONIC, LEGATO, settings

NOTE_ON, CONTROL, RESET, DOWN = 0x90, 0xB0, 121, 64


def mark_slurs(notes, score, switches):
    """Say of each note which it is slurred from, and whether by sliding (``Written.slurred_from``, ``slides``).

    A string that is slurred on stays taken until the first of the notes ends: when the key of a slurred note comes up
    before that, the string goes back. So ``key_up_s`` and ``end_s`` of a slurred note are no earlier; ``up_s`` stays.

    Parameters
    ----------
    notes : list of Written
        In the order of their note-ons; changed in place.
    score : object with arrays ``time_s``, ``status``, ``data1``, ``data2``
    switches : dict of int to Switch
    """
    if not switches and not _has_slurs(score):
        return
    ways, held = _ways(notes, score, switches), {}
    starts = {}
    for note in notes:
        starts.setdefault((note.start_s, note.channel), []).append(note)
    for (time_s, channel), chord in starts.items():
        down = [note for note in held.get(channel, ()) if note.up_s > time_s]
        sources = list(down)
        for note in sorted(chord, key=lambda note: -note.key):
            legato, slides = ways[id(note)]
            if sources and (legato or slides) and not _is_repeated(note, held.get(channel, ())):
                source = sources.pop()
                note.slurred_from, note.slides, note.hammers = source, slides, legato
                note.key_up_s, note.end_s = max(note.key_up_s, source.key_up_s), max(note.end_s, source.end_s)
        held[channel] = down + chord


def _is_repeated(note, former):
    """Whether its key is struck again while it is down."""
    return any(one.key == note.key and one.up_s == note.start_s and not 0 <= one.off < note.message for one in former)


def _has_slurs(score):
    controls = score.status & 0xF0 == CONTROL
    return bool((controls & ((score.data1 == LEGATO) | (score.data1 == GLIDE)) & (score.data2 >= DOWN)).any())


def _controls(kind, data1, data2, switches):
    """What a message sets: (controller, value), one after the other."""
    if kind == CONTROL and data1 == RESET:
        return (HARMONIC, 0), (GLIDE, 0), (LEGATO, 0)
    if kind == CONTROL:
        return ((data1, data2),)
    if kind == NOTE_ON and data2 > 0 and data1 in switches:
        return settings(switches[data1], data2)
    return ()


def _ways(notes, score, switches):
    """id of each note -> (whether its channel plays legato then, whether it slides)."""
    on, ways, waiting = set(), {}, iter(notes)
    note = next(waiting, None)
    columns = (score.status, score.data1, score.data2)
    for message, (status, data1, data2) in enumerate(zip(*(c.tolist() for c in columns), strict=True)):
        channel = status & 0x0F
        for controller, value in _controls(status & 0xF0, data1, data2, switches):
            (on.add if value >= DOWN else on.discard)((channel, controller))
        while note is not None and note.message == message:
            free = (channel, HARMONIC) not in on
            ways[id(note)] = (free and (channel, LEGATO) in on, free and (channel, GLIDE) in on)
            note = next(waiting, None)
    return ways

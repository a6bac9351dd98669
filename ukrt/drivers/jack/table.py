"""What stands in the table that a JACK client's compiled callbacks write, in words that Python understands."""

from ukrt.engine import jack_layout as at

FUNCTIONS = {
    at.T_GET_BUFFER: "jack_port_get_buffer",
    at.T_EVENT_COUNT: "jack_midi_get_event_count",
    at.T_EVENT_GET: "jack_midi_event_get",
    at.T_LOST_COUNT: "jack_midi_get_lost_event_count",
    at.T_CYCLE_TIME: "jack_last_frame_time",
    at.T_TRANSPORT: "jack_transport_query",
    at.T_GET_RANGE: "jack_port_get_latency_range",
    at.T_SET_RANGE: "jack_port_set_latency_range",
}  # libjack's functions by the word that holds their address


def shutdown_words(table):
    """What the server said as it let go (str), without a full stop; often nothing."""
    words = table[at.T_REASON : at.T_REASON + at.REASON_BYTES // 8].tobytes().split(b"\0")[0]
    return words.decode("utf-8", "replace").strip().rstrip(".")


def held_messages(table):
    """Messages (status, data1, data2) that let go of all keys and pedals that JACK's MIDI holds (list)."""
    messages = []
    for channel in range(16):
        held = at.T_HELD + at.HELD_WORDS * channel
        low, high, pedals = (int(word) & 0xFFFFFFFF_FFFFFFFF for word in table[held : held + 3])
        keys = high << 64 | low
        messages += [(0xB0 | channel, at.FIRST_PEDAL + k, 0) for k in range(at.PEDALS) if pedals >> k & 1]
        messages += [(0x80 | channel, key, 0) for key in range(128) if keys >> key & 1]
    return messages

"""The table of words (int64) that the compiled JACK callbacks are given: a JACK client's own, never shared.

It holds addresses of libjack's functions and of ports, so that no address stands in compiled code, then numbers that
the callbacks write and others read. Readable without NumPy and without JACK.
"""

J_MAGIC = 0x756B7274_6A61636B  # "ukrtjack"
MAX_PORTS = 16  # audio outputs
MAX_MIDI = 8  # MIDI inputs
SCRATCH_FRAMES = 8192  # computed in one call of the engine; jack2's and PipeWire's largest period
REASON_BYTES = 256
EVENT_WORDS = 4  # room for one jack_midi_event_t (24 bytes) for each MIDI input
EVENT_TIME, EVENT_SIZE, EVENT_BYTES = range(3)  # its words: uint32 and padding, size_t, pointer
POSITION_WORDS = 32  # room for a jack_position_t
POSITION_FRAME = 20  # where its field ``frame`` (uint32) stands [bytes]: the struct is packed
CAPTURE, PLAYBACK = 0, 1  # jack_latency_callback_mode_t
ROLLING = 1  # JackTransportRolling

# Written before the client is activated ------------------------------------------------------------------------------
(
    T_MAGIC, T_CLIENT, T_CHANNELS, T_MIDI_PORTS, T_RATE, T_CALLBACK, T_USERDATA, T_SCRATCH,
    T_GET_BUFFER, T_EVENT_COUNT, T_EVENT_GET, T_LOST_COUNT, T_CYCLE_TIME, T_TRANSPORT, T_GET_RANGE, T_SET_RANGE,
) = range(16)  # fmt: skip
# T_RATE      what the engine runs at [Hz]: at another rate of the server there is silence
# T_CALLBACK  the engine's C function; 0: silence. May be changed at any time
# T_SCRATCH   address of SCRATCH_FRAMES * T_CHANNELS interleaved float32
# the others  jack_port_get_buffer, jack_midi_get_event_count, jack_midi_event_get, jack_midi_get_lost_event_count,
#             jack_last_frame_time, jack_transport_query, jack_port_get_latency_range, jack_port_set_latency_range
T_AUDIO = 16  # jack_port_t * of each output
T_MIDI = T_AUDIO + MAX_PORTS  # and of each MIDI input

# Written by the process callback -------------------------------------------------------------------------------------
T_COUNTS = T_MIDI + MAX_MIDI
COUNT_NAMES = ("cycles", "frames", "events", "messages", "lost_events", "missed_frames", "failed_cycles")
(
    T_CYCLES, T_FRAMES, T_EVENTS, T_MESSAGES, T_LOST, T_MISSED, T_FAILED,
) = range(T_COUNTS, T_COUNTS + len(COUNT_NAMES))  # fmt: skip
# T_EVENTS   JACK's events; T_MESSAGES: what their bytes gave that was queued
# T_LOST     events that JACK itself had no room for
# T_MISSED   frames of cycles that the server went through without us
# T_FAILED   cycles in which the engine refused to compute
T_LIVE = T_COUNTS + 8
(
    T_NEXT_TIME, T_PERIOD, T_POSITION_SEQ, T_POSITION_STATE, T_POSITION_AT, T_POSITION_ENGINE, T_ENDED,
) = range(T_LIVE, T_LIVE + 7)  # fmt: skip
# T_NEXT_TIME     JACK's frame time at which the next cycle is due; T_PERIOD: frames of the last one
# T_POSITION_*    the transport at the start of the last cycle, between two steps of _SEQ: its state, its frame, and the
#                 stage's frame at that moment
# T_ENDED         how many of the wishes T_END_HELD have been carried out

# Written by the callbacks of JACK's other threads --------------------------------------------------------------------
T_NOTICES = T_LIVE + 8
(
    T_XRUNS, T_BLOCK, T_RATE_NOW, T_PORTS_SEEN, T_SHUTDOWN, T_SHUTDOWN_CODE, T_END_HELD,
) = range(T_NOTICES, T_NOTICES + 7)  # fmt: skip
# T_PORTS_SEEN   counts whatever happens to ports: they come, go, are connected and disconnected
# T_END_HELD     counts wishes (of the host's) that all keys and pedals held by JACK's MIDI be let go
T_REASON = T_NOTICES + 8  # the server's words at shutdown, UTF-8, ended by zero

T_HELD = T_REASON + REASON_BYTES // 8  # HELD_WORDS for each MIDI channel, written by the process callback
HELD_WORDS = 4  # bits of keys 0 to 63, of keys 64 to 127, of pedals (controllers 64 to 69), one word spare
HELD_PEDALS, FIRST_PEDAL, PEDALS = 2, 64, 6

# Scratch -------------------------------------------------------------------------------------------------------------
T_PARSER = T_HELD + 16 * HELD_WORDS  # state of each MIDI input's parser
T_BUFFER = T_PARSER + MAX_MIDI  # this cycle's buffer of each MIDI input, then its events, then which one is next
T_COUNT = T_BUFFER + MAX_MIDI
T_NEXT = T_COUNT + MAX_MIDI
T_EVENT = T_NEXT + MAX_MIDI
T_POSITION = T_EVENT + EVENT_WORDS * MAX_MIDI
T_RANGE = T_POSITION + POSITION_WORDS  # one jack_latency_range_t: uint32 min, max
TABLE_WORDS = T_RANGE + 8

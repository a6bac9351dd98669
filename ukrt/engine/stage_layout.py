"""Where the stage keeps its numbers: what lies between hosts (sound card, MIDI, recorder) and the instruments played.

Pure constants, readable without NumPy: a process that only writes MIDI messages needs no more. A stage is three flat
arrays (``si`` int64, ``sd`` float64, ``ring`` float32) that hold no address, so that several processes can share them;
whoever runs the callback has a small table of words of its own with the addresses of its view of them.
"""

MAGIC = 0x756B7274_73746167  # "ukrtstag"
VERSION = 1

# Messages: one queue (lane) for each writer, so that none needs a lock ------------------------------------------------
LANES = 4
LANE_PLAYER, LANE_MIDI, LANE_JACK = 0, 1, 2  # this process (pieces, Python, replays); MIDI process; JACK's own MIDI
QUEUE = 16384  # messages in a lane
KIND_MIDI, KIND_SHED, KIND_RESET, KIND_SWAP = range(4)  # word = kind << 32 | status << 16 | data1 << 8 | data2
KIND_SHIFT = 32
VALUE_MASK = (1 << KIND_SHIFT) - 1
# SysEx travels in pieces, each a message: 7E or 7F and the device, two more data bytes, and the end with one more data
# byte or none (0 or 1 in data2). One that is passed over leaves a single piece; of those too long to mean anything, or
# too short, data1 is 1.
UNIVERSAL = 0x7E  # and 0x7F: no maker's own
SYSEX_BEGIN, SYSEX_MORE, SYSEX_SKIPPED, SYSEX_END = 0xF0, 0xF4, 0xF5, 0xF7
SYSEX_BYTES = 516  # data bytes of the longest that means something here (127 notes' tuning: 515), made even
AT_ONCE = -1  # as a frame: whenever the next block begins
# What a lane refuses as it fills up: first whatever can be missed, then notes, never (until full) the end of notes.
CLASS_OTHER, CLASS_NOTE_ON, CLASS_OFF = range(3)
CLASSES = 3
ROOM = (QUEUE * 3 // 4, QUEUE * 15 // 16, QUEUE)  # messages waiting beyond which each class is refused (choices)
SENSING_SECONDS = 0.33  # MIDI 1.0: after active sensing, silence of more than 300 ms means a cut cable

MAP_TABLES, MAP_SOURCES = 2, 130  # what controllers mean (map_layout.py): 128, pressure, bend of each of 16 channels
MAP_SIZE = 16 * MAP_SOURCES
JOURNAL = 65536  # entries: frame, word of everything that acted, in order
RING_FRAMES = 1 << 19  # of what the card got: 10.9 s at 48 kHz
LOAD_BINS, LOAD_PER_OCTAVE, LOAD_FULL = 1024, 32, 512  # bin LOAD_FULL + LOAD_PER_OCTAVE log2(load)


def _sections(sizes):
    """Lay sections one after another, each on a 64-byte boundary: offsets by name, and the end."""
    offsets, at = {}, 0
    for name, size in sizes.items():
        offsets[name] = at
        at += -(-size // 8) * 8
    return offsets, at


# si ------------------------------------------------------------------------------------------------------------------
# Each group of numbers that one writer changes stands on cache lines of its own.
_SI, SI_SIZE = _sections(
    {
        "HEAD": 64,
        "COUNTS": 64,
        "LANE_WRITE": 8 * LANES,  # each lane's number of messages ever written, 64 bytes apart (LANE_STEP)
        "LANE_READ": 8 * LANES,
        "LANE_REFUSED": 8 * LANES,  # by class, and LANE_UNMAPPED; written by the lane's writer
        "MAPS": MAP_TABLES * MAP_SIZE,
        "LANE_SENSED": 8 * LANES,  # frame of the last message after active sensing began, else -1; written by the stage
        "LOAD": LOAD_BINS,  # blocks by the share of their period that they took
        "JOURNAL_AT": 2 * JOURNAL,
        "QUEUES": 2 * QUEUE * LANES,
    }
)
LANE_STEP = 8
LANE_UNMAPPED = 3  # behind a lane's refusals: messages that the map drops
LANE_SIZE = 2 * QUEUE
globals().update(_SI)
HEAD, COUNTS, LANE_WRITE, LANE_READ = _SI["HEAD"], _SI["COUNTS"], _SI["LANE_WRITE"], _SI["LANE_READ"]
LANE_REFUSED, LANE_SENSED, LOAD = _SI["LANE_REFUSED"], _SI["LANE_SENSED"], _SI["LOAD"]
JOURNAL_AT, QUEUES, MAPS = _SI["JOURNAL_AT"], _SI["QUEUES"], _SI["MAPS"]

(
    G_FRAME, G_CHANNELS, G_SLOT, G_SWAP, G_SWAP_FRAME, G_SWAP_NUMBER, G_FADE, G_LIMITER, G_CAP, G_BUSY, G_THREAD,
    G_STAMP_SEQ, G_STAMP_FRAME, G_STAMP_NS, G_MUTE_END, G_CAP_CHUNK, G_CAP_USED, G_SHED, G_SHED_WANTED, G_SHED_HOT,
    G_SHED_COOL, G_RING_FRAMES, G_RECORD, G_FADE_IN, G_STAMP_BLOCK, G_CAP_HELD, G_TORN, G_MAP,
) = range(HEAD, HEAD + 28)  # fmt: skip
# G_FRAME        the next frame to be computed
# G_SLOT         which of the two instances is heard
# G_SWAP         1: the other instance takes over at G_SWAP_FRAME (AT_ONCE: at the next block)
# G_FADE         frames of the crossfade still to come; the instance that goes is in the other slot until it is 0
# G_CAP          most messages played in one chunk of 64 frames, the rest wait (0: no bound)
# G_CAP_HELD     1 while messages wait because of it
# G_BUSY         1 while a host is inside the callback: a host that dies there leaves a torn state
# G_TORN         1: a host died there; everything comes to rest at the beginning of the next block
# G_MAP          which of the two tables of MAPS says what live controllers mean, 1 or 2; 0: they mean themselves
# G_THREAD       the operating system's number of the thread that calls (0: not known)
# G_STAMP_*      the start of the last block: frame and monotonic clock [ns], written between two steps of G_STAMP_SEQ
# G_STAMP_BLOCK  its frames
# G_MUTE_END     frame at which everything comes to rest again, silent up to there (replayed resets)
# G_FADE_IN      frames of a fade-in still to come, after a change of the sample rate
# G_RECORD       1: what the card gets is kept in the ring of G_RING_FRAMES frames
# G_SHED         how much is shed now (0: nothing); G_SHED_WANTED: what the overload watch asks for from the next block

COUNT_NAMES = (
    "blocks", "input_underflows", "input_overflows", "underflows", "overflows", "priming", "late_blocks",
    "midi_received", "late_messages", "delayed_messages", "sensing_timeouts", "swaps", "resets", "shed_events",
    "clipped_samples", "limited_samples", "nonfinite_resets", "journal", "recorded",
)  # fmt: skip
(
    N_BLOCKS, N_INPUT_UNDERFLOWS, N_INPUT_OVERFLOWS, N_UNDERFLOWS, N_OVERFLOWS, N_PRIMING, N_LATE_BLOCKS,
    N_MIDI, N_LATE_MESSAGES, N_DELAYED, N_SENSING, N_SWAPS, N_RESETS, N_SHED_EVENTS, N_CLIPPED, N_LIMITED,
    N_NONFINITE, N_JOURNAL, N_RECORDED,
) = range(COUNTS, COUNTS + len(COUNT_NAMES))  # fmt: skip
# N_JOURNAL and N_RECORDED are also the write positions: entries and frames ever written

# sd ------------------------------------------------------------------------------------------------------------------
MAX_CHANNELS = 16
FADE = 2048  # frames of the crossfade from one instance to another (choice: 43 ms at 48 kHz)
MAX_PIECE = 1024  # frames computed at once for a card, whatever the host asks for
_SD, SD_SIZE = _sections({"METER": 64, "OUT": MAX_PIECE * MAX_CHANNELS})
METER, OUT = _SD["METER"], _SD["OUT"]
(
    M_PEAK, M_PEAK_RECENT, M_TICKS_PER_SECOND, M_RATE, M_ENVELOPE, M_SHED_BUDGET,
) = range(METER, METER + 6)  # fmt: skip

# The table of words a host keeps: addresses in its own memory --------------------------------------------------------
(
    W_MAGIC, W_VERSION, W_SI, W_SD, W_RING, W_CLOCK, W_CLOCK_ID, W_THREAD_ID,
) = range(8)  # fmt: skip
# W_CLOCK, W_THREAD_ID: addresses of the C library's clock_gettime and gettid, 0 where the host gives none
W_TIME_AT = 8  # address of the two words that follow, scratch for the clock
W_TABLE, W_PLAY, W_TAKE_OVER = range(11, 14)  # addresses: the table itself; play.py, take_over.py
W_SLOTS = 14
SLOT_WORDS = 8  # of each of the two slots: address and length of d, i, v, vi
WORDS = W_SLOTS + 2 * SLOT_WORDS
DOUBLE_OUTPUT = 1 << 31  # in the callback's flags: write doubles, without gain, limiter or recording
INPUT_UNDERFLOW, INPUT_OVERFLOW, UNDERFLOW, OVERFLOW, PRIMING = 1, 2, 4, 8, 16  # PortAudio's PaStreamCallbackFlags

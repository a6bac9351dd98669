"""Where the player keeps its numbers inside its sections of ``d`` and ``i``; the constants of its rules come along.

Offsets are absolute (the section's base is added here). Tables are filled once by ``ukrt.engine.player_tables``; the
rest is the player's own state, cleared by ``player_reset``.
"""

from .counter_layout import COUNTER_NAMES
from .layout import MAX_STRINGS, PLAYER_D, PLAYER_D_SIZE, PLAYER_I, PLAYER_I_SIZE
from .player_rules_layout import *  # noqa: F403 - kernels name everything of the player as at.NAME
from .player_rules_layout import CHANNELS, FRET_ROW, HOLDS, LOG_CAPACITY, MAX_GROUP, MOST_SWITCHES, ROW, SWITCH_ROW
from .stage_layout import SYSEX_BYTES

# Parameters (i) ----------------------------------------------------------------------------------------------------
I_STRINGS = PLAYER_I + 0
I_FRETS = PLAYER_I + 1
I_SPAN = PLAYER_I + 2  # frets
I_LEAD = PLAYER_I + 3  # frames from a note-on to its release
I_LANDING = PLAYER_I + 4  # frames a finger takes to land
I_DAMP_RAMP = PLAYER_I + 5
I_UNDAMP_RAMP = PLAYER_I + 6
I_QUICK_RAMP = PLAYER_I + 7
I_SETTLE = PLAYER_I + 8  # frames from damping to lifting the finger
I_GAP = PLAYER_I + 9  # frames from lifting the finger to lifting the damper
I_DAMPED_IDLE = PLAYER_I + 10  # 1: idle strings stay damped
I_BEND_RANGE = PLAYER_I + 11  # cents, before any RPN
I_BEND_RAMP = PLAYER_I + 12
I_BEND_SLOT = PLAYER_I + 13  # least frames between two tension gestures of a string
I_LIFT_RAMP = PLAYER_I + 14  # frames in which a finger lets go
I_SLIDE = PLAYER_I + 15  # frames of a slide, where no controller says
I_VIBRATO_SLOT = PLAYER_I + 16  # frames between two tension gestures of a vibrato, a multiple of layout.CHUNK
I_HAMMER = PLAYER_I + 17  # frames in which a hammering finger comes to rest
I_TOUCH = PLAYER_I + 18  # frames for which a node is still touched after the release
I_FLESH = PLAYER_I + 19  # frames in which the softest fingertip lets go
I_REPEAT = PLAYER_I + 20  # keys after which the scale repeats, 12 where there is no other
I_MODE = PLAYER_I + 21
I_BASE = PLAYER_I + 22  # channel of the highest string in guitar mode, 0 .. 15
I_LEVEL_RAMP = PLAYER_I + 23  # frames in which the volume comes to a new value
I_USUAL_FLESH = PLAYER_I + 24  # values of controllers before any message
I_USUAL_MUTE = PLAYER_I + 25
I_USUAL_PLANTING = PLAYER_I + 26
I_USUAL_VARIATION = PLAYER_I + 27
I_USUAL_STRUM = PLAYER_I + 28  # frames in which the hand sweeps over all strings, 0: it does not
I_USUAL_DIRECTION = PLAYER_I + 29
I_SEED = PLAYER_I + 30  # of the variations
I_STROKE_JOIN = PLAYER_I + 31  # frames in which notes join a stroke that has begun, and the hand does not turn
I_STROKE_HOLD = PLAYER_I + 32  # frames that a strummed string sounds at least
I_EASE_RAMP, I_SWITCH_KEY, I_SWITCH_COUNT = (PLAYER_I + k for k in (33, 34, 35))  # the key is 128 for no switches
I_OPEN = PLAYER_I + 40  # key (MIDI note) of each open string
I_FOLD = I_OPEN + ROW  # key that is played for each key, or -1
I_KEY_PITCH = I_FOLD + 128  # of each key, in TUNING_UNITs above MIDI note 0
I_DAMP_OF = I_KEY_PITCH + 128  # frames in which the damper comes down, for each release velocity

# Parameters (d) ----------------------------------------------------------------------------------------------------
D_PLUCK_PLACE = PLAYER_D + 0
D_PLUCK_ANGLE = PLAYER_D + 1
D_HAMMER_SPEED = PLAYER_D + 2  # m/s at velocity 127
D_PULL_FORCE = PLAYER_D + 3  # N at velocity 127
D_PULL_ANGLE = PLAYER_D + 4
D_VIBRATO_CENTS = PLAYER_D + 5  # largest deviation either way
D_VIBRATO_STEP = PLAYER_D + 6  # radians in I_VIBRATO_SLOT frames
D_TOUCH = PLAYER_D + 7  # resistance of the finger at a node, over the wave impedance
D_MUTE = PLAYER_D + 8  # of the hand's edge, for each value of the controller
D_LOOSE = D_MUTE + 128  # of a finger that is half lifted, likewise
D_FRAMES_OF_SLIDE = D_LOOSE + 128  # for each value of the controller
D_FRAMES_OF_PULL = D_FRAMES_OF_SLIDE + 128
D_FRAMES_OF_STRUM = D_FRAMES_OF_PULL + 128
D_PLANT = D_FRAMES_OF_STRUM + 128  # resistance of a planted finger
D_FORCE = D_PLANT + 128  # peak force [N] of each velocity
D_PLACES = D_FORCE + 128  # place [m] of each string and fret
D_LENGTH = D_PLACES + MAX_STRINGS * FRET_ROW  # m
D_STATE = D_LENGTH + ROW

# State (d) ---------------------------------------------------------------------------------------------------------
D_TENSION = D_STATE  # last tension ratio asked of each string
D_BEND = D_TENSION + ROW  # cents that each channel's pitch bend asks for
D_PHASE = D_BEND + CHANNELS  # of each string's vibrato
D_DEPTH = D_PHASE + ROW  # cents that it has now
D_LEVEL = D_DEPTH + ROW  # gain of the sound now
D_LEVEL_GOAL = D_LEVEL + 1
D_LEVEL_STEP = D_LEVEL + 2
D_PLUCKED_PLACE = D_LEVEL + 8  # each string's last pluck, for as long as it may have to be asked for again
D_PLUCKED_FORCE = D_PLUCKED_PLACE + ROW
D_PLUCKED_ANGLE = D_PLUCKED_FORCE + ROW
D_SAVED = D_PLUCKED_ANGLE + ROW  # these three rows as they were before the chord
D_LOG_FORCE = D_SAVED + 3 * ROW
D_END = D_LOG_FORCE + LOG_CAPACITY

# Counters (i) ------------------------------------------------------------------------------------------------------
globals().update({name.upper(): number for number, name in enumerate(COUNTER_NAMES)})  # NOTES_ON and so on

# State (i); what a chord's re-assignment takes back is one block, of which I_SAVED holds a copy -----------------------
I_SWITCHES = I_DAMP_OF + 128  # of each keyswitch: its group, how many controllers; of each its number, off, soft, hard
I_STATE = I_SWITCHES + MOST_SWITCHES * SWITCH_ROW  # first number that player_reset clears
I_COUNTERS = I_STATE
I_TAKEN_BACK = I_COUNTERS + COUNTER_NAMES.index("notes_played")  # from here on a chord's re-assignment takes back
I_HAND = I_COUNTERS + len(COUNTER_NAMES)  # fret under the index finger
I_PLUCKS = I_HAND + 1  # plucks so far: the clock of "longest ago"
I_STROKE = I_HAND + 2  # frame at which the right hand's latest stroke over the strings began
I_STROKE_FROM = I_HAND + 3  # and the string that it began with
I_STROKE_WAY = I_HAND + 4  # 1: from the bass side, -1: from the treble side, 0: there has been none
I_FINGER = I_HAND + 5  # finger that plucked a treble string last, see FINGER_NAMES
I_STRING = I_HAND + 8
S_STATE = I_STRING + 0 * ROW
S_CHANNEL = I_STRING + 1 * ROW
S_KEY = I_STRING + 2 * ROW  # MIDI note as it came
S_PITCH = I_STRING + 3 * ROW  # MIDI note that is played
S_SEQ = I_STRING + 4 * ROW  # number of the note in the log
S_FINGER = I_STRING + 5 * ROW  # fret under the stopping finger, 0: no finger
S_DAMP = I_STRING + 6 * ROW  # frame at which the damper comes down, -1: not asked for
S_LIFT = I_STRING + 7 * ROW  # frame at which the finger lifts, -1
S_UNDAMP = I_STRING + 8 * ROW  # frame at which the damper lifts, -1
S_PRESS = I_STRING + 9 * ROW  # frame at which the finger on its way to S_FINGER lands, -1
S_ORDER = I_STRING + 10 * ROW  # value of I_PLUCKS at its last pluck
S_STAYS = I_STRING + 11 * ROW  # fret of the finger that S_PRESS's will replace or move, 0: none
S_LANDING = I_STRING + 12 * ROW  # frames that S_PRESS's finger takes
S_SPEED = I_STRING + 13 * ROW  # and its speed [um/s], 0: at rest
S_PRESSURE = I_STRING + 14 * ROW  # polyphonic pressure of its note
S_TOUCHED = I_STRING + 15 * ROW  # frame at which what touches it leaves, -1: nothing does
S_RELEASE = I_STRING + 16 * ROW  # frames in which its plucks were last asked to let go
S_LET = I_STRING + 17 * ROW  # 1 + its channel's bend range where a member's note is held by the pedal alone, else 0
S_LET_BEND = I_STRING + 18 * ROW  # and that channel's bend when its key came up
S_MOVED = I_STRING + 19 * ROW  # keys that the tuning has moved its note's key by
S_TUNED = I_STRING + 20 * ROW  # what its note's tuning asks beyond that, in TUNING_UNITs
S_CAUGHT = I_STRING + 21 * ROW  # 1: its key was down when the sostenuto pedal went down
S_PLUCK = I_STRING + 22 * ROW  # frame at which its last pluck begins to pull, -1: none
S_PULL = I_STRING + 23 * ROW  # frames for which it pulls
S_LATE = I_STRING + 24 * ROW  # frames for which the hand, on its way over the strings, let its note wait
S_PLANTED = I_STRING + 25 * ROW  # frame at which the planted finger leaves, -1
# Frames of its damper, of a step of a glissando (0: none); when a finger pulls off (-1), and its fret
S_DAMPS, S_PULLED, S_PULLED_FROM, S_STEP = (I_STRING + k * ROW for k in (26, 27, 28, 29))
S_MUTE, S_LOOSE, S_EASED = (I_STRING + k * ROW for k in (30, 31, 32))  # CC19, CC27 that its note follows; since when
# How many held notes it was slurred from; when it went back to one (-1), from what note and finger
S_HOLDS, S_RESUMED, S_FORMER, S_LEFT = (I_STRING + k * ROW for k in (33, 34, 35, 36))
HOLD_KEY, HOLD_FRET, HOLD_SEQ, HOLD_MOVED, S_END = (I_STRING + (37 + k * HOLDS) * ROW for k in range(5))
I_SAVED_SIZE = S_END - I_TAKEN_BACK
IDLE, HELD, PEDALLED, DAMPING = range(4)  # values of S_STATE

# State that stays (i) ----------------------------------------------------------------------------------------------
I_SAVED = S_END
I_STARTED = I_SAVED + I_SAVED_SIZE  # 0 until the idle strings have been seen to
I_NOW = I_STARTED + 1  # latest frame seen
I_NEXT_SEQ = I_STARTED + 2
I_LOWER = I_STARTED + 3  # 1 + members of MPE's lower zone, 0: as the mode has it
I_UPPER = I_STARTED + 4  # members of the upper zone
S_TENSION_FRAME = I_STARTED + 8  # frame of the last tension gesture
I_CHANNEL = S_TENSION_FRAME + ROW
C_BEND = I_CHANNEL + 0 * CHANNELS  # -8192 .. 8191
C_RANGE = I_CHANNEL + 1 * CHANNELS  # cents, -1: as the preset has it
C_RPN = I_CHANNEL + 2 * CHANNELS  # msb * 128 + lsb, RPN_NULL, or NRPN
C_PEDAL = I_CHANNEL + 3 * CHANNELS
C_STRING = I_CHANNEL + 4 * CHANNELS  # string that CC20 names for notes to come, 1 the highest; 0: free
C_POSITION = I_CHANNEL + 5 * CHANNELS  # fret under the index finger that CC21 names for notes to come; 0: free
C_LEGATO = I_CHANNEL + 6 * CHANNELS  # 1: on, -1: off, 0: on where the channel has one voice
C_GLIDES = I_CHANNEL + 7 * CHANNELS  # portamento is on
C_GLIDE_TIME = I_CHANNEL + 8 * CHANNELS  # 0 .. 127, -1: as the preset has it
C_WHEEL = I_CHANNEL + 9 * CHANNELS  # vibrato asked for by the wheel
C_PRESSURE = I_CHANNEL + 10 * CHANNELS  # and by the channel's pressure
C_PLACE = I_CHANNEL + 11 * CHANNELS  # of the pluck, 64: as the preset has it
C_ANGLE = I_CHANNEL + 12 * CHANNELS
C_HARMONIC = I_CHANNEL + 13 * CHANNELS  # notes to come are harmonics
C_MUTE = I_CHANNEL + 14 * CHANNELS  # 0: not muted; here and below -1: as the preset has it
C_FLESH = I_CHANNEL + 15 * CHANNELS  # how softly plucks let go
C_FINE = I_CHANNEL + 16 * CHANNELS  # RPN 1, 0 .. 16383
C_COARSE = I_CHANNEL + 17 * CHANNELS  # RPN 2, 0 .. 127
C_DEPTH = I_CHANNEL + 18 * CHANNELS  # RPN 5: vibrato's depth in 1/128 semitone, -1: as the preset has it
C_SOSTENUTO = I_CHANNEL + 19 * CHANNELS
C_SOFT = I_CHANNEL + 20 * CHANNELS
C_MONO = I_CHANNEL + 21 * CHANNELS  # 1 + channel of the CC 126 that gave it one voice, -1: many, 0: as the mode has it
C_ATTACK = I_CHANNEL + 22 * CHANNELS  # how long they pull, 64: as the preset has it
C_STRUM = I_CHANNEL + 23 * CHANNELS
C_DIRECTION = I_CHANNEL + 24 * CHANNELS
C_VARIATION = I_CHANNEL + 25 * CHANNELS
C_PLANTING = I_CHANNEL + 26 * CHANNELS
C_LOOSE, C_FRETS = I_CHANNEL + 27 * CHANNELS, I_CHANNEL + 28 * CHANNELS  # half lift; slides go over the frets
I_OWED = I_CHANNEL + 29 * CHANNELS  # note-offs still to come for notes that sound no more, by channel and key
RPN_NULL = 0x3FFF
NRPN = 0x4000
RPN_FINE, RPN_COARSE, RPN_DEPTH = 1, 2, 5

# The whole guitar (i) ------------------------------------------------------------------------------------------------
I_WHOLE = I_OWED + CHANNELS * 128
I_VOLUME = I_WHOLE + 0
I_EXPRESSION = I_WHOLE + 1
I_MASTER_VOLUME = I_WHOLE + 2
I_LEVEL_LEFT = I_WHOLE + 3  # frames until the volume is what it is to be
I_MASTER_FINE = I_WHOLE + 4  # 0 .. 16383
I_MASTER_COARSE = I_WHOLE + 5  # 0 .. 127
I_SYSEX_LENGTH = I_WHOLE + 6  # bytes of the SysEx that has begun, 0: none
I_SCALE = I_WHOLE + 8  # TUNING_UNITs, by channel and key modulo 12
I_NOTE_PITCH = I_SCALE + CHANNELS * 12  # TUNING_UNITs above MIDI note 0 that a key has been given, -1: none
I_SYSEX = I_NOTE_PITCH + 128

# The chord of the present frame (i) -----------------------------------------------------------------------------------
I_GROUP = I_SYSEX + SYSEX_BYTES
G_FRAME = I_GROUP + 0
G_COUNT = I_GROUP + 1
G_VICTIMS = I_GROUP + 2
G_DONE = I_GROUP + 3  # gestures that had been carried out when it was decided
GROUP_FIELDS = 14
I_GROUP_ROWS = I_GROUP + 8
G_KEY = I_GROUP_ROWS + 0 * ROW
G_CHANNEL = I_GROUP_ROWS + 1 * ROW
G_PITCH = I_GROUP_ROWS + 2 * ROW
G_SEQ = I_GROUP_ROWS + 3 * ROW
G_OFF = I_GROUP_ROWS + 4 * ROW  # its note-off has come already
G_STRING = I_GROUP_ROWS + 5 * ROW  # string it was given, -1: none
G_REPEAT = I_GROUP_ROWS + 6 * ROW  # string that still sounds the same key of the same channel, -1
G_FORCED = I_GROUP_ROWS + 7 * ROW  # string it is to be played on, 1 the highest; 0: any
G_POSITION = I_GROUP_ROWS + 8 * ROW  # fret under the index finger, 0: any
G_WAY = I_GROUP_ROWS + 9 * ROW  # how it is played, see WAY_NAMES
G_WANTED = I_GROUP_ROWS + 10 * ROW  # pitch the string is to be stopped at, before any folding
G_PARTIAL = I_GROUP_ROWS + 11 * ROW  # which of its partials is to sound, 0: all
G_MOVED = I_GROUP_ROWS + 12 * ROW  # keys that its tuning has moved it by
G_CAUGHT = I_GROUP_ROWS + 13 * ROW  # the sostenuto pedal has gone down since
V_SEQ = I_GROUP_ROWS + 14 * ROW  # notes of the log that this chord ended (two rows: strings and dropped notes)
V_OWED = I_GROUP_ROWS + 16 * ROW  # index into I_OWED that went up by one for it, -1
I_SEARCH = V_OWED + 2 * ROW

# Scratch of the search (i) -------------------------------------------------------------------------------------------
X_COST = I_SEARCH  # [MAX_GROUP][ROW] points of a note on a string
X_TAKER = X_COST + MAX_GROUP * ROW  # note on each string, -1
X_PARENT = X_TAKER + ROW
X_QUEUE = X_PARENT + ROW
X_ORDER = X_QUEUE + ROW  # notes by importance
X_TRY = X_ORDER + ROW
X_SUM = X_TRY + ROW
X_LOW = X_SUM + ROW
X_HIGH = X_LOW + ROW
X_REST = X_HIGH + ROW
X_PICK = X_REST + ROW
X_FREED = X_PICK + ROW  # what becomes of the string's note
X_LATE = X_FREED + ROW  # frames for which the hand, strumming, lets a note wait, or one of the two below
X_FINGER = X_LATE + ROW  # that plucks it
BY_FINGER, NOT_PLUCKED = -1, -2
KEPT, REPEATING, SLURRING = range(3)  # it stays, is replaced by a repeat of itself, may be slurred into another

# Note log (i), a ring of LOG_CAPACITY --------------------------------------------------------------------------------
I_LOG = X_FINGER + ROW
L_FRAME = I_LOG + 0 * LOG_CAPACITY
L_END = I_LOG + 1 * LOG_CAPACITY  # frame, -1: rings
L_KEY = I_LOG + 2 * LOG_CAPACITY
L_CHANNEL = I_LOG + 3 * LOG_CAPACITY
L_STRING = I_LOG + 4 * LOG_CAPACITY  # -1: none
L_FRET = I_LOG + 5 * LOG_CAPACITY
L_FATE = I_LOG + 6 * LOG_CAPACITY
L_WAY = I_LOG + 7 * LOG_CAPACITY
L_LATE = I_LOG + 8 * LOG_CAPACITY  # frames for which a strum let it wait
L_FINGER = I_LOG + 9 * LOG_CAPACITY
I_END = I_LOG + 10 * LOG_CAPACITY

if D_END - PLAYER_D > PLAYER_D_SIZE or I_END - PLAYER_I > PLAYER_I_SIZE:
    raise ImportError(f"the player needs {D_END - PLAYER_D} float64 and {I_END - PLAYER_I} int64, layout.py gives less")

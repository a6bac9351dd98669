"""The player's constants: how much it can hold, its rules and their weights, and the words of its log.

What they mean for a musician stands in ``ukrt/playing/README.md``.
"""

# Capacities --------------------------------------------------------------------------------------------------------
ROW = 16  # strings or group notes in a row of state, >= MAX_STRINGS
FRET_ROW = 32  # frets of one string in the table of places
MAX_GROUP = 16  # notes of one frame that are weighed against each other; > MAX_STRINGS, so dropped ones can give way
LOG_CAPACITY = 16384  # notes the log holds; older ones are overwritten and counted
CHANNELS = 16
SEARCH_NODES = 1024  # partial assignments looked at for one chord before the best one found is taken

# Rules -------------------------------------------------------------------------------------------------------------
PERCUSSION_CHANNEL = 9  # channel 10 in a musician's count
PLACE_BRIDGE, PLACE_NECK = 0.97, 0.70  # share of L: sul ponticello, sul tasto at its utmost (estimates)
LEAST_SHARE = 0.25  # of what sounds, that a pluck keeps from the finger (estimate)
MUTE_PLACE = 0.95  # share of L where the hand's edge lies: 3 cm from the bridge (estimate)
PLANT_BESIDE = 0.005  # share of L by which a planted fingertip's middle lies before the point it plucks at (estimate)
LOOSE_OFFSET = -0.002  # m from the fret to where a half-lifted fingertip still touches (estimate)
MOST_SWITCHES, SWITCH_ROW, HOLDS = 16, 16, 4  # HOLDS: keys that a string remembers as held below the one that sounds
UNTIL_DAMPED = 1 << 60  # frame at which a touch leaves that stays for the whole note
FINGERS = 4  # of the left hand that stop strings
MOST_STRING_NUMBER = 12  # largest string that CC20 can name, whatever guitar is played
MAX_BEND_CENTS = 1200  # tension ratio 1/4 .. 4: an octave either way
TUNING_UNIT = 16384  # in a cent: every step of every MIDI tuning message is a whole number of units
MIDDLE_FINE, MIDDLE_COARSE = 8192, 64  # values of tunings that change nothing
FINE_UNITS = 200  # TUNING_UNITs for each step of 14 bits over +-100 cents
MAX_DEPTH = 12 * 128  # widest vibrato of RPN 5, in 1/128 semitone (choice: as bends, an octave)
SOFT_FORCE = 0.7  # of the pluck's force with the soft pedal down: -3 dB (estimate)
SOFT_FLESH = 48  # and so much more of CC 18 (estimate)
FULL_VOLUME, FULL_EXPRESSION, FULL_MASTER = 100, 127, 16383  # values of 0 dB; 100 is what General MIDI begins with
MAX_RANGE_CENTS = 9600  # the widest that MPE knows (M1-100-UM, 2.4)
MEMBER_RANGE_CENTS, MASTER_RANGE_CENTS = 4800, 200  # bend ranges in a zone before any RPN 0 (M1-100-UM, 2.4)
MOST_MEMBERS = 15  # channels of a zone beside its master
LAST_CHANNEL = CHANNELS - 1
KEYBOARD, GUITAR, MPE, GUITAR_MPE = range(4)  # modes, in the order of ukrt.model.parameters.MIDI_MODES

# Costs of a choice, in points. What is forced outweighs all; steals outweigh every stretch, stretches every shift,
# shifts most preferences.
COST_OTHER_STRING = 100_000_000  # another string than the one that CC20 names
COST_OTHER_POSITION = 10_000  # a fret that the hand does not cover where CC21 puts it; less than a stretch
COST_STEAL_HELD = 4_000_000
COST_STEAL_PEDALLED = 1_000_000
COST_STRETCH = 20_000  # for each fret beyond the span and each finger beyond four
COST_YOUTH = 200  # for each string plucked longer ago than the one that is stolen
COST_SHIFT = 6  # for each fret the hand moves
COST_SHIFT_ANY = 15  # for moving at all
COST_FRET = 2  # for each fret up the neck
COST_CROSSED = 8  # for each pair of notes in another order than their open strings
COST_BUSY = 3  # the string is just being damped
BONUS_SAME = 20  # this string played this pitch last
BONUS_REPEAT = 3000  # this string still sounds this very note
UNPLAYABLE = 1 << 40

# Words of the log ----------------------------------------------------------------------------------------------------
FATE_NAMES = ("played", "stolen", "repeated", "silenced", "dropped", "percussion", "slurred")
PLAYED, STOLEN, REPEATED, SILENCED, DROPPED, PERCUSSION, SLURRED = range(len(FATE_NAMES))
WAY_NAMES = ("pluck", "hammer-on", "pull-off", "slide", "harmonic", "muted")
PLUCKED, HAMMERED, PULLED, SLID, HARMONIC, MUTED = range(len(WAY_NAMES))
FINGER_NAMES = (None, "p", "i", "m", "a")
NO_FINGER, THUMB, INDEX, MIDDLE_FINGER, RING = range(len(FINGER_NAMES))

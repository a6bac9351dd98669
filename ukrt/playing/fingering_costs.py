"""What playing costs a guitarist, in points: every weight of the search for string and fret, in one place.

The points have no unit; only their order and their proportions matter. From the top: a hand that no guitarist has, a
ringing note that is cut short, a stretch, a shift, and mere preferences. All are estimates, set so that scales, chords
and studies come out as method books finger them (``tests/playing/test_published_fingerings.py``); the form, a cheapest
path through the ways to play each chord, is S. I. Sayegh's: Fingering for string instruments with the optimum path
paradigm, Computer Music Journal 13(3), 76-84 (1989).
"""

# What cannot be held -----------------------------------------------------------------------------------------------
BEYOND_HAND = 200_000.0  # no hand is like this; only where every way to play the new notes alone is so
BEYOND_HAND_M = 1_000_000.0  # for each metre beyond the widest stretch, so that the least bad way is taken
BEYOND_FINGERS = 50_000.0  # for each finger more than the hand has
WIDEST = 1.3  # widest stretch over the comfortable one: a fifth fret in first position (estimate)

# What is lost ------------------------------------------------------------------------------------------------------
CUT_HELD = 10_000.0  # a note whose key is down ends early: its string or its finger is needed
CUT_HELD_ALL = 10_000.0  # this much more for all of its length, less for less of it
CUT_PEDALLED = 4_000.0  # a note that only the pedal holds loses its string
LEGATO_SECONDS = 0.05  # a keyboard's overlap: a note that ends so soon is no reason to leave its string (estimate)

# What is not as it is meant ----------------------------------------------------------------------------------------
SLUR_LOST = 1_000.0  # a note that is to be slurred has to be plucked: worth any shift and most stretches (estimate)

# The left hand -----------------------------------------------------------------------------------------------------
STRETCH_M = 2_000.0  # for each metre from the first finger to the last beyond the comfortable reach: 2 points a mm
BARRE = 10.0  # one finger across several strings: strength, and it mutes what lies under it
FINGER = 1.0  # each finger that is down: open strings are easy
SHIFT = 15.0  # moving at all: the eye and the ear lose their place
SHIFT_M = 240.0  # for each metre the hand moves: about 6 points a fret in the middle of the neck
HURRY_SECONDS = 0.15  # a shift in this time costs twice its way (estimate)
LEAST_SECONDS = 0.01  # there is no less time than this

# Preferences -------------------------------------------------------------------------------------------------------
FRET = 2.0  # for each fret of a new note: low positions ring longer and are read first
CROSSED = 8.0  # a lower voice on a higher string, for each pair
OTHER_STRING = 20.0  # the pitch that sounded just before, now on another string

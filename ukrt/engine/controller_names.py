"""What a player's own controllers can be made to do: names of the functions that controllers reach, and their numbers.

The numbers' meanings stand in `controller_layout.CONTROLLERS`; a test holds the two together.
"""

from ukrt.engine import controller_layout as cc

NOTHING = "nothing"
FUNCTIONS = {
    "vibrato": cc.WHEEL,
    "slide-time": cc.GLIDE_TIME,
    "angle": cc.ANGLE,
    "harmonics": cc.HARMONIC,
    "release": cc.FLESH,
    "mute": cc.MUTE,
    "attack": cc.ATTACK,
    "planting": cc.PLANTING,
    "strum": cc.STRUM,
    "strum-direction": cc.DIRECTION,
    "variation": cc.VARIATION,
    "string": cc.STRING,
    "position": cc.POSITION,
    "volume": cc.VOLUME,
    "expression": cc.EXPRESSION,
    "sostenuto": cc.SOSTENUTO,
    "soft": cc.SOFT,
    "half-lift": cc.LOOSE,
    "frets": cc.FRETS,
    "pedal": cc.PEDAL,
    "portamento": cc.GLIDE,
    "legato": cc.LEGATO,
    "place": cc.PLACE,
}
# Controllers that are parts of other messages, or that no knob is for: neither learned nor a function's.
NO_KNOBS = (
    cc.BANK_MSB,
    cc.BANK_LSB,
    cc.DATA_MSB,
    cc.DATA_LSB,
    *range(cc.INCREMENT, cc.RPN_MSB + 1),
    *range(cc.SOUND_OFF, 128),
)

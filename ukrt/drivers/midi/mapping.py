"""Which knob or pedal of a player's own plays what: a TOML file enters, the stage's table leaves; and back.

The file stands at the platform's usual place for settings and is written by ``ukrt play --learn``; it can be edited by
hand as well. What is wrong with it is refused in one sentence with file and key.
"""

import dataclasses
import os
import pathlib
import re

from platformdirs import user_config_dir

from ukrt.engine import map_layout
from ukrt.engine.controller_names import FUNCTIONS, NO_KNOBS, NOTHING
from ukrt.errors import ParameterError
from ukrt.model.fields import Checked, choice, integer, parts, text
from ukrt.model.preset_text import dump_preset
from ukrt.model.presets import build_checked, read_toml

FILE_NAME = "controllers.toml"
PRESSURE, BEND = "pressure", "bend"
MOST_MAPPED = 256
_HEAD = "# Controllers as `ukrt play --learn` has learned them; `ukrt play --no-mapping` leaves them out.\n"


def mapping_path():
    """The user's own file (Path), there or not: in ``UKRT_CONFIG_DIR`` if set, else at the platform's usual place."""
    return pathlib.Path(os.environ.get("UKRT_CONFIG_DIR") or user_config_dir("ukrt")) / FILE_NAME


@dataclasses.dataclass(frozen=True)
class Mapped(Checked):
    """One knob, pedal or wheel, and what it plays."""

    function: str = choice((*FUNCTIONS, NOTHING), "what it plays")
    source: str = text('what is moved: "CC 0" to "CC 119", "pressure" (of the channel) or "bend"')
    channel: int = integer(0, 16, "on which it comes, 0: any", 0)
    plays_channel: int = integer(0, 16, "for whose notes it counts, 0: those of its own", 0)
    low: int = integer(0, 127, "what its lowest value means; above high it works the other way round", 0)
    high: int = integer(0, 127, "what its highest value means", 127)

    def cross_check(self):
        if self.number is None:
            words = 'it must be "CC 0" to "CC 119", "pressure" or "bend"'
            raise ParameterError("source", self.source, words)
        if self.number in NO_KNOBS:
            raise ParameterError("source", self.source, "banks, data entry and its parameter numbers mean themselves")

    @property
    def number(self):
        """The source's column in the stage's table (int), None where the text names none."""
        if self.source in (PRESSURE, BEND):
            return map_layout.PRESSURE_SOURCE if self.source == PRESSURE else map_layout.BEND_SOURCE
        found = re.fullmatch(r"CC (\d{1,3})", self.source)
        return int(found[1]) if found and int(found[1]) <= map_layout.LAST_SOURCE else None

    @property
    def channels(self):
        """The channels it comes on, from 0 (range)."""
        return range(16) if self.channel == 0 else range(self.channel - 1, self.channel)

    @property
    def entry(self):
        """What the table holds for it (int)."""
        if self.function == NOTHING:
            return map_layout.DROPPED
        return map_layout.map_entry(FUNCTIONS[self.function], self.low, self.high, self.plays_channel - 1)

    def __str__(self):
        where = f" of channel {self.channel}" if self.channel else ""
        range_ = "" if (self.low, self.high) == (0, 127) else f" ({self.low} to {self.high})"
        whom = f" of channel {self.plays_channel}" if self.plays_channel else ""
        return f"{self.source}{where} plays {self.function}{range_}{whom}"


@dataclasses.dataclass(frozen=True)
class Mapping(Checked):
    """All of a player's own controllers."""

    controllers: tuple = parts(Mapped, (0, MOST_MAPPED), "knobs, pedals and wheels, and what they play", ())

    def cross_check(self):
        seen = {}
        for n, one in enumerate(self.controllers):
            for channel in one.channels:
                first = seen.setdefault((channel, one.number), n)
                if first != n:
                    words = f"controllers.{first} is the same on channel {channel + 1}; each may play one thing"
                    raise ParameterError(f"controllers.{n}.source", one.source, words)

    def table(self):
        """Entries of the stage's table by (channel, source), see `ukrt.engine.stage.Stage.set_map` (dict)."""
        return {(channel, one.number): one.entry for one in self.controllers for channel in one.channels}

    def learned(self, new):
        """With ``new`` (Mapped) in it, and without what its source, or another one for its function on the same
        channel, was before (Mapping)."""
        taken = {(channel, new.number) for channel in new.channels}
        kept = [one for one in self.controllers if not taken & {(channel, one.number) for channel in one.channels}]
        kept = [one for one in kept if one.function != new.function or one.channel != new.channel]
        return Mapping((*kept, new))

    def without(self, function):
        """Without whatever plays ``function`` (Mapping)."""
        return Mapping(tuple(one for one in self.controllers if one.function != function))

    def __str__(self):
        return ", ".join(map(str, self.controllers)) or "every controller means what its number says"


def load_mapping(path):
    """Read a mapping.

    Raises
    ------
    PresetError
        One sentence that names file, key, what was found and what is legal.
    """
    path = pathlib.Path(path)
    source = f"mapping {path}"
    return build_checked(Mapping, read_toml(path, source), source)


def mapping_text(mapping):
    """TOML that `load_mapping` reads back to the same (str)."""
    return _HEAD + dump_preset(mapping)

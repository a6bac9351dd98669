"""Cases as TOML: a file enters, a checked `Case` leaves; what is wrong is refused in one sentence with file and key.

The guitar is a preset's name (or the path of a file, relative to the case's) or a table: a preset as ``base`` with
other keys laid over it. Without one it is the preset `paper`.
"""

import pathlib

from ..errors import ParameterError, PresetError
from ..model.preset_text import COMMENT_COLUMN, dump_preset
from ..model.presets import build_checked, load_preset, overlaid_preset, parse_toml, read_toml
from ..model.settings import apply_setting
from .case import Case, ForceRamp, HeldString, Point, Record

DEFAULT_GUITAR = "paper"
_GUITAR_LINE = f'guitar = "{DEFAULT_GUITAR}"'
SETTINGS = "the settings"


def load_case(path, overrides=None):
    """Read a case.

    Parameters
    ----------
    path : str or os.PathLike
    overrides : dict, optional
        Dotted keys and their values, as text or as numbers: ``{"plucks.0.force_y": "5", "guitar.basis.bandwidth_hz":
        5000.0, "guitar": "classical"}``. They change a case that is legal without them.

    Returns
    -------
    ukrt.experiment.case.Case

    Raises
    ------
    ukrt.errors.PresetError
        One sentence that names the file, the key, what was found and what is legal.
    """
    path = pathlib.Path(path)
    source = f"case {path}"
    return _case(read_toml(path, source), path.parent, source, overrides or {})


def parse_case(text, source):
    """A case that is at hand as text, such as `ukrt.model.preset_text.dump_preset` writes it; ``source`` names it."""
    return _case(parse_toml(text, source), pathlib.Path(), source, {})


def example_text():
    """A complete case as TOML, every key with its unit, range and meaning; it can be loaded (str)."""
    case = Case(
        name="stopped E2",
        description="The fifth fret of E2 plucked obliquely, as in Fig. 6 of the paper but with losses",
        duration=1.0,
        guitar=load_preset(DEFAULT_GUITAR),
        held=(HeldString("E2", 0.2509),),
        plucks=(ForceRamp("E2", 0.9, 0.0, 0.010, 2.0, 1.0),),
        record=Record(displacement=(Point("E2", 0.6, "Y"), Point("E2", 1.0, "Y")), energies=True, tension=True),
    )
    lines, inside = [], False
    for line in dump_preset(case).splitlines():
        if line.startswith("["):
            inside = line.strip("[]").split(".")[0] == "guitar"
        if not inside:
            lines.append(line)
    words = 'a preset\'s name or file; or, as a table [guitar], base = "paper" and what is to differ'
    lines.insert(2, f"{_GUITAR_LINE:<{COMMENT_COLUMN}}  # {words}")
    return "\n".join(lines) + "\n"


def _case(tree, folder, source, overrides):
    guitar = tree.pop("guitar", DEFAULT_GUITAR)
    case = _built(tree, guitar, folder, source)
    overrides = dict(overrides)
    if "guitar" in overrides:
        case = _built(tree, overrides.pop("guitar"), pathlib.Path(), SETTINGS)
    if not overrides:
        return case
    whole = parse_toml(dump_preset(case), source)
    try:
        for key, value in overrides.items():
            apply_setting(whole, Case, key, value)
    except ParameterError as error:
        raise PresetError(f"{SETTINGS}: {error}", error.key, error.value, error.legal) from None
    return build_checked(Case, whole, SETTINGS)


def _built(tree, guitar, folder, source):
    """The case of a tree without its guitar, and of a guitar by name or as a table."""
    if isinstance(guitar, str):
        guitar = {"base": guitar}
    if not isinstance(guitar, dict):
        words = f"{source}: guitar is {guitar!r}, but it must be a preset's name or a table"
        raise PresetError(words, "guitar", guitar)
    whole = overlaid_preset(guitar, folder, f"{source}, table guitar")
    return build_checked(Case, {**tree, "guitar": whole}, source)

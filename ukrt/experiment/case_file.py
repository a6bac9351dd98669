"""Cases as TOML: a file enters, a checked `Case` leaves; what is wrong is refused in one sentence with file and key.

The guitar is a preset's name (or the path of a file, relative to the case's) or a table: a preset as ``base`` with
other keys laid over it. Without one it is the preset `paper`.
"""

import pathlib

from ..errors import PresetError
from ..model.presets import build_checked, overlaid_preset, read_toml
from .case import Case

DEFAULT_GUITAR = "paper"


def load_case(path):
    """Read a case.

    Parameters
    ----------
    path : str or os.PathLike

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
    tree = read_toml(path, source)
    guitar = tree.get("guitar", DEFAULT_GUITAR)
    if isinstance(guitar, str):
        guitar = {"base": guitar}
    if not isinstance(guitar, dict):
        words = f"{source}: guitar is {guitar!r}, but it must be a preset's name or a table"
        raise PresetError(words, "guitar", guitar)
    tree["guitar"] = overlaid_preset(guitar, path.parent, f"{source}, table guitar")
    return build_checked(Case, tree, source)

"""MIDI files that come with the package, by name."""

import pathlib

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "data"
ROMANCE = FOLDER / "romance.mid"  # what is played where nothing is named


def bundled_pieces():
    """All of them: name -> Path (dict)."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.mid"))}

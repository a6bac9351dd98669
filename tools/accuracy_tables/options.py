"""Words of the command line made into numbers; what is wrong is refused by argparse in one sentence."""

import argparse
import pathlib


def whole_numbers(low, high):
    """A type for argparse: lists such as ``0-5,7,12`` of whole numbers from ``low`` to ``high``."""

    def read(text):
        found = []
        try:
            for part in text.split(","):
                first, _, last = part.partition("-")
                found += range(int(first), int(last or first) + 1)
        except ValueError:
            found = []
        if not found or min(found) < low or max(found) > high:
            raise argparse.ArgumentTypeError(f"{text!r} is not a list such as 0-5,7 of numbers from {low} to {high}")
        return tuple(dict.fromkeys(found))

    return read


def one_of_each(legal):
    """A type for argparse: lists of the ``legal`` numbers, separated by commas."""

    def read(text):
        try:
            found = tuple(dict.fromkeys(float(part) for part in text.split(",")))
        except ValueError:
            found = ()
        if not found or not set(found) <= set(legal):
            names = ", ".join(f"{one:g}" for one in legal)
            raise argparse.ArgumentTypeError(f"{text!r} is not a list of some of {names}")
        return found

    return read


def file(ending):
    """A type for argparse: a file with this ending in a folder that exists."""

    def read(text):
        path = pathlib.Path(text)
        if path.suffix.lower() != f".{ending}" or not path.resolve().parent.is_dir():
            raise argparse.ArgumentTypeError(f"{text!r} is not a file *.{ending} in a folder that exists")
        return path

    return read


def picture(text):
    """A type for argparse: a PNG file in a folder that exists, and matplotlib to draw it."""
    path = file("png")(text)
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise argparse.ArgumentTypeError("it needs matplotlib, which is missing: pip install 'ukrt[plot]'") from None
    return path


def jobs(text):
    """A type for argparse: a number of processes."""
    if not text.isdigit() or not 1 <= int(text) <= 64:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of processes from 1 to 64")
    return int(text)

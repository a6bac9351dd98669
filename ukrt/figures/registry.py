"""Which figures there are: a number enters, the module that makes and draws it leaves.

Such a module has ``NUMBER``, ``TITLE``, ``make(run) -> FigureData`` and ``draw(data, figure)`` on a matplotlib Figure.
"""

import importlib

from ..errors import ParameterError

NUMBERS = (2, 3, 5, 6, 7, 8, 9, 10, 11, 12, 13)  # 1 is a photograph, 4 a sketch


def stem(number):
    """What the files of a figure are called, and its module (str)."""
    return f"figure_{number:02d}"


def load_figure(number):
    """The module of figure ``number``, imported when it is asked for.

    Raises
    ------
    ParameterError
        There is no such figure.
    """
    if number not in NUMBERS:
        raise ParameterError("figure", number, f"the figures there are: {', '.join(map(str, NUMBERS))}")
    return importlib.import_module(f".{stem(number)}", __package__)

"""How this program starts another Python with a module of its own."""

import os
import pathlib
import sys

_ROOT = pathlib.Path(__file__).resolve().parents[1]


def python_module(name, *arguments):
    """What `subprocess.Popen` needs to run ``python -m NAME ARGUMENTS`` from the same sources, from any folder.

    Parameters
    ----------
    name : str
        Of the module.
    *arguments : str

    Returns
    -------
    dict
        ``args`` and ``env``.
    """
    paths = filter(None, [str(_ROOT), os.environ.get("PYTHONPATH")])
    return {
        "args": [sys.executable, "-P", "-m", name, *arguments],
        "env": {**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
    }

"""The scripts in tools/, as modules."""

import importlib.util
import pathlib

_TOOLS = pathlib.Path(__file__).resolve().parents[1] / "tools"


def load_tool(name):
    """The module tools/``name``.py."""
    spec = importlib.util.spec_from_file_location(name, _TOOLS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module

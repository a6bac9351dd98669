"""A nylon-string guitar computed from its physics in real time; here stand the public names, nothing else.

>>> import ukrt
>>> sound, report = ukrt.render("song.mid", preset="classical", sample_rate=48000)  # doctest: +SKIP
"""

import importlib

__version__ = "0.1.0"
__all__ = ["Synth", "__version__", "load_preset", "preset_names", "render"]

_HOMES = {  # public name -> module; imported when first asked for, so that `import ukrt` costs nothing
    "Synth": "ukrt.synth",
    "load_preset": "ukrt.model.presets",
    "preset_names": "ukrt.model.presets",
    "render": "ukrt.render",
}


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module 'ukrt' has no attribute {name!r}; public names are {', '.join(__all__)}")
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(__all__)

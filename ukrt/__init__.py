"""A nylon-string guitar computed from its physics in real time; here stand the public names, nothing else.

>>> import ukrt
>>> sound, report = ukrt.render("song.mid", preset="classical", sample_rate=48000)  # doctest: +SKIP
"""

import importlib
import sys
import types

__version__ = "0.1.0"
__all__ = ["Synth", "__version__", "load_preset", "preset_names", "render", "tuning_warnings"]

_HOMES = {  # public name -> module; imported when first asked for, so that `import ukrt` costs nothing
    "Synth": "ukrt.synth",
    "load_preset": "ukrt.model.presets",
    "preset_names": "ukrt.model.presets",
    "render": "ukrt.render",
    "tuning_warnings": "ukrt.model.string_limits",
}


class _Package(types.ModuleType):
    def __getattr__(self, name):
        if name not in _HOMES:
            raise AttributeError(f"module 'ukrt' has no attribute {name!r}; public names are {', '.join(__all__)}")
        return getattr(importlib.import_module(_HOMES[name]), name)

    def __setattr__(self, name, value):
        # Importing the module ukrt.render binds its name here, which would hide the function that the name stands for.
        if name not in _HOMES or not isinstance(value, types.ModuleType):
            super().__setattr__(name, value)

    def __dir__(self):
        return sorted({*super().__dir__(), *__all__})


sys.modules[__name__].__class__ = _Package

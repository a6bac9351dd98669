"""Presets: TOML text and settings of single keys enter, a checked `Guitar` leaves; anything unknown, mistyped or out of
range is refused in one sentence that names file, key, value and what is legal."""

import dataclasses
import difflib
import os
import tomllib
from dataclasses import MISSING
from pathlib import Path

from ..errors import ParameterError, PresetError
from .parameters import Guitar
from .settings import apply_setting, indexed, merge
from .tunings import OPEN_STRINGS, expand

_PACKAGE = Path(__file__).resolve().parents[1]
_FOLDERS = (_PACKAGE / "presets", _PACKAGE.parent / "presets")  # in the wheel, in the checkout


def preset_names():
    """Names of the presets that come with the package, sorted."""
    return sorted({path.stem for folder in _FOLDERS if folder.is_dir() for path in folder.glob("*.toml")})


def load_preset(name_or_path, overrides=None):
    """Read a preset.

    Parameters
    ----------
    name_or_path : str or os.PathLike
        A name out of `preset_names`, or the path of a file that ends in ``.toml``.
    overrides : dict, optional
        Dotted keys and their values, as text or as numbers: ``{"strings.0.tension": "70"}``. As in files,
        ``tuning.scale`` and ``tuning.keyboard`` may be names of Scala's files, and ``tuning.open_strings``, such as
        "DADGBE", stands for notes, names and tensions of all strings: see `tunings.parse_tuning`.

    Returns
    -------
    Guitar
    """
    path = _locate(os.fspath(name_or_path))
    return _guitar(_read(path, ()), f"preset {path}", overrides)


def parse_preset(text, source, overrides=None):
    """Read a preset that is at hand as text, such as `ukrt.model.preset_text.dump_preset` writes it.

    Parameters
    ----------
    text : str
        TOML without ``base``.
    source : str
        What the text is called in error messages.
    overrides : dict, optional
        As for `load_preset`.

    Returns
    -------
    Guitar
    """
    return _guitar(parse_toml(text, source), source, overrides)


def overlaid_preset(tree, folder, source):
    """The guitar of a table inside another file: a preset where it names a ``base``, with its other keys laid over it.

    Parameters
    ----------
    tree : dict
    folder : pathlib.Path
        What a ``base`` that is a file is relative to.
    source : str
        What the table is called in error messages.

    Returns
    -------
    Guitar
    """
    return _guitar(_on_base(dict(tree), folder, source, ()), source, None)


def build_checked(cls, tree, source):
    """An object of parameter class ``cls`` from nested dicts and lists; refused in a sentence that names ``source``."""
    try:
        return _build(cls, tree)
    except ParameterError as error:
        raise _sentence(source, error) from None


def read_toml(path, source):
    """A TOML file as nested dicts and lists; unreadable ones are refused by the name ``source``."""
    try:
        return parse_toml(path.read_text(encoding="utf-8"), source)
    except OSError as error:
        raise PresetError(f"{source} cannot be read: {error.strerror or error}", value=str(path)) from None
    except UnicodeDecodeError:
        raise PresetError(f"{source} is not a text file in UTF-8", value=str(path)) from None


def _guitar(tree, source, overrides):
    """The guitar that a tree describes, with settings laid over it."""
    try:
        for key, value in (overrides or {}).items():
            if key == OPEN_STRINGS:  # at once: settings that follow change what it has made
                tree["tuning"] = {**tree.get("tuning", {}), "open_strings": value}
                expand(tree, Path(), "the settings")
            else:
                apply_setting(tree, Guitar, key, value)
        expand(tree, Path(), "the settings")
    except ParameterError as error:
        raise _sentence("the settings", error) from None
    try:
        return _build(Guitar, tree)
    except ParameterError as error:
        by_hand = any(f"{error.key}.".startswith(f"{key}.") for key in overrides or {})
        raise _sentence("the settings" if by_hand else source, error) from None


def parse_toml(text, source):
    """TOML text as nested dicts and lists; what is no TOML is refused by the name ``source``."""
    try:
        return tomllib.loads(text)
    except ValueError as error:  # not only TOMLDecodeError: whole numbers of thousands of digits
        reason = str(error).split("\n")[0].rstrip(".")
        raise PresetError(f"{source} is not valid TOML: {reason}", value=source) from None
    except RecursionError:
        raise PresetError(f"{source} is not valid TOML: it is nested too deeply", value=source) from None


def _locate(name):
    if name.lower().endswith(".toml"):
        return Path(name)
    for folder in _FOLDERS:
        if name in preset_names() and (folder / f"{name}.toml").is_file():
            return folder / f"{name}.toml"
    known = ", ".join(preset_names())
    message = f'no preset is called "{name}": there are {known}, or give the path of a .toml file'
    raise PresetError(message + _did_you_mean(name, preset_names()), key="preset", value=name, legal=known)


def _read(path, seen):
    """The tree of a preset file, laid over that of its ``base`` where it names one."""
    if path.resolve() in seen:
        raise PresetError(f"preset {seen[-1]}: its base leads back to itself", "base", str(path))
    source = f"preset {path}"
    return _on_base(read_toml(path, source), path.parent, source, (*seen, path.resolve()))


def _on_base(tree, folder, source, seen):
    """A tree laid over that of its ``base`` where it names one, files and tunings that it names written out."""
    base = tree.pop("base", None)
    if base is not None and not isinstance(base, str):
        raise PresetError(f"{source}: base is {base!r}, but it must be a preset's name in quotes", "base", base)
    try:
        if base is not None:
            below = folder / base if base.lower().endswith(".toml") else _locate(base)
            tree = merge(_read(below, seen), tree)
        expand(tree, folder, source)
        return tree
    except ParameterError as error:
        raise _sentence(source, error) from None


def _build(cls, tree):
    """An object of parameter class ``cls`` from nested dicts and lists."""
    if not isinstance(tree, dict):
        raise ParameterError("", tree, "it must be a table")
    known = {field.name: field for field in dataclasses.fields(cls)}
    for key in tree:
        if key not in known:
            words = f"no such key exists here; the keys are {', '.join(known)}"
            raise ParameterError(key, tree[key], words + _did_you_mean(key, known))
    values = {}
    for name, field in known.items():
        rule = field.metadata["legal"]
        if name in tree:
            values[name] = _built_value(rule, tree[name], name)
        elif field.default is MISSING:
            raise ParameterError(name, None, f"it is required and must be {rule.words}")
    return cls(**values)


def _built_value(rule, value, name):
    if rule.kind not in ("part", "parts") or (rule.kind == "part" and isinstance(value, rule.part)):
        return value
    try:
        if rule.kind == "part":
            return _build(rule.part, value)
        if not isinstance(value, list):
            raise ParameterError("", value, f"it must be {rule.words}")
        return tuple(indexed(n, _build, rule.part, one) for n, one in enumerate(value))
    except ParameterError as error:
        raise error.under(name) from None


def _did_you_mean(word, known):
    near = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return f' (did you mean "{near[0]}"?)' if near else ""


def _sentence(source, error):
    if isinstance(error, PresetError):
        return error
    if error.value is None:
        message = f"{source}: {error.key} is missing; {error.legal}"
    else:
        message = f"{source}: {error}"
    return PresetError(message, error.key, error.value, error.legal)

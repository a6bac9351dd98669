"""Single values in a tree of dicts and lists, named by dotted keys: a tree and settings (or a second tree laid over it)
enter, the changed tree leaves."""

import difflib
import tomllib

from ..errors import ParameterError


def apply_setting(tree, cls, key, value):
    """Set the value that dotted ``key`` names inside ``tree``, which describes parameter class ``cls``.

    Parameters
    ----------
    tree : dict
        Changed in place.
    cls : type
        Parameter class of the root.
    key : str
        Such as ``strings.0.tension`` or ``body.damping_ratios.3``.
    value : str or object
        Text is read as TOML where the key does not want text itself.
    """
    node, names, done = tree, key.split("."), []
    while True:
        name = names.pop(0)
        rule = _rule(cls, name, ".".join([*done, name]), value)
        done.append(name)
        if not names:
            node[name] = _parsed(rule.kind, value)
            return
        if rule.kind == "part":
            node, cls = node.setdefault(name, {}), rule.part
        elif rule.kind in ("parts", "numbers"):
            index = _index(node.get(name, []), names.pop(0), ".".join(done), value)
            done.append(str(index))
            if not names:
                node[name][index] = _parsed("number" if rule.kind == "numbers" else "part", value)
                return
            if rule.kind == "numbers":
                raise ParameterError(key, value, f"{'.'.join(done)} is a single number and has no keys of its own")
            node, cls = node[name][index], rule.part
        else:
            raise ParameterError(key, value, f"{'.'.join(done)} is a single value and has no keys of its own")


def merge(below, above):
    """Lay tree ``above`` over tree ``below``: tables merge, a table with whole numbers as keys changes single entries
    of a list, everything else replaces.

    Raises
    ------
    ParameterError
        If an entry of a list is named that ``below`` does not have.
    """
    out = dict(below)
    for key, value in above.items():
        try:
            out[key] = _laid_over(out.get(key), value)
        except ParameterError as error:
            raise error.under(key) from None
    return out


def indexed(index, function, *arguments):
    """``function(*arguments)``, with ``index`` put before the key of any `ParameterError`."""
    try:
        return function(*arguments)
    except ParameterError as error:
        raise error.under(str(index)) from None


def _laid_over(below, above):
    if not isinstance(above, dict):
        return above
    if isinstance(below, dict):
        return merge(below, above)
    if not isinstance(below, list):
        return above
    out = list(below)
    for key, value in above.items():
        n = _index(out, key, "", value)
        out[n] = indexed(n, _laid_over, out[n], value)
    return out


def _index(entries, text, key, value):
    count = len(entries)
    if not (text.isascii() and text.isdigit() and int(text) < count):
        where = f"{key}.{text}" if key else text
        span = f"0 to {count - 1}" if count else "none: the list is empty"
        raise ParameterError(where, value, f"no such entry exists; the entries are {span}")
    return int(text)


def _rule(cls, name, key, value):
    known = cls.__dataclass_fields__
    if name not in known:
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
        hint = f' (did you mean "{near[0]}"?)' if near else ""
        raise ParameterError(key, value, f"no such key exists; the keys here are {', '.join(known)}{hint}")
    return known[name].metadata["legal"]


def _parsed(kind, value):
    """Text as the value it stands for; text that stands for none is kept, for the range check to refuse."""
    if not isinstance(value, str):
        return list(value) if isinstance(value, tuple) else value
    wants_text = kind in ("text", "choice")
    if wants_text and value[:1] not in ('"', "'"):
        return value
    try:
        return tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        pass
    if kind in ("number", "integer"):
        try:
            return float(value)  # also what TOML does not know, such as .5
        except ValueError:
            pass
    return value

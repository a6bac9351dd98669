"""A `Guitar`, or any other parameter object, as text: it enters checked, TOML that is read back to the same leaves,
each key with its unit, range and meaning beside it."""

import dataclasses
import json

COMMENT_COLUMN = 40


def dump_preset(guitar):
    """TOML text of ``guitar``; in lists of tables only the first entry is commented.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar
        Or another object whose class is made of `ukrt.model.fields`.

    Returns
    -------
    str
    """
    return "\n".join(_table(guitar, "", True)) + "\n"


def _table(item, prefix, comments):
    """Lines of one table: plain keys first, as TOML wants it, then the tables inside."""
    lines, inside = [], []
    for field in dataclasses.fields(item):
        rule, value = field.metadata["legal"], getattr(item, field.name)
        key = f"{prefix}.{field.name}" if prefix else field.name
        if rule.kind == "part":
            inside += ["", f"[{key}]", *_table(value, key, comments)]
        elif rule.kind == "parts":
            for n, one in enumerate(value):
                inside += ["", f"[[{key}]]", *_table(one, key, comments and n == 0)]
        else:
            line = f"{field.name} = {_value(value)}"
            lines.append(f"{line:<{COMMENT_COLUMN}}  # {_comment(rule)}" if comments else line)
    return lines + inside


def _comment(rule):
    unit = f" {rule.unit}" if rule.unit else ""
    match rule.kind:
        case "number" | "integer" | "numbers":
            return f"{rule.low:g} to {rule.high:g}{unit}: {rule.doc}"
        case "choice":
            return f"{rule.words}: {rule.doc}"
        case _:
            return rule.doc


def _value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return "[" + ", ".join(_value(v) for v in value) + "]"

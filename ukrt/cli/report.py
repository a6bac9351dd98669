"""Reports and other small files: a dict or bytes enter, a file leaves, whole or not at all."""

import json
import os
import pathlib

from .common import UsageError


def check_report_path(path, option="--report"):
    """Where a file that ``option`` names goes (Path), refused before anything is computed if it cannot be there."""
    path = pathlib.Path(path)
    if path.is_dir() or not path.absolute().parent.is_dir():
        raise UsageError(f"{option} {path}: is a folder or in none that exists, a file name is needed")
    return path


def write_report(path, report):
    """Write ``report`` as JSON."""
    write_whole(path, (json.dumps(report, indent=2) + "\n").encode(), "--report")


def write_whole(path, data, option):
    """Write bytes beside their place, then move them there; ``option`` names the file in messages."""
    path = pathlib.Path(path)
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(data)
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise UsageError(f"{option} {path}: cannot be written ({error.strerror}), a writable file is needed") from None

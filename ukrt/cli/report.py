"""Reports as files: a dict enters, a JSON file leaves, whole or not at all."""

import json
import os
import pathlib

from .common import UsageError


def check_report_path(path):
    """Where the report goes (Path), refused before anything is computed if it cannot be written there."""
    path = pathlib.Path(path)
    if path.is_dir() or not path.absolute().parent.is_dir():
        raise UsageError(f"--report {path}: is a folder or in none that exists, a file name is needed")
    return path


def write_report(path, report):
    """Write ``report`` as JSON beside its place, then move it there."""
    path = pathlib.Path(path)
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise UsageError(f"--report {path}: cannot be written ({error.strerror}), a writable file is needed") from None

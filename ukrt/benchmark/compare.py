"""Two reports of ``ukrt bench``: an older one's file and a new one enter, ratios leave."""

import json
import pathlib

from ..errors import UkrtError

MUST_AGREE = ("preset", "rate_hz", "block_frames", "response_s")


class ReportError(UkrtError):
    """A file is no report of ``ukrt bench``."""


def read_report(path):
    """A report from a file.

    Parameters
    ----------
    path : str or os.PathLike

    Returns
    -------
    dict

    Raises
    ------
    ReportError
        It cannot be read, or is something else.
    """
    try:
        report = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise ReportError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise ReportError(f"{path}: no JSON ({error}), a report of `ukrt bench --json` is needed") from None
    cases = report.get("cases") if isinstance(report, dict) else None
    if not isinstance(cases, list) or not all(_is_case(case) for case in cases):
        raise ReportError(f"{path}: has no list of cases with name and times_real_time, as `ukrt bench --json` writes")
    return report


def _is_case(case):
    if not isinstance(case, dict) or not isinstance(case.get("name"), str):
        return False
    speed = case.get("times_real_time")
    return isinstance(speed, int | float) and speed > 0


def compare_reports(old, new):
    """How much faster each case is now.

    Parameters
    ----------
    old, new : dict
        Reports.

    Returns
    -------
    rows : list of (str, float, float, float)
        Name, times real time before and now, and their ratio, of the cases that are in both.
    warnings : list of str
        What differs between the two beside the program.
    """
    before = {case["name"]: case["times_real_time"] for case in old["cases"]}
    rows = [
        (case["name"], before[case["name"]], case["times_real_time"], case["times_real_time"] / before[case["name"]])
        for case in new["cases"]
        if case["name"] in before
    ]
    differing = [
        f"{key} was {old.get(key)!r} and is {new.get(key)!r}" for key in MUST_AGREE if old.get(key) != new.get(key)
    ]
    processors = [report.get("machine", {}).get("processor") for report in (old, new)]
    if processors[0] != processors[1]:
        differing.append(f"the processor was {processors[0]} and is {processors[1]}")
    return rows, differing

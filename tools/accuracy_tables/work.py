"""Many notes and schemes compared, by several processes if asked: pairs enter, `Comparison`s leave in their order."""

import multiprocessing

from accuracy import compare
from rich.console import Console
from rich.progress import track


def _compare(pair):
    return compare(*pair)


def compare_all(pairs, jobs=1):
    """`accuracy.compare` of every (note, scheme), with a progress bar on stderr."""
    seen = {"console": Console(stderr=True), "total": len(pairs)}
    if jobs == 1:
        return [_compare(pair) for pair in track(pairs, "poles", **seen)]
    first = {scheme.solver: n for n, (_, scheme) in reversed(list(enumerate(pairs)))}
    for n in first.values():  # compiled code is made once, before the processes start
        _compare(pairs[n])
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        return list(track(pool.imap(_compare, pairs, chunksize=4), "poles", **seen))

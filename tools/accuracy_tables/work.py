"""Many notes and schemes compared, by several processes if asked: pairs enter, `Comparison`s leave in their order."""

import functools
import multiprocessing

from accuracy import compare
from rich.console import Console
from rich.progress import track


def _compare(pair, theory):
    return compare(*pair, theory=theory)


def compare_all(pairs, jobs=1, theory=False):
    """`accuracy.compare` of every (note, scheme), with a progress bar on stderr; theory : as there."""
    work = functools.partial(_compare, theory=theory)
    seen = {"console": Console(stderr=True), "total": len(pairs)}
    if jobs == 1:
        return [work(pair) for pair in track(pairs, "poles", **seen)]
    first = {scheme.solver: n for n, (_, scheme) in reversed(list(enumerate(pairs)))}
    for n in first.values():  # compiled code is made once, before the processes start
        work(pairs[n])
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        return list(track(pool.imap(work, pairs, chunksize=4), "poles", **seen))

"""``ukrt render`` with several files: each is rendered by itself, several at a time, each worker on a core of its own.

The strings of one piece cannot be parted, since they are coupled; pieces can. Where that is safe workers are forked
from this process, which has loaded, compiled and solved before what all of them need; elsewhere each starts anew.
"""

import contextlib
import copy
import multiprocessing
import multiprocessing.connection
import os
import pathlib
import signal
import sys
import threading

from ..errors import UkrtError
from .common import (
    UsageError,
    clock_time,
    load_guitar,
    make_console,
    make_engine,
    need_compiled,
    say,
    sound_of,
)

_PATIENCE = 5.0  # s that an interrupted worker has to remove what is half-written
_SHOW_EVERY = 0.5  # s of sound between two words from a worker


def choose_jobs(wanted, files):
    """How many workers (int): as asked for, or one for each core that we may use; never more than files."""
    return max(1, min(wanted or len(_cores()), files))


def can_fork():
    """Whether workers may be copies of this process (bool): Linux's libraries bear it, while no thread of ours runs."""
    return sys.platform == "linux" and threading.active_count() == 1


def check_folder(path):
    """The folder of ``-o`` for several files (Path), which may be missing itself."""
    path = pathlib.Path(path)
    if path.exists() and not path.is_dir():
        raise UsageError(f"-o {path}: is a file, several renders need a folder")
    if not path.absolute().parent.is_dir():
        raise UsageError(f"-o {path}: there is no folder {path.absolute().parent} to make it in")
    return path


def plan(args):
    """Arguments for each file (list of Namespace), with the file it is written to, refused where two would be one."""
    folder = check_folder(args.output) if args.output else None
    plans, sources = [], {}
    for midi in args.midi:
        one = copy.copy(args)
        one.midi, one.report = midi, None
        one.output = str(folder / f"{pathlib.Path(midi).stem}.wav") if folder else None
        target = pathlib.Path(one.output or sound_of(midi)).absolute()
        if target.exists() and not args.force:
            raise UsageError(f"{target} exists already; replace it with --force, or name another folder with -o")
        if target in sources:
            raise UsageError(f"{sources[target]} and {midi} would both become {target.name}; render them apart")
        sources[target] = midi
        plans.append(one)
    if folder:  # not before all are known to be possible
        folder.mkdir(exist_ok=True)
    return plans


def prepare(args):
    """Compile what is not yet; load and solve what workers that are forked all need."""
    guitar = load_guitar(args)
    if not can_fork():
        need_compiled(guitar)
        return
    from .. import render  # noqa: F401
    from ..drivers.takes import reader  # noqa: F401

    with contextlib.suppress(UkrtError):  # what is wrong is said of each file
        make_engine(guitar, args.rate or 48000, signal=args.signal or "pressure").close()


def render_many(plans, jobs, render_one):
    """Render all of them.

    Parameters
    ----------
    plans : list of Namespace
        Arguments for each file.
    jobs : int
        Workers.
    render_one : callable
        A function of a module, given arguments and a function for progress; returns a report.

    Returns
    -------
    list of dict or str
        Each file's report, or why there is none.
    """
    crew = _Crew(plans, jobs, render_one)
    with _Progress(plans) as progress:
        try:
            return crew.work(progress)
        finally:
            crew.end()


class _Crew:
    """Workers and what they are doing."""

    def __init__(self, plans, jobs, render_one):
        self._plans, self._waiting = plans, list(range(len(plans)))[::-1]
        self._results = [None] * len(plans)
        self._doing = {}  # connection -> number of the file
        forked, cores = can_fork(), _cores()
        context = multiprocessing.get_context("fork" if forked else "spawn")
        self._workers = {}
        for n in range(jobs):
            ours, theirs = context.Pipe()
            core = cores[n % len(cores)] if cores else None
            inherited = [*self._workers, ours] if forked else []
            process = context.Process(target=_work, args=(theirs, inherited, core, render_one), daemon=True)
            process.start()
            theirs.close()
            self._workers[ours] = process

    def work(self, progress):
        """Hand out files until all are done."""
        for connection in self._workers:
            self._hand_out(connection)
        while self._doing:
            for connection in multiprocessing.connection.wait(list(self._doing)):
                self._hear(connection, progress)
        return self._results

    def _hand_out(self, connection):
        if self._waiting:
            number = self._waiting.pop()
            self._doing[connection] = number
            connection.send(self._plans[number])

    def _hear(self, connection, progress):
        number = self._doing[connection]
        try:
            kind, what = connection.recv()
        except (EOFError, OSError):
            process = self._workers[connection]
            process.join(_PATIENCE)
            del self._doing[connection]
            self._results[number] = f"{self._plans[number].midi}: its process died (exit code {process.exitcode})"
            if not self._doing:  # nobody is left for those that wait
                for other in self._waiting:
                    self._results[other] = f"{self._plans[other].midi}: not rendered, all workers are gone"
                self._waiting.clear()
            return
        if kind == "at":
            progress.show(number, *what)
            return
        del self._doing[connection]
        self._results[number] = what
        progress.done(number)
        self._hand_out(connection)

    def end(self):
        """End whoever still works, after it has removed what is half-written."""
        for connection, process in self._workers.items():
            connection.close()
            if process.is_alive() and process.pid:
                os.kill(process.pid, signal.SIGINT)
        for process in self._workers.values():
            process.join(_PATIENCE)
            if process.is_alive():
                process.terminate()


def _work(connection, inherited, core, render_one):
    """A worker: takes arguments, gives back progress and a report or a sentence, until nobody listens.

    ``inherited`` are the other process's ends: as long as a copy of one is open, nobody would be seen to have gone.
    """
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.default_int_handler)
        for other in inherited:
            other.close()
        if core is not None:
            os.sched_setaffinity(0, {core})
        while True:
            args = connection.recv()
            try:
                answer = render_one(args, _Teller(connection))
            except UkrtError as error:
                answer = " ".join(str(error).split())
            connection.send(("done", answer))
    except (EOFError, OSError, KeyboardInterrupt):
        os._exit(0)  # whoever waited has gone; files have been closed on the way here


class _Teller:
    """A worker's progress, told now and then."""

    def __init__(self, connection):
        self._connection, self._last = connection, -1.0

    def __call__(self, done_s, total_s):
        if done_s - self._last >= _SHOW_EVERY or done_s >= total_s:
            self._last = done_s
            self._connection.send(("at", (done_s, total_s)))


class _Progress:
    """One bar for all files on a terminal; elsewhere nothing."""

    def __init__(self, plans):
        self._count, self._at = len(plans), {}
        self._done, self._bar = 0, None

    def __enter__(self):
        if sys.stderr.isatty():
            from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

            columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
            self._bar = Progress(*columns, console=make_console(), transient=True)
            self._task = self._bar.add_task("preparing", total=self._count)
            self._bar.start()
        return self

    def __exit__(self, *_):
        if self._bar:
            self._bar.stop()

    def show(self, number, done_s, total_s):
        """File ``number`` has come so far."""
        self._at[number] = (done_s, total_s)
        if self._bar:
            share = sum(done / total if total else 1.0 for done, total in self._at.values())
            words = f"{self._done} of {self._count} files, {clock_time(sum(done for done, _ in self._at.values()))}"
            self._bar.update(self._task, completed=share, description=words)

    def done(self, number):
        """File ``number`` is finished, well or not."""
        self._done += 1
        _, total = self._at.get(number, (0.0, 0.0))
        self.show(number, total, total)


def _cores():
    """The cores that this process may use (list of int), empty where the system does not say."""
    return sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []


def tell(plans, results, describe):
    """Say what came of each file; returns the exit code."""
    failed = 0
    for one, result in zip(plans, results, strict=True):
        if isinstance(result, str):
            failed += 1
            say(result)
        else:
            describe(one, result)
    if failed:
        say(f"{failed} of {len(plans)} files could not be rendered")
    return 2 if failed else 0

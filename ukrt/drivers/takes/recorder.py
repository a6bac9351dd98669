"""Keeps what is being played: the engine's journal and samples enter, a take and WAV files on the disk leave.

A thread of its own looks twenty times a second; what is on the disk is whole at every instant (see
`ukrt.drivers.takes.growing`) and at most one such look behind the engine. It is the one reader of the journal, also
where nothing is recorded: others follow through it. A file that cannot be written any more is given up in a sentence,
and everything else goes on: the take alone still holds the sound.
"""

import collections
import pathlib
import threading

import numpy as np

from ukrt.drivers.takes.growing import GrowingTake
from ukrt.drivers.takes.take import sound_of
from ukrt.drivers.takes.wav_series import WavSeries
from ukrt.engine.stage_layout import KIND_SHIFT, KIND_SWAP, VALUE_MASK
from ukrt.errors import AudioFileError, MidiFileError

POLL_SECONDS = 0.05  # choice: a fifth of the quarter of a second that a killed recording may lose


class Recorder:
    """Records an engine and tells others what has acted on it.

    Parameters
    ----------
    engine : Engine
        Before its first frame, if a take or its sound is to be recorded.
    take : path-like, optional
        A new file, ``.mid``.
    audio : path-like, optional
        A new file, ``.wav``; see `WavSeries` for what does not fit into it.

    Raises
    ------
    MidiFileError, AudioFileError
        A file that exists already or cannot be written.

    Attributes
    ----------
    failure : Exception or None
        What ended the thread, if anything did.
    """

    def __init__(self, engine, take=None, audio=None):
        self.failure = None
        self._engine = engine
        self._followers, self._sounds = [], {}
        self._news, self._coming = collections.deque(), collections.deque()  # their operations are atomic
        self._entry = self._lost_entries = 0
        self._take = self._wav = None
        self._kept = {"take_frames": 0, "sound_frames": 0, "lost_frames": 0, "files": []}
        if take is not None:
            self._take = _create(take, (".mid", ".midi"), MidiFileError, engine, _new_take)
        if audio is not None:
            try:
                self._wav = _create(audio, (".wav",), AudioFileError, engine, self._new_wav)
            except AudioFileError:
                if self._take is not None:
                    self._take.close()
                    self._take.path.unlink()
                raise
        self._closed = False
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ukrt-recorder", daemon=True)

    def _new_wav(self, engine, path):
        return WavSeries(path, engine.sample_rate, engine.channels, self._news.append)

    def start(self):
        """Start the thread."""
        self._thread.start()

    def close(self):
        """Take over all there is and finish the files: when the engine has stopped, before it is closed."""
        if self._closed:
            return
        self._closed = True
        self._stop.set()
        if self._thread.ident is not None:
            self._thread.join()
        if self.failure is None:
            self.drain()
        self._keep_counts()
        self._let_go("_take")
        self._let_go("_wav")

    def follow(self, callback):
        """Call ``callback(entries)``, in the recorder's thread, with all new entries of the journal: an int64 array
        (n, 2) of frames and words."""
        self._followers.append(callback)

    def announce(self, instance):
        """Tell which instance the next swap brings, between `Engine.load` and `Engine.swap`.

        Without it, the one that is heard when the swap is noticed is taken.
        """
        self._coming.append(sound_of(instance))

    def news(self):
        """Sentences since the last call (list of str)."""
        return [self._news.popleft() for _ in range(len(self._news))]

    def counts(self):
        """What was recorded (dict): ``entries`` of the journal and ``lost_entries``; ``take_frames``, ``sound_frames``
        and of those ``lost_frames``; ``files``."""
        self._keep_counts()
        return {"entries": self._entry, "lost_entries": self._lost_entries} | self._kept

    def _keep_counts(self):
        take, wav = self._take, self._wav
        if take is not None:
            self._kept["take_frames"] = take.frames
        if wav is not None:
            self._kept |= {"sound_frames": wav.frames, "lost_frames": wav.lost_frames}
        paths = ([take.path] if take else []) + (wav.paths if wav else [])
        self._kept["files"] += [str(path) for path in paths if str(path) not in self._kept["files"]]

    def _run(self):
        while not self._stop.wait(POLL_SECONDS):
            try:
                self.drain()
            except Exception as error:  # a fault of the program must not end in silence: the session tells it
                self.failure = error
                self._news.append(f"the recorder has failed, nothing more is recorded: {error!r}")
                return

    def drain(self):
        """Take over what is new up to the frame that the engine has reached."""
        with self._lock:
            frame = self._engine.frame  # first: every entry of the frames before it is in the journal now
            entries, lost = self._new_entries(frame)
            if self._take is not None:
                self._guard("_take", lambda: self._take.append(entries.tolist(), frame, self._sounds.get, lost))
            if self._wav is not None:
                self._guard("_wav", lambda: self._extend_wav(frame))
        if len(entries):
            self._tell_followers(entries)

    def _tell_followers(self, entries):
        for follower in list(self._followers):
            try:
                follower(entries)
            except Exception as error:  # its fault, not ours: what is played must be kept whatever others do
                self._followers.remove(follower)
                self._news.append(f"{follower!r} failed and hears no more of what acts: {error!r}")

    def _new_entries(self, frame):
        """The journal's entries before ``frame``, and how many were lost; those of later frames wait."""
        after, entries, lost = self._engine.journal(self._entry)
        due = int(np.searchsorted(entries[:, 0], frame))
        self._entry = after - (len(entries) - due)
        entries = entries[:due]
        if lost:
            self._lost_entries += lost
            self._news.append(f"{lost} entries of the journal were lost, so the take is not exact from here on")
        for at, word in entries[entries[:, 1] >> KIND_SHIFT == KIND_SWAP].tolist():
            sound = self._coming.popleft() if self._coming else sound_of(self._engine.instance)
            self._sounds[word & VALUE_MASK] = sound
            if self._wav is not None:
                self._wav.change_rate(at, sound.sample_rate)
        return entries, lost

    def _extend_wav(self, frame):
        after, samples, _ = self._engine.recorded(self._wav.frames)
        self._wav.extend(after - len(samples), samples, min(after, frame))

    def _guard(self, name, function):
        """Call ``function``; where the disk fails, give up the file it writes, and say so."""
        try:
            function()
        except OSError as error:
            path = getattr(self, name).path
            self._news.append(
                f"{path}: recording has stopped there ({error.strerror or error}); what it holds is whole"
            )
            self._keep_counts()
            self._let_go(name)

    def _let_go(self, name):
        """Close a file that may be there."""
        file = getattr(self, name)
        setattr(self, name, None)
        if file is not None:
            try:
                file.close()
            except OSError as error:
                self._news.append(f"{file.path}: may not be on the disk yet ({error.strerror or error})")


def _new_take(engine, path):
    return GrowingTake(path, sound_of(engine.instance), engine.signal, engine.channels, engine.settings())


def _create(path, suffixes, kind, engine, make):
    """What ``make(engine, path)`` opens, or a sentence that says why it cannot."""
    path = pathlib.Path(path)
    if path.suffix.lower() not in suffixes:
        raise kind(f"{path}: its suffix is {path.suffix!r}, legal are {' and '.join(suffixes)}")
    if engine.frame:
        raise kind(f"{path}: a recording begins with the engine's first frame, but it is at frame {engine.frame}")
    try:
        return make(engine, path)
    except FileExistsError:
        raise kind(f"{path}: exists already and is not written over, a new file name is needed") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        reason = getattr(error, "strerror", None) or error
        raise kind(f"{path}: cannot be written ({reason}), a writable folder is needed") from None

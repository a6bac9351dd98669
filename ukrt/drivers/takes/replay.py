"""Plays takes again: a `Take` enters, blocks of exactly the samples that a sound card was given leave.

Every entry of the take's journal acts on a new engine at the frame at which it acted when it was played, in the same
order; between these frames the engine computes as always, and its samples do not depend on the block size. So the bits
are those that were heard, as long as the kernels, the libraries and the processor are the same; where they are not, a
sentence says so.
"""

import pathlib
import time

import numpy as np

from ukrt.drivers.takes.take import environment, file_hash
from ukrt.engine.player_layout import LOG_CAPACITY
from ukrt.engine.stage_layout import CLASS_OTHER, KIND_MIDI, KIND_RESET, KIND_SHIFT, KIND_SWAP, ROOM, VALUE_MASK
from ukrt.errors import ImpulseResponseError, MidiFileError
from ukrt.radiation.impulse_response import impulse_response_names, load_impulse_response

RESET_TORN = KIND_RESET << KIND_SHIFT  # no frames muted: a host had died within the callback
PORTION = ROOM[CLASS_OTHER]  # messages sent before the engine runs again: the most that a lane never refuses
HARVEST = LOG_CAPACITY - PORTION  # notes after which the log is looked at: none is overwritten unseen
PROGRESS_FRAMES = 1 << 15


class Replay:
    """One take played on an engine of its own.

    Parameters
    ----------
    take : Take
    block_size : int
        Frames computed at once.
    progress : callable (done_s, total_s), optional
    engine_factory : callable (guitar, sample_rate, signal=..., impulse_response=...) -> Engine, optional

    Attributes
    ----------
    engine : Engine
    notes : list of dict
        The engine's log of notes, complete.
    warnings : list of str
        Why the sound may not be the one that was heard.
    compute_seconds, timed_seconds : float [s]
        Time that the engine took (its first block excepted), and the sound of that time.
    """

    def __init__(self, take, block_size=512, progress=None, engine_factory=None):
        self.take, self.block_size = take, block_size
        self.notes, self.warnings = [], list(take.warnings) + differences(take)
        self.compute_seconds = self.timed_seconds = 0.0
        self._progress = progress or (lambda done_s, total_s: None)
        self._next, self._notes_seen, self._seconds = 0, 0, 0.0
        self._total_seconds = sum((end - first) / rate for first, end, rate in take.parts())
        sound = take.sounds[0]
        self.engine = (engine_factory or _engine)(
            sound.guitar, sound.sample_rate, signal=take.signal, impulse_response=self._response(sound)
        )
        try:
            self._prepare()
        except BaseException:
            self.engine.close()
            raise

    def _prepare(self):
        """The engine as it was when the take began, and nothing that acts of itself."""
        try:
            self.engine.apply(self.take.settings)
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise MidiFileError(
                f"{self.take.path}: the take's settings are not the engine's ({error!r} is missing or of no use)"
            ) from None
        self.engine.message_cap = 0
        self.engine.shed_budget = 0.0
        if self.engine.channels != self.take.channels:
            raise MidiFileError(
                f"{self.take.path}: the take has {self.take.channels} channels, its guitar {self.engine.channels}"
            )

    def blocks(self, first, end):
        """Yield the frames from ``first``, the next to be computed, to ``end``: float32 (n <= block_size, channels)."""
        engine, shown = self.engine, first
        while engine.frame < end:
            stop = self._send(min(engine.frame + self.block_size, end))
            if engine.frame - shown >= PROGRESS_FRAMES:
                shown = engine.frame
                self._progress(self._seconds, self._total_seconds)
            begin, rate, began = engine.frame, engine.sample_rate, time.perf_counter()
            block = engine.process_card(stop - begin)
            if begin > 0:
                self.compute_seconds += time.perf_counter() - began
                self.timed_seconds += (stop - begin) / rate
            self._seconds += (stop - begin) / rate
            if self.engine.notes_logged - self._notes_seen >= HARVEST:
                self._harvest()
            yield block
        self._harvest()
        self._progress(self._seconds, self._total_seconds)

    def _send(self, stop):
        """Send what acts before ``stop``; returns ``stop`` or an earlier frame, before what cannot be sent yet."""
        first, now, all_frames = self._next, self.engine.frame, self.take.event_frames
        due = int(np.searchsorted(all_frames, stop))
        if due - first > PORTION:
            due = int(np.searchsorted(all_frames, all_frames[first + PORTION]))
            if due <= first:
                where = f"{self.take.path}: has more than {PORTION} messages at frame {all_frames[first]}"
                raise MidiFileError(f"{where}, the most that can be replayed")
        words = self.take.event_words[first:due]
        torn = words == RESET_TORN
        for k in (first + np.flatnonzero(torn | (words >> KIND_SHIFT == KIND_SWAP))).tolist():
            if all_frames[k] > now:  # prepared when all before it is computed; a reset begins a block, as it did
                due = int(np.searchsorted(all_frames, all_frames[k]))
                break
        for k in range(first, due):
            self._replay(int(all_frames[k]), int(self.take.event_words[k]))
        self._next = due
        return min(stop, int(all_frames[due])) if due < len(all_frames) else stop

    def _replay(self, frame, word):
        kind, value = word >> KIND_SHIFT, word & VALUE_MASK
        if kind == KIND_SWAP:
            self._swap(frame, value)
            return
        if kind == KIND_MIDI:
            sent = self.engine.send(frame, value >> 16, value >> 8 & 0xFF, value & 0xFF)
        elif word == RESET_TORN:
            sent = self.engine.recover(torn=True)
        else:
            sent = self.engine.send_event(frame, kind, value)
        if not sent:
            raise RuntimeError("the engine's lane is full though it had been emptied")

    def _swap(self, frame, number):
        """Let the guitar of swap ``number`` take over at ``frame``, the next to be computed."""
        from ukrt.engine.instance import Instance

        sound = self.take.sounds[number]
        instance = Instance(sound.guitar, sound.sample_rate, self.take.signal, self._response(sound))
        self.engine.load(instance, sound.gain)
        self.engine.swap(frame)

    def _harvest(self):
        """Take over the log of notes before its ring comes round; rows known already are renewed."""
        rows = self.engine.note_log()
        self._notes_seen = self.engine.notes_logged
        self.notes[self._notes_seen - len(rows) :] = rows

    def _response(self, sound):
        """The impulse response through which ``sound`` was heard; None where none was."""
        if self.take.signal != "pressure" or sound.response is None:
            return None
        name, sha256 = sound.response["name"], sound.response["sha256"]
        for place in (name, sound.response["file"], self.take.path.parent / pathlib.Path(name).name):
            try:
                response = load_impulse_response(place, sound.sample_rate)
                if file_hash(response.source) == sha256:
                    return response
            except (ImpulseResponseError, OSError, ValueError):
                continue
        if name in impulse_response_names():
            self.warnings.append(f"the impulse response {name} is another one now, so the sound is not what was heard")
            return load_impulse_response(name, sound.sample_rate)
        raise ImpulseResponseError(
            f"{self.take.path}: was played through the impulse response {name}, but no file with that content (SHA-256 "
            f"{sha256[:12]}...) is there any more; it is needed at its old place or beside the take"
        )


def differences(take):
    """A sentence that names what the bits depend on and is another here than where the take was played; a list of none
    or one."""
    here = environment()
    other = [f"{name} {take.environment.get(name)} (here {value})" for name, value in here.items()
             if take.environment.get(name) != value]  # fmt: skip
    if not other:
        return []
    return [f"the take was played with {', '.join(other)}, so its samples may differ in their last bits"]


def _engine(guitar, sample_rate, signal, impulse_response):
    from ukrt.engine.engine import Engine  # the compiler is loaded only when the take is right

    return Engine(guitar, sample_rate, signal=signal, impulse_response=impulse_response)

"""Another guitar, or another sample rate, while playing: a guitar enters, an instance takes over between two blocks.

Preparing an instance takes up to a second and happens in a thread of its own; the callback plays on. What fails leaves
the guitar that is playing as it is, and says so in a sentence.
"""

import queue
import threading
import time

from ukrt.engine.instance import Instance
from ukrt.errors import DeviceError, UkrtError

_POLL_SECONDS = 0.01
_SWAP_SECONDS = 5.0  # for the last change to end: 43 ms of crossfade where somebody asks for sound


def make_instance(engine, guitar, sample_rate):
    """An instance of ``guitar`` that ``engine`` can load (Instance)."""
    return Instance(guitar, sample_rate, engine.signal, shared=engine.shared)


class GuitarChanger:
    """Lets other instances take over on an engine, one after another.

    Parameters
    ----------
    engine : Engine
    refresh : callable ()
        Makes whoever hosts the callback take over the engine's slots; raises `UkrtError` where that fails.
    say : callable (str)
        Takes sentences about what happened.
    announce : callable (Instance)
        Told what takes over, right before it is armed.
    prepare : callable (engine, guitar, sample_rate) -> Instance, optional

    Attributes
    ----------
    lock : threading.RLock
        Held while the free slot is in use; hosts of the callback change only under it.
    """

    def __init__(self, engine, refresh, say, announce, prepare=make_instance):
        self.lock = threading.RLock()
        self.changes = 0
        self._engine, self._refresh, self._say = engine, refresh, say
        self._announce, self._prepare = announce, prepare
        self._wanted = queue.SimpleQueue()
        self._thread = None

    def want(self, guitar):
        """Change to ``guitar``, a `Guitar` or a callable that gives one, as soon as it is prepared; returns at once."""
        self._wanted.put(guitar)
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="ukrt-guitars", daemon=True)
            self._thread.start()

    def close(self, seconds=5.0):
        """End the thread; True when it has ended."""
        if self._thread is None:
            return True
        self._wanted.put(None)
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def put_in(self, guitar, sample_rate):
        """Prepare an instance and arm it to take over at the next block; with the lock held, and somebody asking for
        blocks unless none has been asked for yet.

        Raises
        ------
        UkrtError
            It cannot be built or nobody takes it over; nothing has changed then.
        """
        instance = self._prepare(self._engine, guitar, sample_rate)
        ends = time.monotonic() + _SWAP_SECONDS
        while self._engine.swapping:
            _wait_until(ends, instance)
        self._arm(instance)

    def _take_over(self, guitar):
        """As `put_in` at the engine's rate, taking the lock only for the moment of arming."""
        engine, instance = self._engine, None
        ends = time.monotonic() + _SWAP_SECONDS
        while True:
            if instance is not None and instance.sample_rate != engine.sample_rate:
                instance.close()
                instance = None
            if instance is None:
                instance = self._prepare(engine, guitar, engine.sample_rate)
            with self.lock:
                if not engine.swapping and instance.sample_rate == engine.sample_rate:
                    self._arm(instance)
                    return
            _wait_until(ends, instance)

    def _arm(self, instance):
        """Let ``instance`` take over at the next block, at the loudness that the one before was turned to."""
        engine = self._engine
        turned = engine.output_gain / engine.instance.preset_gain  # by whoever wants it louder than the preset says
        try:
            engine.load(instance, turned * instance.preset_gain)
        except UkrtError:
            instance.close()
            raise
        self._refresh()
        self.changes += 1
        self._announce(instance)
        engine.swap()

    def _run(self):
        while (wanted := self._newest()) is not None:
            try:
                guitar = wanted() if callable(wanted) else wanted
                self._take_over(guitar)
            except UkrtError as error:
                self._say(f"the guitar stays as it is: {error}")
            except Exception as error:  # a fault of ours must not end this thread, nor the music
                self._say(f"the guitar stays as it is, after {type(error).__name__}: {error}")
            else:
                self._say(f"the guitar is now {guitar.name}")

    def _newest(self):
        """The last of all that is wanted; waits for the first. Only the newest counts where several were asked for."""
        wanted = self._wanted.get()
        while wanted is not None and not self._wanted.empty():
            wanted = self._wanted.get()
        return wanted


def _wait_until(ends, instance):
    """A moment's rest on the way to ``ends``; beyond it the instance is given up."""
    if time.monotonic() > ends:
        instance.close()
        raise DeviceError("the last change has not been carried out, since nobody asks for sound")
    time.sleep(_POLL_SECONDS)

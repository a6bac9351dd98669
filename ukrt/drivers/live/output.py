"""Sound that goes on: a way to open an output enters; whatever happens to it, somebody keeps asking for blocks.

While the output is away the null output takes its place, in silence, so that notes, pieces and recordings go on; the
output is opened anew with growing pauses. All that can take time happens in a thread of its own.
"""

import threading
import time

from ukrt.drivers.live.watch import StallWatch
from ukrt.drivers.sound.null import NullOutput
from ukrt.errors import UkrtError

_FIRST_PAUSE, _LONGEST_PAUSE = 0.25, 5.0  # s, doubled after every attempt
_STEADY_SECONDS = 2.0  # an output that lasted this long has earned a short first pause again
_LEAVE_SECONDS = 3.0  # for an attempt that is under way when everything ends


class OutputKeeper:
    """Keeps an output running on an engine.

    Parameters
    ----------
    engine : Engine
    open_output : callable () -> output
        Opens the output, which is not started yet; raises `UkrtError` where it cannot.
    changer : GuitarChanger
        Lets an instance at another sample rate take over where the output comes back with one.
    say : callable (str)

    Attributes
    ----------
    output : object
        Who asks the engine for blocks now.
    away : bool
        Whether that is the stand-in.
    reconnections : int
    """

    def __init__(self, engine, open_output, changer, say):
        self.output, self.away, self.reconnections = None, False, 0
        self.generation = 0  # one more with every output: what was measured on the last one no longer holds
        self._engine, self._open, self._changer, self._say = engine, open_output, changer, say
        self._watch = StallWatch()
        self._past_xruns = 0
        self._pause = _FIRST_PAUSE
        self._opened_at = 0.0
        self._worker = None
        self._ending = threading.Event()

    def open(self):
        """Open the output and let it ask for sound; raises `UkrtError` where that is not possible."""
        self._adopt(self._open())

    def tend(self):
        """Look whether the output still asks for sound; if not, let it be replaced."""
        now = time.monotonic()
        if self._worker is not None:
            if self._worker.is_alive():
                return
            self._worker = None
            self._watch.restart(now)
        if (reason := self._trouble(now)) is None:
            return
        if now - self._opened_at > _STEADY_SECONDS:
            self._pause = _FIRST_PAUSE
        self._worker = threading.Thread(target=self._replace, args=(reason,), name="ukrt-reconnect", daemon=True)
        self._worker.start()

    def _trouble(self, now):
        """What is wrong with the output, in the first half of a sentence; None if nothing is."""
        output = self.output
        if output is None:
            return "there is no output"
        if not output.running:
            return getattr(output, "reason", None) or f"{output.name} has ended"
        if isinstance(output, NullOutput):  # our own clock: on a machine at a standstill it is late, never dead
            return None
        if self._watch.look(self._engine.frame, now, output.block_size / output.sample_rate):
            return f"{output.name} has asked for no sound for {self._watch.still:.1f} s"
        return None

    def close(self):
        """End the sound; False if somebody had to be forced."""
        self._ending.set()
        if self._worker is not None:
            self._worker.join(_LEAVE_SECONDS)
        with self._changer.lock:
            last = self.output
            clean = self._retire() if last is not None else True
            self.output = last  # for its name and numbers
        return clean

    def xruns(self):
        """Gaps in the sound that outputs have told of (int)."""
        counting = self.output is not None and not self.away and not self._ending.is_set()
        return self._past_xruns + (self.output.xruns() if counting else 0)

    def refresh(self):
        """Let whoever asks for blocks take over what the engine has loaded; one that is dead does not matter."""
        if self.output is not None:
            try:
                self.output.refresh()
            except UkrtError:
                if self.output.running:
                    raise

    def _retire(self):
        """Close the present output; says so where that tore the engine's state. True if it went by itself."""
        output, self.output = self.output, None
        self._past_xruns += 0 if self.away else output.xruns()
        clean = output.close()
        if self._engine.recover():
            self._say(f"{output.name} died in the middle of a block: all strings were brought to rest")
        return clean

    def _adopt(self, output, *, away=False):
        """Let ``output`` ask for sound from now on, instead of the one that did so far."""
        engine = self._engine
        try:
            with self._changer.lock:
                if self._ending.is_set():
                    output.close()
                    return
                if not away and output.sample_rate != engine.sample_rate:
                    self._changer.put_in(engine.guitar, output.sample_rate)
                output.refresh()  # what was loaded since it was opened
                if self.output is not None:
                    self._retire()
                output.start()
                self.output, self.away = output, away
                self.generation += 1
                self._opened_at = time.monotonic()
                self._watch.restart(self._opened_at)
        except BaseException:
            output.close()
            raise

    def _stand_in(self):
        """Let the null output take over, whoever is or was there."""
        with self._changer.lock:
            if not self._ending.is_set() and (self.output is None or not self.away):
                self._adopt(NullOutput(self._engine, silent=True), away=True)

    def _replace(self, reason):
        """Silence at once, then the output again, however often that has to be tried."""
        said = set()
        try:
            self._stand_in()
            self._say(f"{reason}; the guitar plays on unheard until it is back")
            while not self._ending.wait(self._pause):
                self._pause = min(2.0 * self._pause, _LONGEST_PAUSE)
                if self._try_again(said):
                    return
        except Exception as error:  # a fault of ours is told; `tend` begins anew
            self._say(f"reconnecting has failed with {type(error).__name__}: {error}")

    def _try_again(self, said):
        """One attempt; True where it succeeded."""
        try:
            rate = self._engine.sample_rate
            self._adopt(output := self._open())
        except UkrtError as error:
            self._stand_in()
            if str(error) not in said:  # once each, not every five seconds
                said.add(str(error))
                self._say(f"still no sound: {error}")
            return False
        if not self._ending.is_set():
            news = f", now at {output.sample_rate:.0f} Hz" if output.sample_rate != rate else ""
            self._say(f"{output.name} is back{news}")
            self.reconnections += 1
        return True

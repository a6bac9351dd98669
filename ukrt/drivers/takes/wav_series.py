"""The sound of a recording: samples by their frame enter, one WAV file leaves, and more where one cannot hold it all.

Another file, ``NAME-2.wav``, begins where the sample rate changes and where a file is full (4 GB). Frames that were
lost become silence, so that every frame stands at its place.
"""

from ukrt.drivers.takes.growing import GrowingWav

PIECE = 4096  # frames written at once: a disk that runs full loses at most as many that would have fitted (choice)


class WavSeries:
    """WAV files that hold the frames of a recording, one after another.

    Parameters
    ----------
    path : pathlib.Path
        Of the first, a new file.
    sample_rate : float [Hz]
    channels : int
    tell : callable (str)
        Takes sentences about what happened.

    Attributes
    ----------
    frames : int
        Written so far, in all files.
    lost_frames : int
        How many of them are silence because they were lost.
    paths : list of pathlib.Path
    """

    def __init__(self, path, sample_rate, channels, tell):
        self._file, self._channels, self._tell = GrowingWav(path, sample_rate, channels), channels, tell
        self._first, self.paths = path, [path]
        self._rate, self._changes = sample_rate, []
        self.frames = self.lost_frames = 0

    @property
    def path(self):
        """The file that grows now."""
        return self.paths[-1]

    def change_rate(self, frame, sample_rate):
        """The frames from ``frame`` on are of another sample rate (or of the same one)."""
        if sample_rate != (self._changes[-1][1] if self._changes else self._rate):
            self._changes.append((frame, sample_rate))

    def extend(self, begin, samples, until):
        """Append the frames up to ``until``.

        Parameters
        ----------
        begin : int
            The frame of the first of ``samples``; those before it that are missing were lost.
        samples : ndarray (n, channels) float32
        until : int
            At most ``begin + n``.
        """
        lost = self.lost_frames
        while self.frames < until:
            if self._changes and self._changes[0][0] <= self.frames:
                self._rate = self._changes.pop(0)[1]
                self._go_on(f"the sample rate is {self._rate:g} Hz now")
            elif not self._file.room:
                self._go_on("a WAV file ends at 4 GB")
            stop = min([until, self.frames + min(self._file.room, PIECE)] + [frame for frame, _ in self._changes[:1]])
            if self.frames < begin:
                stop = min(stop, begin)
                self._file.append_silence(stop - self.frames)
                self.lost_frames += stop - self.frames
            else:
                self._file.append(samples[self.frames - begin : stop - begin])
            self.frames = stop
        if self.lost_frames > lost:
            self._tell(f"{self.lost_frames - lost} frames of sound were lost, {self.path} has silence in their place")

    def _go_on(self, why):
        """Begin the next file."""
        number = len(self.paths) + 1
        while (path := self._first.with_stem(f"{self._first.stem}-{number}")).exists():
            number += 1
        following = GrowingWav(path, self._rate, self._channels)
        before, self._file = self._file, following
        self.paths.append(path)
        self._tell(f"the sound goes on in {path}: {why}")
        before.close()

    def close(self):
        """Finish the file that grows."""
        self._file.close()

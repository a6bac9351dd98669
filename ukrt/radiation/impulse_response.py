"""Impulse responses, bridge force to sound pressure: a file enters, taps at the engine's rate leave (Eq. 51).

A WAV or FLAC file holds p[k] for a force of 1 N during one sample at the file's rate (p[k] = sum h[j] F[k-j], in Pa
per N): a sample of 1.0 is 1 Pa/N, in integer formats full scale is. One channel: both ends of the bridge to both
outputs; two: left and right, the same from both ends; four: bass end to left, bass to right, treble to left, treble to
right. Between the ends of the bridge responses are interpolated linearly.
"""

import dataclasses
import os
import pathlib

import numpy as np
import soundfile
import soxr

from ukrt.errors import ImpulseResponseError

LONGEST = 2.0  # s
RATES = (8000, 384_000)  # Hz, of files and of the engine
_DATA = pathlib.Path(__file__).parent / "data"
_RINGING = 512  # samples that the resampling filter may ring on after the last tap


@dataclasses.dataclass(frozen=True)
class ImpulseResponse:
    """Responses of the sound pressure to the force at the two ends of the bridge.

    Attributes
    ----------
    samples : ndarray (n, 2, 2) [Pa/N per sample]
        Taps of: input (bass end, treble end), output (left, right); p[k] = sum h[j] F[k-j].
    sample_rate : float [Hz]
    name : str
        What was asked for.
    source : str
        The file it came from.
    """

    samples: np.ndarray
    sample_rate: float
    name: str
    source: str


def impulse_response_names():
    """Names of the responses that come with the package, sorted."""
    return sorted(path.stem for path in _DATA.glob("*.wav"))


def load_impulse_response(path_or_name, sample_rate):
    """Read a response and bring it to the engine's rate, keeping its transfer function.

    Parameters
    ----------
    path_or_name : str or os.PathLike
        A name out of `impulse_response_names`, or the path of a WAV or FLAC file.
    sample_rate : float [Hz]
        The engine's; responses are resampled between whole numbers of hertz.

    Returns
    -------
    ImpulseResponse
    """
    name = os.fspath(path_or_name)
    if not RATES[0] <= sample_rate <= RATES[1]:  # NaN fails here, too
        raise ImpulseResponseError(
            f"the impulse response {name} cannot be used at {sample_rate} Hz: legal are {RATES[0]} to {RATES[1]}"
        )
    path = _locate(name)
    data, rate = _read(path)
    samples = resample_response(_by_ends(data), rate, round(sample_rate))
    return ImpulseResponse(samples, float(sample_rate), name, str(path))


def resample_response(samples, from_rate, to_rate):
    """Taps at another rate, scaled so that the transfer function stays the same.

    The resampling filter is symmetric in time and rings a little before a response that starts abruptly. What falls
    before time zero is folded back behind it: that keeps the response causal, adds no delay and leaves the real part of
    the transfer function as it was.

    Parameters
    ----------
    samples : ndarray (n, 2, 2) [Pa/N per sample]
    from_rate, to_rate : int [Hz]
    """
    if from_rate == to_rate:
        return samples
    before = np.zeros((from_rate, 4))  # one second, which is a whole number of samples at both rates
    padded = np.concatenate([before, samples.reshape(-1, 4), np.zeros((from_rate // 2, 4))])
    made = soxr.resample(padded, from_rate, to_rate, quality="VHQ") * (from_rate / to_rate)
    length = -(-len(samples) * to_rate // from_rate) + _RINGING
    result = made[to_rate : to_rate + length].copy()
    folded = made[to_rate - 1 :: -1][: length - 1]
    result[1 : 1 + len(folded)] += folded
    return result.reshape(-1, 2, 2)


def _locate(name):
    path = pathlib.Path(name).expanduser()
    if path.name == name and not path.suffix:
        shipped = _DATA / f"{name}.wav"
        if shipped.is_file():
            return shipped
        known = ", ".join(impulse_response_names())
        raise ImpulseResponseError(
            f'no impulse response is called "{name}": there are {known}, or give the path of a WAV or FLAC file'
        )
    if not path.is_file():
        found = "it is a folder" if path.is_dir() else "there is no such file"
        raise ImpulseResponseError(f"the impulse response {name} cannot be read: {found}")
    return path


def _read(path):
    """Samples (n, channels) and rate [Hz] of a file, everything about it checked."""
    try:
        info = soundfile.info(path)
        _check_format(path, info.channels, info.samplerate, info.frames)
        data, rate = soundfile.read(path, dtype="float64", always_2d=True)
    except (soundfile.SoundFileError, RuntimeError, OSError, TypeError) as error:
        message = f"the impulse response {path} is not an audio file that can be read: {error}"
        raise ImpulseResponseError(" ".join(message.split())) from None
    _check_format(path, data.shape[1], rate, len(data))
    if not np.isfinite(data).all():
        raise ImpulseResponseError(f"the impulse response {path} holds values that are not finite numbers")
    return data, rate


def _check_format(path, channels, rate, frames):
    if channels not in (1, 2, 4):
        raise ImpulseResponseError(
            f"the impulse response {path} has {channels} channels, but legal are 1, 2 (left, right) or 4 "
            "(bass end left, right, treble end left, right)"
        )
    if not RATES[0] <= rate <= RATES[1]:
        raise ImpulseResponseError(
            f"the impulse response {path} has a sample rate of {rate} Hz, but legal are {RATES[0]} to {RATES[1]} Hz"
        )
    if frames < 1:
        raise ImpulseResponseError(f"the impulse response {path} is empty, but legal are 1 sample to {LONGEST:g} s")
    if frames > LONGEST * rate:
        raise ImpulseResponseError(
            f"the impulse response {path} lasts {frames / rate:.3g} s, but legal are at most {LONGEST:g} s "
            f"({LONGEST * 48000:.0f} samples at 48 kHz)"
        )


def _by_ends(data):
    """Channels (n, 1, 2 or 4) as (n, ends, outputs)."""
    n, channels = data.shape
    if channels == 4:
        return data.reshape(n, 2, 2)
    return np.ascontiguousarray(np.broadcast_to(data[:, None, :], (n, 2, 2)))

"""The format of takes: what was played enters, bytes of a Standard MIDI File that hold every bit of it leave.

A take is a MIDI file of format 0 with one track, whose ticks are the engine's frames: division and tempo are chosen
so that every sequencer plays it at its right speed (exactly at all usual rates; at odd ones within half a microsecond
a quarter note). Channel messages stand in it as themselves, at the frames at which they acted, universal SysEx in the
packets that MIDI files allow. What a MIDI file has no
message for stands in text events:

    ukrt take 1 {json}                      first event: sample rate, signal, the engine's settings, versions
    ukrt preset N part K of M <line> TOML   the guitar that begins (N = 0), or that swap N brings; M parts make one text
    ukrt swap N {json}                      the guitar of preset N takes over, at its sample rate
    ukrt shed LEVEL                         how much is shed from here on
    ukrt reset FRAMES                       everything came to rest, and was silent for so long
    ukrt message FF 00 00                   a message that no MIDI file may hold
    ukrt lost N                             so many entries are missing here: the take is not exact from here on

The end of the track stands at the number of frames that were computed. Deltas beyond what MIDI files can hold
(2^28 - 1 frames, 93 minutes at 48 kHz) are bridged by empty text events.
"""

import dataclasses
import hashlib
import json
import pathlib
import platform
from fractions import Fraction

from ukrt import __version__
from ukrt.engine.layout import M_GAIN, METER
from ukrt.engine.stage_layout import (
    KIND_MIDI,
    KIND_RESET,
    KIND_SHED,
    KIND_SHIFT,
    KIND_SWAP,
    SYSEX_BEGIN,
    SYSEX_END,
    SYSEX_MORE,
    VALUE_MASK,
)
from ukrt.errors import ImpulseResponseError
from ukrt.model.preset_text import dump_preset

FORMAT = 1
MARK = "ukrt take "
MAX_DELTA = (1 << 28) - 1  # what four bytes of seven bits hold (RP-001)
MAX_DIVISION = 32767  # 15 bits
MAX_TEMPO = (1 << 24) - 1  # microseconds per quarter note, three bytes
TEXT_BYTES = 4000  # of one text event; longer texts are split (choice: some sequencers keep them in small buffers)
TEXT, TRACK_NAME, TEMPO, END = 0x01, 0x03, 0x51, 0x2F
TEMPOS = (500_000, 250_000, 125_000)  # microseconds per quarter note that are tried first: 120 a minute and its doubles
ONE_DATA_BYTE = (0xC0, 0xD0)  # program change, channel pressure
EVENT_NAMES = {KIND_SHED: "shed", KIND_RESET: "reset"}


@dataclasses.dataclass(frozen=True)
class Sound:
    """A guitar as it sounds: what a take must know of one instance.

    Attributes
    ----------
    guitar : ukrt.model.parameters.Guitar
    sample_rate : float [Hz]
    response : dict or None
        Of the impulse response: ``name`` as the guitar gives it, ``file`` it came from, ``sha256`` of its bytes.
    gain : float [1]
        Of what goes to a sound card.
    """

    guitar: object
    sample_rate: float
    response: dict | None
    gain: float = 1.0


def sound_of(instance):
    """The `Sound` of an `ukrt.engine.instance.Instance` that is about to be played."""
    guitar, rate = instance.guitar, float(instance.sample_rate)
    gain = float(instance.d[METER + M_GAIN])
    if instance.signal != "pressure":
        return Sound(guitar, rate, None, gain)
    from ukrt.radiation.impulse_response import load_impulse_response

    name = guitar.radiation.impulse_response
    try:
        path = pathlib.Path(load_impulse_response(name, rate).source).absolute()
        response = {"name": name, "file": str(path), "sha256": file_hash(path)}
    except (ImpulseResponseError, OSError):  # gone since the instance was made: the take is kept without its hash
        response = None
    return Sound(guitar, rate, response, gain)


def file_hash(path):
    """SHA-256 of a file's bytes (str)."""
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def environment():
    """What the bits of a take may depend on beside the take itself (dict of str to str)."""
    import llvmlite.binding
    import numba
    import numpy

    from ukrt.engine.kernel_cache import kernel_fingerprint

    return {
        "kernels": kernel_fingerprint(),
        "numba": numba.__version__,
        "numpy": numpy.__version__,
        "machine": f"{platform.system()} {platform.machine()}",
        "processor": llvmlite.binding.get_host_cpu_name(),
        "libc": " ".join(platform.libc_ver()).strip(),
    }


# Time ----------------------------------------------------------------------------------------------------------------


def ticks_and_tempo(sample_rate):
    """Ticks per quarter note and microseconds per quarter note that make a tick one frame.

    Returns
    -------
    division, tempo : int
        ``tempo / division`` is ``1e6 / sample_rate`` exactly where whole numbers can say it, as near as they can
        otherwise.
    """
    rate = Fraction(sample_rate)
    for tempo in TEMPOS:
        division = rate * tempo / 1_000_000
        if division.denominator == 1 and 1 <= division <= MAX_DIVISION:
            return int(division), tempo
    ratio = (1_000_000 / rate).limit_denominator(MAX_DIVISION)  # tempo over division
    times = max(min(MAX_DIVISION // ratio.denominator, MAX_TEMPO // max(ratio.numerator, 1)), 1)
    return ratio.denominator * times, ratio.numerator * times


def tempo_at(sample_rate, division):
    """Microseconds per quarter note of ``division`` frames, rounded (int): for a sample rate that comes later."""
    return min(max(round(Fraction(division) * 1_000_000 / Fraction(sample_rate)), 1), MAX_TEMPO)


# Bytes ---------------------------------------------------------------------------------------------------------------


def number(value):
    """A variable-length number of at most four bytes."""
    out = [value & 0x7F]
    while value := value >> 7:
        out.append(value & 0x7F | 0x80)
    return bytes(reversed(out))


def meta(kind, data):
    """A meta event without its delta."""
    return bytes((0xFF, kind)) + number(len(data)) + data


def text(words):
    """A text event without its delta."""
    return meta(TEXT, words.encode("utf-8"))


def word_of(status, data1=0, data2=0):
    """A MIDI message as the journal's word."""
    return KIND_MIDI << KIND_SHIFT | status << 16 | data1 << 8 | data2


class Encoder:
    """Turns journal entries into bytes of the track; keeps the frame it has come to.

    Parameters
    ----------
    division : int
        Ticks per quarter note.
    """

    def __init__(self, division):
        self.division, self.frame = division, 0

    def head(self, sound, description):
        """The events before the first frame.

        Parameters
        ----------
        sound : Sound
        description : dict
            As `describe` gives it.
        """
        events = [text(f"{MARK}{FORMAT} {_json(description)}"), *_preset(0, sound.guitar)]
        events.append(meta(TRACK_NAME, sound.guitar.name.encode("utf-8")))
        events.append(self._tempo(sound))
        return b"".join(b"\0" + event for event in events)

    def entry(self, frame, word, sounds=None):
        """One entry of the journal; ``sounds`` tells which `Sound` the swap of a number brings."""
        kind, value = word >> KIND_SHIFT, word & VALUE_MASK
        if kind == KIND_MIDI:
            return self.at(frame, _message(value >> 16 & 0xFF, value >> 8 & 0xFF, value & 0xFF))
        if kind == KIND_SWAP:
            return self.at(frame, *self._swap(value, sounds(value)))
        return self.at(frame, text(f"ukrt {EVENT_NAMES[kind]} {value}"))

    def lost(self, frame, count):
        """A note that ``count`` entries are missing before ``frame``."""
        return self.at(frame, text(f"ukrt lost {count}"))

    def end(self, frame):
        """The end of the track; the encoder does not move, the next events take its place."""
        return number(max(frame - self.frame, 0)) + meta(END, b"")

    def bridge(self, frame):
        """Empty texts up to where a delta reaches ``frame``."""
        out = b""
        while frame - self.frame > MAX_DELTA:
            out += number(MAX_DELTA) + text("")
            self.frame += MAX_DELTA
        return out

    def at(self, frame, *events):
        """Events at ``frame``; those that would go back in time stand where the encoder is."""
        out = [self.bridge(frame)]
        for event in events:
            out.append(number(max(frame - self.frame, 0)) + event)
            self.frame = max(frame, self.frame)
        return b"".join(out)

    def _swap(self, n, sound):
        words = _json({"sample_rate": sound.sample_rate, "output_gain": sound.gain, "impulse_response": sound.response})
        return [*_preset(n, sound.guitar), text(f"ukrt swap {n} {words}"), self._tempo(sound)]

    def _tempo(self, sound):
        return meta(TEMPO, tempo_at(sound.sample_rate, self.division).to_bytes(3, "big"))


def describe(sound, signal, channels, settings, division):
    """The first text's content: all that a take must say of itself beside the guitars (dict)."""
    return {
        "sample_rate": sound.sample_rate,
        "signal": signal,
        "channels": channels,
        "settings": settings,
        "impulse_response": sound.response,
        "preset": sound.guitar.name,
        "division": division,
        "ukrt": __version__,
        "environment": environment(),
    }


def file_head(division, track_bytes):
    """The bytes before a take's track."""
    header = b"MThd" + (6).to_bytes(4, "big") + bytes((0, 0, 0, 1)) + division.to_bytes(2, "big")
    return header + b"MTrk" + track_bytes.to_bytes(4, "big")


def _message(status, data1, data2):
    """A message as itself where a MIDI file may hold it, as text otherwise."""
    if (packet := packet_of(status, data1, data2)) is not None:
        return packet[:1] + number(len(packet) - 1) + packet[1:]
    if 0x80 <= status < 0xF0 and data1 < 0x80 and data2 < 0x80:
        return bytes((status, data1)) if status & 0xF0 in ONE_DATA_BYTE else bytes((status, data1, data2))
    return text(f"ukrt message {status:02X} {data1:02X} {data2:02X}")


def packet_of(status, data1, data2):
    """A piece of a SysEx as the packet that a MIDI file splits a SysEx into (RP-001), its length left out; else None.
    """
    if max(data1, data2) >= 0x80:
        return None
    if status == SYSEX_BEGIN:
        return bytes((SYSEX_BEGIN, data1, data2))
    if status == SYSEX_MORE:
        return bytes((SYSEX_END, data1, data2))
    if status == SYSEX_END and data2 <= 1 and (data2 or not data1):
        return bytes((SYSEX_END, data1, SYSEX_END)) if data2 else bytes((SYSEX_END, SYSEX_END))
    return None


def piece_of(status, raw):
    """The piece (status, data1, data2) of such a packet, ``raw`` what follows its length; None if it is another one."""
    if len(raw) == 2 and max(raw) < 0x80:
        return SYSEX_BEGIN if status == SYSEX_BEGIN else SYSEX_MORE, raw[0], raw[1]
    if status == SYSEX_END and raw[-1:] == b"\xf7" and len(raw) <= 2 and max(raw[:-1], default=0) < 0x80:
        return SYSEX_END, max(raw[:-1], default=0), len(raw) - 1
    return None


def _preset(n, guitar):
    """The text events that hold a guitar."""
    toml = dump_preset(guitar).encode("utf-8")
    parts = [toml[k : k + TEXT_BYTES] for k in range(0, len(toml), TEXT_BYTES)]
    heads = [f"ukrt preset {n} part {k + 1} of {len(parts)}\n".encode() for k in range(len(parts))]
    return [meta(TEXT, head + part) for head, part in zip(heads, parts, strict=True)]


def _json(tree):
    return json.dumps(tree, separators=(",", ":"), allow_nan=False)

"""SuperCollider's Klank with 800 modes: the server alone, offline (``scsynth -N``), from a score written here.

Definition and score are binary files; their formats are in SuperCollider's help under "Synth Definition File Format",
"Non-Realtime Synthesis" and "Server Command Reference".
"""

import re
import struct

from . import piece
from .modes import modes
from .peer import BLOCK, SAMPLE_RATE, Peer, Ready, called, program_path

CONTROL_RATE, AUDIO_RATE = 1, 2
GAIN = 0.0015
_FRACTIONS = 2**32  # of a second, in OSC's time tags


def _text(words):
    return bytes([len(words)]) + words.encode()


def _ugen(name, rate, inputs, outputs):
    """One unit generator; each input is (number of a unit, of its output), or (-1, number of a constant)."""
    head = _text(name) + struct.pack(">biih", rate, len(inputs), len(outputs), 0)
    return head + b"".join(struct.pack(">ii", *one) for one in inputs) + bytes(outputs)


def definition():
    """A synth definition (bytes): a trigger is smoothed over one block and rings the modes."""
    constants, places = [], {}

    def constant(value):
        if value not in places:
            places[value] = len(constants)
            constants.append(value)
        return -1, places[value]

    rings = [constant(value) for hz, t60, gain in modes() for value in (hz, GAIN * gain, t60)]
    units = [
        _ugen("TrigControl", CONTROL_RATE, [], [CONTROL_RATE]),
        _ugen("K2A", AUDIO_RATE, [(0, 0)], [AUDIO_RATE]),
        _ugen("Klank", AUDIO_RATE, [(1, 0), constant(1.0), constant(0.0), constant(1.0), *rings], [AUDIO_RATE]),
        _ugen("Out", AUDIO_RATE, [constant(0.0), (2, 0)], []),
    ]
    parameters = struct.pack(">if", 1, 0.0) + struct.pack(">i", 1) + _text("strike") + struct.pack(">i", 0)
    body = struct.pack(">i", len(constants)) + struct.pack(f">{len(constants)}f", *constants) + parameters
    body += struct.pack(">i", len(units)) + b"".join(units) + struct.pack(">h", 0)
    return b"SCgf" + struct.pack(">ih", 2, 1) + _text("bank") + body


def _padded(data):
    return data + b"\0" * (-len(data) % 4)


def message(address, *values):
    """An OSC message (bytes)."""
    tags, data = ",", b""
    for value in values:
        if isinstance(value, bytes):
            tags, data = tags + "b", data + struct.pack(">i", len(value)) + _padded(value)
        elif isinstance(value, str):
            tags, data = tags + "s", data + _padded(value.encode() + b"\0")
        else:
            kind = "f" if isinstance(value, float) else "i"
            tags, data = tags + kind, data + struct.pack(">" + kind, value)
    return _padded(address.encode() + b"\0") + _padded(tags.encode() + b"\0") + data


def score(notes, seconds):
    """A score for ``scsynth -N`` (bytes): the bank from the beginning, a strike at each note, an end."""
    bundles = [(0.0, message("/d_recv", definition())), (0.0, message("/s_new", "bank", 1000, 0, 0))]
    bundles += [(note.start, message("/n_set", 1000, "strike", note.velocity / 127)) for note in notes]
    bundles.append((seconds, message("/c_set", 0, 0)))
    result = b""
    for at, content in bundles:
        whole, fraction = divmod(at, 1.0)
        stamp = struct.pack(">II", int(whole), int(fraction * _FRACTIONS))
        bundle = b"#bundle\0" + stamp + struct.pack(">i", len(content)) + content
        result += struct.pack(">i", len(bundle)) + bundle
    return result


def _prepare(work):
    program = program_path("scsynth")
    version = re.search(r"scsynth (\S+)", called("scsynth", "-v"))

    def command(seconds, target):
        played = score(piece.first_seconds(work.notes, seconds), seconds)
        path = work.file(f"klank-{seconds:g}.osc", lambda path: path.write_bytes(played))
        files = ["-N", path, "_", target, str(SAMPLE_RATE), "WAV", "float"]
        return [program, *files, "-o", "1", "-i", "0", "-z", str(BLOCK), "-D", "0"]

    return Ready(command, version[1] if version else "?")


PEERS = (Peer("SuperCollider Klank, 800 modes", "uncoupled fixed filters", ("supercollider-server",), _prepare),)

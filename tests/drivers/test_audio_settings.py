"""Which output is meant, and what is refused before PortAudio sees it."""

import math
import types

import pytest

from ukrt.drivers.sound import portaudio as audio
from ukrt.drivers.sound import process as audio_process
from ukrt.errors import DeviceError


class PortAudio(types.SimpleNamespace):
    """A machine with two host APIs and four devices, one of them an input."""

    PortAudioError = type("PortAudioError", (Exception,), {})
    default = types.SimpleNamespace(device=(-1, -1))

    def query_hostapis(self):
        return [
            {"name": "ALSA", "default_output_device": 1},
            {"name": "JACK Audio Connection Kit", "default_output_device": 3},
        ]

    def query_devices(self):
        rows = [("hw:0", 0, 0, 48000.0), ("hw:1 Speakers", 2, 0, 44100.0), ("hw:2 Bass", 8, 0, 96000.0)]
        rows.append(("system", 2, 1, 48000.0))
        keys = ("name", "max_output_channels", "hostapi", "default_samplerate")
        return [{"index": k, **dict(zip(keys, row, strict=True))} for k, row in enumerate(rows)]

    def check_output_settings(self, index, channels, dtype, samplerate):
        assert channels <= self.query_devices()[index]["max_output_channels"]
        if samplerate != self.query_devices()[index]["default_samplerate"]:
            raise self.PortAudioError("Invalid sample rate")


@pytest.fixture(autouse=True)
def machine(monkeypatch):
    monkeypatch.setattr(audio, "_portaudio", PortAudio)


@pytest.mark.parametrize(
    ("wanted", "host_api", "index"),
    [
        (None, None, 1),
        (None, "jack", 3),
        (None, "alsa", 1),
        (2, None, 2),
        ("bass", "ALSA", 2),
        ("system", None, 3),
    ],
)
def test_an_output_by_name_index_and_host_api(wanted, host_api, index):
    assert audio.find_output(wanted, host_api).index == index


def test_inputs_are_no_outputs_and_each_host_api_has_its_default():
    assert [(o.index, o.is_default) for o in audio.list_outputs()] == [(1, True), (2, False), (3, False)]
    assert [(o.index, o.is_default) for o in audio.list_outputs("jack")] == [(3, True)]


@pytest.mark.parametrize(
    ("wanted", "host_api", "words"),
    [
        ("hw:", None, "ambiguous; it fits 1 .* 2 "),
        ("piano", None, "no audio output 'piano'; there is 1 .*, 2 .*, 3 "),
        ("system", "alsa", "no audio output 'system'; there is 1 .*, 2 "),
        (None, "asio", "no audio output has the host API 'asio'; there is ALSA, JACK"),
    ],
)
def test_a_wish_that_fits_none_or_several_is_told_what_there_is(wanted, host_api, words):
    with pytest.raises(DeviceError, match=words):
        audio.find_output(wanted, host_api)


def test_the_rate_is_the_one_asked_for_else_the_engines_else_the_devices():
    speakers = audio.find_output(1)
    assert audio.choose_rate(speakers, 96000) == 96000.0
    assert audio.choose_rate(speakers) == 44100.0
    assert audio.choose_rate(speakers, preferred=44100.0) == 44100.0
    assert audio.choose_rate(audio.find_output("system"), preferred=48000.0) == 48000.0


ABSURD = [
    {"sample_rate": math.nan},
    {"sample_rate": math.inf},
    {"sample_rate": -48000.0},
    {"sample_rate": 0},
    {"sample_rate": 7999.9},
    {"sample_rate": 1e9},
    {"sample_rate": "48000"},
    {"block_size": 1_000_000_000},
    {"block_size": -1},
    {"block_size": math.nan},
    {"block_size": 12.5},
    {"block_size": True},
    {"latency": math.nan},
    {"latency": -0.1},
    {"latency": 11.0},
    {"latency": "lowest"},
    {"channels": 0},
    {"channels": 1.5},
    {"channels": 100_000},
]


@pytest.mark.parametrize("settings", ABSURD, ids=str)
def test_absurd_numbers_never_reach_portaudio(settings):
    """PortAudio opens a stream of NaN Hz, and ends the program over a block of 1e9 frames."""
    with pytest.raises(DeviceError, match="not possible; it must be"):
        audio.check_settings(**settings)
    engine = types.SimpleNamespace(sample_rate=48000.0, channels=2)
    with pytest.raises(DeviceError, match="not possible"):
        audio.AudioOutput(engine, audio.find_output(), **settings)
    with pytest.raises(DeviceError, match="not possible"):
        audio_process.AudioProcess(engine, **settings)


LEGAL = [{}, {"block_size": 0}, {"block_size": 65536, "latency": 0.5}, {"sample_rate": 8000}]


@pytest.mark.parametrize("settings", LEGAL, ids=str)
def test_whatever_some_card_may_want_is_let_through(settings):
    audio.check_settings(**settings)


def test_more_channels_than_the_card_has_are_refused():
    engine = types.SimpleNamespace(sample_rate=48000.0, channels=2)
    with pytest.raises(DeviceError, match="'system' has 2 channels, 6 were asked for"):
        audio.AudioOutput(engine, audio.find_output("system"), channels=6)

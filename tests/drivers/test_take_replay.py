"""Bit for bit: what a card was given while anything happened is what the take renders, whatever the block sizes."""

import dataclasses
import json
import shutil

import numpy as np
import pytest
import soundfile
from engine import sysex

from ukrt.drivers.files.midi import load_midi_file
from ukrt.drivers.takes.files import render_take
from ukrt.drivers.takes.reader import read_take
from ukrt.drivers.takes.recorder import Recorder
from ukrt.engine import layout as instance_at
from ukrt.engine import stage_layout as at
from ukrt.engine.engine import Engine
from ukrt.engine.instance import Instance
from ukrt.errors import ImpulseResponseError, MidiFileError
from ukrt.model.presets import load_preset

RATE = 48000
CLASSICAL = load_preset("classical")
LANES = (at.LANE_PLAYER, at.LANE_MIDI, at.LANE_JACK)


class Player:
    """Plays an engine at random, in blocks of any size, and records it."""

    def __init__(self, folder, seed=1, guitar=CLASSICAL, rate=RATE, signal="pressure", gain=8.0, **settings):
        self.folder, self.random = folder, np.random.default_rng(seed)
        self.engine = Engine(guitar, rate, signal=signal, shared=True)
        self.engine.output_gain = gain
        self.engine.shed_budget = 0.0  # sheds only where a test says so, not where the machine is busy
        for name, value in settings.items():
            setattr(self.engine, name, value)
        self.recorder = Recorder(self.engine, folder / "take.mid", folder / "take.wav")
        self.given = []

    def play(self, frames, most=2000, messages=3):
        end = self.engine.frame + frames
        while self.engine.frame < end:
            for lane in LANES:
                for _ in range(self.random.integers(0, messages + 1)):
                    self._send(lane)
            n = min(int(self.random.integers(1, most)), end - self.engine.frame)
            self.given.append(self.engine.process_card(n))
            if self.random.random() < 0.2:
                self.recorder.drain()
        return self

    def _send(self, lane):
        key, value = int(self.random.integers(40, 84)), int(self.random.integers(0, 128))
        status, data1, data2 = [
            (0x90, key, value), (0x90, key, 100), (0x80, key, 64), (0xB0, 64, value), (0xB0, int(value), key),
            (0xE0, key, value), (0xD0, value, 0), (0xC0, value, 0), (0x90, key, 127),
        ][self.random.integers(9)]  # fmt: skip
        ahead = self.engine.frame + 3000  # all lanes wait here, so that frames within one never decrease
        self.engine.send(at.AT_ONCE if self.random.random() < 0.7 else ahead, status, data1, data2, lane=lane)

    def swap(self, guitar, rate=RATE, gain=4.0, announced=True):
        instance = Instance(guitar, rate, self.engine.signal, shared=True)
        self.engine.load(instance, gain)
        if announced:
            self.recorder.announce(instance)
        self.engine.swap()

    def stop(self):
        """The take's file, and what the card got."""
        self.recorder.close()
        assert self.recorder.news() == [] or len(self.recorder.counts()["files"]) > 2
        self.counters = self.engine.counters()
        self.engine.close()
        return self.folder / "take.mid", np.concatenate(self.given)


def bits(samples):
    return np.ascontiguousarray(samples, np.float32).view(np.uint32)


def read(path):
    return soundfile.read(path, dtype="float32", always_2d=True)[0]


def assert_equal_to_its_take(player, blocks=(512,)):
    """Recording, take rendered in blocks of these sizes, and what the card got: all the same bits."""
    path, given = player.stop()
    np.testing.assert_array_equal(bits(read(player.folder / "take.wav")), bits(given))
    assert np.count_nonzero(given) > len(given) / 4
    for block in blocks:
        report = render_take(path, player.folder / "out.wav", block_size=block)
        rendered = read(player.folder / "out.wav")
        assert rendered.shape == given.shape
        wrong = np.flatnonzero(np.any(bits(rendered) != bits(given), axis=1))
        assert len(wrong) == 0, f"block {block}: {len(wrong)} frames differ, the first is {wrong[0]}"
        assert report["warnings"] == []
    return report


def test_messages_in_three_lanes_through_the_limiter(tmp_path):
    player = Player(tmp_path).play(RATE)
    report = assert_equal_to_its_take(player, blocks=(1, 333, 8192))
    assert player.counters["limited_samples"] > 1000 and player.counters["midi_received"] > 100
    assert report["notes_total"] == player.counters["notes_on"] == len(report["notes"]) > 30
    json.dumps(report, allow_nan=False)


@pytest.mark.parametrize("signal", ["bridge-force", "strings"])
def test_forces_at_another_rate_without_the_limiter(tmp_path, signal):
    player = Player(tmp_path, 2, rate=44100, signal=signal, gain=0.01, limiter=False).play(20_000)
    report = assert_equal_to_its_take(player)
    assert (report["sample_rate"], report["signal"]) == (44100, signal) and player.counters["limited_samples"] == 0


def test_floods_that_the_cap_holds_back(tmp_path):
    player = Player(tmp_path, 3).play(5000)
    for k in range(3000):
        player.engine.send(player.engine.frame, 0xB0, 1, k % 128, lane=at.LANES - 1)
    player.play(10_000, most=300)
    assert_equal_to_its_take(player)
    assert player.counters["delayed_messages"] > 1000


def test_a_cable_that_is_pulled(tmp_path):
    player = Player(tmp_path, 4).play(3000)
    player.engine.send(at.AT_ONCE, 0xFE, lane=at.LANE_MIDI)
    player.play(2 * RATE // 3, messages=0)
    assert_equal_to_its_take(player)
    assert player.counters["sensing_timeouts"] == 1


def test_sysex_and_volume(tmp_path):
    """Whole and torn, in lanes that go on beside each other, while the cap holds pieces back, through a swap."""
    player = Player(tmp_path, 14).play(2000)
    whole = [
        sysex.note_tuning({key: key + 0.4 for key in range(40, 84)}), sysex.scale_tuning(range(-6, 6)),
        sysex.master_volume(9000), sysex.master_fine(7000), sysex.exclusive(0x43, 1, 2), sysex.general_midi(1),
        sysex.note_tuning({key: 88.0 - key for key in range(40, 84)}, bank=0, real_time=False),
    ]  # fmt: skip
    for number, message in enumerate(whole):
        for piece in sysex.messages(message)[: None if number % 3 else 2 * number + 9]:
            player.engine.send(at.AT_ONCE, *piece, lane=LANES[number % 2])
        for controller in (7, 11, 66, 67):
            value = int(player.random.integers(30, 128))
            player.engine.send(at.AT_ONCE, 0xB0, controller, value, lane=LANES[2])
        player.play(4000, most=700)
        if number == 4:
            player.swap(load_preset("drop-d"))
    report = assert_equal_to_its_take(player, blocks=(1, 333))
    counted = [report["counters"][name] for name in ("sysex_ignored", "sysex_refused")]
    assert counted == [player.counters[name] for name in ("sysex_ignored", "sysex_refused")] and counted[0] == 1
    take = player.folder / "take.mid"
    score = load_midi_file(take)
    assert np.count_nonzero(score.status == 0xF7) == np.count_nonzero(read_take(take).event_words >> 16 == 0xF7) > 3


def test_not_a_number_in_the_state(tmp_path):
    player = Player(tmp_path, 5)
    for _ in range(3):
        player.play(5000, most=200)
        player.engine._d[instance_at.STATE + int(player.random.integers(0, 50))] = np.nan
        player.play(64, most=20)
    player.play(10_000)
    assert_equal_to_its_take(player, blocks=(1, 100, 4096))
    assert player.counters["nonfinite_resets"] == 3


def test_a_host_that_died_within_the_callback(tmp_path):
    player = Player(tmp_path, 6).play(5000)
    player.engine._si[at.G_BUSY] = 1
    assert player.engine.recover()
    player.play(10_000)
    assert_equal_to_its_take(player)
    assert player.counters["resets"] == 1


def test_levels_of_shedding(tmp_path):
    player = Player(tmp_path, 7)
    for level in (1, 3, 2, 0):
        player.play(4000)
        player.engine._si[at.G_SHED_WANTED] = level  # as the overload watch asks for it
    player.play(8000)
    assert_equal_to_its_take(player, blocks=(64, 1000))
    assert player.counters["shed_events"] == 4
    kinds = read_take(tmp_path / "take.mid").event_words >> at.KIND_SHIFT
    assert np.count_nonzero(kinds == at.KIND_SHED) == 4


@pytest.mark.parametrize("seed", range(100, 108))
def test_sessions_in_which_everything_happens(tmp_path, seed):
    player = Player(tmp_path, seed, gain=2.0 ** (seed % 6))
    engine, dice = player.engine, np.random.default_rng(seed)
    for _ in range(10):
        player.play(int(dice.integers(10, 5000)), most=int(dice.integers(2, 3000)), messages=int(dice.integers(0, 10)))
        match dice.integers(6):
            case 0:
                engine._d[instance_at.STATE + int(dice.integers(0, 3000))] = np.inf
            case 1:
                engine._si[at.G_SHED_WANTED] = int(dice.integers(0, 5))
            case 2 if not engine.swapping:
                player.swap(
                    load_preset(["drop-d", "classical", "paper"][dice.integers(3)]), gain=dice.uniform(0.5, 20.0)
                )
            case 3:
                engine.send(at.AT_ONCE, 0xFE, lane=int(dice.integers(3)))
            case 4:
                for key in dice.integers(36, 90, size=400).tolist():
                    engine.send(engine.frame, 0x90, key, 100, lane=at.LANES - 1)
            case 5:
                engine._si[at.G_BUSY] = 1
                engine.recover()
    player.play(3000)
    assert_equal_to_its_take(player, blocks=(int(dice.integers(1, 9000)),))


@pytest.mark.parametrize("announced", [True, False])
def test_another_guitar_while_strings_ring(tmp_path, announced):
    player = Player(tmp_path, 8).play(6000)
    player.swap(load_preset("drop-d"), gain=2.0, announced=announced)
    player.play(12_000)
    player.recorder.drain()
    player.swap(dataclasses.replace(CLASSICAL, name="Größe"), gain=9.0, announced=announced)
    player.play(1000)  # in the middle of the fade
    player.engine._d[instance_at.STATE] = np.nan
    player.play(8000)
    assert_equal_to_its_take(player, blocks=(1, 512))
    assert player.counters["swaps"] == 2 and player.counters["nonfinite_resets"] == 1
    guitars = [sound.guitar.name for sound in read_take(tmp_path / "take.mid").sounds.values()]
    assert guitars == ["classical", "drop-d", "Größe"]


def test_another_sample_rate_is_another_file(tmp_path):
    player = Player(tmp_path, 9).play(6000)
    player.swap(CLASSICAL, rate=44100)
    player.play(6000)
    player.swap(CLASSICAL, rate=96000)
    player.play(6000)
    path, given = player.stop()
    report = render_take(path, tmp_path / "out.wav", block_size=100)
    assert report["duration_s"] == pytest.approx(6000 / 48000 + 6000 / 44100 + 6000 / 96000)
    for k, rate in enumerate((48000, 44100, 96000)):
        name = "out.wav" if k == 0 else f"out-{k + 1}.wav"
        part = bits(given[6000 * k : 6000 * (k + 1)])
        for one in (name, name.replace("out", "take")):
            np.testing.assert_array_equal(bits(read(tmp_path / one)), part)
            assert soundfile.info(tmp_path / one).samplerate == rate
        assert str(tmp_path / name) in report["files"]
    times = (6000 / 48000, 6000 / 48000 + 6000 / 44100)  # where the rate changes
    for start_s, end_s, kept in (
        (0.1, times[0] + 0.05, [(4800, 6000, 48000), (6000, 6000 + 2205, 44100)]),
        (times[0], times[1], [(6000, 12000, 44100)]),
        (times[1] + 0.02, 99.0, [(12000 + 1920, 18000, 96000)]),
    ):
        report = render_take(path, tmp_path / "part.wav", block_size=333, start_s=start_s, end_s=end_s)
        assert len(report["files"]) == len(kept) and report["frames"] == kept[-1][1] - kept[0][0]
        for file, (first, end, rate) in zip(report["files"], kept, strict=True):
            assert soundfile.info(file).samplerate == rate
            np.testing.assert_array_equal(bits(read(file)), bits(given[first:end]))
        assert all(0 <= note["release_frame"] < report["frames"] for note in report["notes"])


def test_a_take_that_was_cut_off_renders_what_it_holds(tmp_path):
    path, given = Player(tmp_path, 10).play(20_000).stop()
    path.write_bytes(path.read_bytes()[:-60])
    report = render_take(path, tmp_path / "out.wav")
    rendered = read(tmp_path / "out.wav")
    assert 10_000 < len(rendered) < 20_000 and "breaks off" in report["warnings"][0]
    np.testing.assert_array_equal(bits(rendered), bits(given[: len(rendered)]))


def test_other_formats_hold_the_same_sound_rounded(tmp_path):
    path, given = Player(tmp_path, 11).play(5000).stop()
    report = render_take(path, tmp_path / "out.flac", bits="24")
    assert np.max(np.abs(read(tmp_path / "out.flac") - given)) <= 2.0**-23 and report["bits"] == "24"


def test_another_machine_is_named_in_a_warning(tmp_path):
    path, _ = Player(tmp_path, 12).play(500).stop()
    fingerprint = read_take(path).environment["kernels"].encode()
    path.write_bytes(path.read_bytes().replace(fingerprint, b"0" * len(fingerprint)))
    (warning,) = render_take(path, tmp_path / "out.wav")["warnings"]
    assert f"kernels {'0' * len(fingerprint)}" in warning and "may differ" in warning and "numba" not in warning


@pytest.fixture
def hall(tmp_path):
    """A take that was played through a response out of a file, and that file."""
    folder = tmp_path / "rooms"
    folder.mkdir()
    response = np.random.default_rng(0).normal(size=(500, 2)) * np.exp(-np.arange(500) / 50)[:, None]
    soundfile.write(folder / "hall.wav", 0.1 * response, RATE, subtype="FLOAT")
    radiation = dataclasses.replace(CLASSICAL.radiation, impulse_response=str(folder / "hall.wav"))
    player = Player(tmp_path, 13, dataclasses.replace(CLASSICAL, radiation=radiation)).play(3000)
    return (*player.stop(), folder / "hall.wav")


def test_a_response_out_of_a_file_is_found_where_it_was_or_beside_the_take(tmp_path, hall):
    path, given, file = hall
    render_take(path, tmp_path / "out.wav")
    np.testing.assert_array_equal(bits(read(tmp_path / "out.wav")), bits(given))
    shutil.move(file, tmp_path / "hall.wav")
    render_take(path, tmp_path / "out.wav")
    np.testing.assert_array_equal(bits(read(tmp_path / "out.wav")), bits(given))


@pytest.mark.parametrize("change", ["another", "none"])
def test_another_response_than_was_played_through_is_refused(tmp_path, hall, change):
    path, _, file = hall
    file.unlink()
    if change == "another":
        soundfile.write(file, np.ones((10, 2)), RATE)
    with pytest.raises(ImpulseResponseError, match=r"take\.mid.*hall\.wav") as caught:
        render_take(path, tmp_path / "out.wav")
    assert "\n" not in str(caught.value) and not (tmp_path / "out.wav").exists()


def test_settings_and_lengths_that_cannot_be_are_refused(tmp_path):
    path, _ = Player(tmp_path, 14).play(500).stop()
    with pytest.raises(MidiFileError, match="--max-minutes"):
        render_take(path, tmp_path / "out.wav", max_minutes=0.0001)
    data = path.read_bytes()
    for old, new, words in ((b'"limiter":', b'"lomiter":', "settings"), (b'"channels":2', b'"channels":5', "channels")):
        path.write_bytes(data.replace(old, new))
        with pytest.raises(MidiFileError, match=words):
            render_take(path, tmp_path / "out.wav")
    assert not (tmp_path / "out.wav").exists()

"""What ``tools/prove_live.py`` counts, on data whose answer is known: a proof that cannot fail would prove nothing."""

import pathlib
import sys

import numpy as np
import pytest
import soundfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))

from prove import cells, delay, dense, flood, schedules


def words_of(messages):
    return [int.from_bytes(message, "big") for message in messages]


@pytest.fixture
def sent():
    frames, messages, _ = schedules.steady(1000, 4.0)
    return words_of(messages), frames


def test_a_schedule_numbers_its_messages(sent):
    words, frames = sent
    assert len(words) == len(frames) == 4000 and frames[-1] == 3999 * 48
    numbered = [word for word in words if word >> 20 == 0xA]
    assert len(set(numbered)) == len(numbered) == 4000 * 38 // 40


def test_nothing_is_missed_where_all_arrives(sent):
    words, frames = sent
    result = flood.compare(words, frames, np.array(words), np.array(frames) + 64)
    assert [result[name] for name in ("lost", "doubled", "swapped", "foreign")] == [0, 0, 0, 0]
    assert set(result["jitter_frames"].values()) == {0}


def test_each_fault_is_counted_as_itself(sent):
    words, frames = sent
    played, times = list(words), [frame + 64 for frame in frames]
    del played[1001:1004], times[1001:1004]
    played[2001], played[2002] = played[2002], played[2001]
    played.insert(3003, played[3002])
    times.insert(3003, times[3002])
    played.append(0xB00740)
    times.append(times[-1])
    times[505] += 30
    result = flood.compare(words, frames, np.array(played), np.array(times))
    assert [result[name] for name in ("lost", "doubled", "swapped", "foreign")] == [3, 1, 1, 1]
    # The two that changed places are 48 frames too late and too early, which makes all of their tenth of a second late.
    assert result["jitter_frames"]["max"] == 96 and result["jitter_frames"]["median"] == 0


def test_the_guitars_own_events_do_not_count(sent):
    words, frames = sent
    played = np.array([*words, 3 << 32 | 1])
    result = flood.compare(words, frames, played, np.array([*frames, frames[-1]]))
    assert (result["lost"], result["foreign"]) == (0, 0)


def test_the_first_changed_sample_is_found(tmp_path):
    """Notes that begin as the guitar's do, over what is left of the last one: a slow and faint swing."""
    marks, offsets = [5000, 15000, 25000, 35000], [3, 60, 0, 17]
    late = [0, 7, 180, None]
    sound = np.zeros((45000, 2), np.float32)
    sound[:, 0] = 1e-5 * np.sin(2 * np.pi * 90.0 * np.arange(len(sound)) / 48000.0)
    for at, frames in zip(marks, late, strict=True):
        sound[at, 1] = 1.0
        if frames is not None:
            sound[at + frames : at + frames + 400, 0] += 4e-6 * np.arange(1, 401) ** 2
            sound[at + frames + 400 : at + 5000, 0] = sound[at + frames + 399, 0]
    sound[30000:, 0] = 0.0
    soundfile.write(tmp_path / "heard.wav", sound, 48000, subtype="FLOAT")
    found = delay._find_notes(tmp_path / "heard.wav", offsets)
    assert found["delays"] == [0, 7, 180]
    assert found["from_cycle"] == [3, 67, 180]
    assert (found["markers"], found["not_quiet_before"], found["not_heard"]) == (4, 0, 1)
    assert delay._distribution(found["delays"])["spread_frames"] == 180


def test_noise_before_a_note_is_told(tmp_path):
    sound = np.zeros((20000, 2), np.float32)
    sound[:, 0] = 1e-3 * np.random.default_rng(1).standard_normal(len(sound))
    sound[10000, 1] = 1.0
    soundfile.write(tmp_path / "heard.wav", sound, 48000, subtype="FLOAT")
    found = delay._find_notes(tmp_path / "heard.wav", [0])
    assert (found["delays"], found["not_quiet_before"]) == ([], 1)


def cell_of(compiled, empty):
    rows = [("compiled", n) for n in compiled] + [("empty", n) for n in empty]
    slices = [{"source": name, "missing": n, "xruns": n, "flags": {"underflows": 0}} for name, n in rows]
    return {"slices": slices}


def test_chance_tells_a_difference_from_noise():
    noise = [cell_of([3, 9, 0, 4, 12, 1], [5, 2, 8, 3, 0, 9])]
    worse = [cell_of([30, 41, 25, 38, 29, 33], [5, 2, 8, 3, 0, 9])] * 2
    assert cells.chance_of(noise, "missing") > 0.2
    assert cells.chance_of(worse, "missing") < 0.01


def test_memory_that_grows_has_a_slope():
    samples = [{"seconds": t, "rss_kib": {"main": 1000 + 2 * t, "child": 50}} for t in range(0, 600, 2)]
    assert dense._trend(samples, "main", 600.0)["slope_kib_per_minute"] == pytest.approx(120.0)
    assert dense._trend(samples, "child", 600.0)["slope_kib_per_minute"] == pytest.approx(0.0, abs=1e-9)


def test_the_dense_piece_plays_all_strings(tmp_path):
    from ukrt.drivers.files.midi import load_midi_file

    count = dense.make_piece(tmp_path / "dense.mid")
    score = load_midi_file(tmp_path / "dense.mid")
    assert score.n_notes == count > dense.PIECE_SECONDS * 16
    assert score.duration_s == pytest.approx(dense.PIECE_SECONDS, abs=0.1)

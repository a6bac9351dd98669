"""The callback as hosts see it: block sizes, doubles and floats, late and lost messages, recovery from NaN."""

import numpy as np
import pytest
from engine.shedding import dense

from ukrt.engine import layout as at
from ukrt.engine import stage_layout as stage_at
from ukrt.engine.callback_type import CALLBACK
from ukrt.engine.engine import Engine
from ukrt.errors import ParameterError
from ukrt.model.presets import load_preset

FRAMES = 24000


def _play(block, signal, sample_rate=48000.0, frames=FRAMES):
    engine = Engine(load_preset("classical"), sample_rate, signal=signal)
    for message in dense(FRAMES):
        assert engine.send(*message)
    blocks = [engine.process(min(block, frames - start)) for start in range(0, frames, block)]
    return np.concatenate(blocks), engine


@pytest.mark.parametrize("signal", ["pressure", "strings"])
def test_block_size_changes_no_bit(signal):
    whole, engine = _play(8192, signal)
    assert np.abs(whole).max() > 0.01
    assert engine.counters()["notes_on"] > 20
    for block in (1, 7, 64, 65, 1000):
        assert np.array_equal(_play(block, signal)[0], whole)


@pytest.mark.parametrize("sample_rate", [44100.0, 88200.0, 96000.0, 192000.0])
def test_other_sample_rates_play_and_stay_invariant(sample_rate):
    whole, _ = _play(4096, "pressure", sample_rate)
    assert np.isfinite(whole).all() and np.abs(whole).max() > 0.01
    assert np.array_equal(_play(333, "pressure", sample_rate)[0], whole)


def test_strings_add_up_to_the_bridge_force():
    strings, force = _play(512, "strings")[0], _play(512, "bridge-force")[0]
    assert np.abs(strings.sum(axis=1) - force[:, 0]).max() < 1e-12 * np.abs(force).max()


def test_the_card_gets_the_same_samples_as_floats_with_gain():
    """The same C function, called as PortAudio calls it, gives the doubles rounded to float32."""
    doubles, _ = _play(256, "pressure")
    engine = Engine(load_preset("classical"), 48000.0)
    engine.output_gain = 0.25
    for message in dense(FRAMES):
        engine.send(*message)
    call = CALLBACK(engine.callback_address)
    out = np.zeros((FRAMES, 2), np.float32)
    for start in range(0, FRAMES, 160):
        assert call(None, out[start:].ctypes.data, 160, None, 4 if start == 320 else 0, engine.userdata_address) == 0
    assert np.array_equal(out, (0.25 * doubles).clip(-1.0, 1.0).astype(np.float32))
    assert engine.counters()["underflows"] == 1


def test_a_block_larger_than_a_piece_is_computed_in_pieces():
    engine = Engine(load_preset("classical"), 48000.0)
    out = np.zeros((16384, 2), np.float32)
    engine.send(0, 0x90, 64, 100)
    assert CALLBACK(engine.callback_address)(None, out.ctypes.data, 16384, None, 0, engine.userdata_address) == 0
    assert np.abs(out[8000:]).max() > 0.0
    assert engine.frame == 16384


def test_a_closed_instance_is_refused():
    engine = Engine(load_preset("classical"), 48000.0)
    engine.close()
    out = np.zeros((64, 2), np.float32)
    assert CALLBACK(engine.callback_address)(None, out.ctypes.data, 64, None, 0, engine.userdata_address) == 2


@pytest.mark.parametrize("poison", [np.nan, np.inf])
def test_what_is_no_number_is_cleared_counted_and_never_heard(poison):
    engine = Engine(load_preset("classical"), 48000.0)
    engine.send(0, 0x90, 64, 100)
    engine.process(4800)
    engine._d[at.STATE + 5] = poison
    after = engine.process(4800)
    assert np.isfinite(after).all()
    assert engine.counters()["nonfinite_resets"] == 1
    engine.send(engine.frame, 0x90, 60, 100)
    again = engine.process(9600)
    assert np.isfinite(again).all() and np.abs(again).max() > 0.01


def test_late_and_lost_messages_are_counted():
    engine = Engine(load_preset("classical"), 48000.0)
    engine.process(1000)
    engine.send(10, 0x90, 64, 100)
    for _ in range(stage_at.ROOM[stage_at.CLASS_OTHER] - 1):
        assert engine.send(engine.frame, 0xB0, 1, 1)
    assert not engine.send(engine.frame, 0xB0, 1, 1)
    engine.process(64)
    counts = engine.counters()
    assert counts["late_messages"] == 1 and counts["midi_dropped"] == 1 == counts["controllers_refused"]
    assert counts["midi_received"] == stage_at.ROOM[stage_at.CLASS_OTHER] and counts["notes_on"] == 1


def test_a_full_lane_refuses_the_end_of_notes_last():
    engine = Engine(load_preset("classical"), 48000.0)
    sent = dict.fromkeys(("controllers", "ons", "offs"), 0)
    for _ in range(stage_at.QUEUE):
        sent["controllers"] += engine.send(0, 0xE0, 0, 64)
        sent["ons"] += engine.send(0, 0x90, 64, 100)
        sent["offs"] += engine.send(0, 0x80, 64, 0)
    assert 3 * sent["controllers"] == pytest.approx(stage_at.ROOM[stage_at.CLASS_OTHER], abs=3)
    waiting_for_ends = stage_at.QUEUE - stage_at.ROOM[stage_at.CLASS_NOTE_ON]
    assert sent["offs"] - sent["ons"] == pytest.approx(waiting_for_ends, abs=3)
    assert sum(sent.values()) == stage_at.QUEUE
    counts = engine.counters()
    assert counts["midi_dropped"] == 3 * stage_at.QUEUE - stage_at.QUEUE


def test_release_falls_one_ramp_after_the_event():
    """The bridge feels the ramp grow from the event on; at its end the force of the released string turns round."""
    engine = Engine(load_preset("classical"), 48000.0, signal="bridge-force")
    engine.send(1000, 0x90, 40, 100)
    force = engine.process(2000)[:, 0]
    assert np.abs(force[:1000]).max() == 0.0
    note = engine.note_log()[0]
    assert note["release_frame"] == 1000 + engine.lead_frames
    before = np.abs(np.diff(force[1010 : note["release_frame"] - 2], 2)).max()
    after = np.abs(np.diff(force[note["release_frame"] :], 2)).max()
    assert after > 10.0 * before


def test_reset_gives_the_same_notes_again():
    engine = Engine(load_preset("classical"), 48000.0)
    first = []
    for _ in range(2):
        engine.send(100, 0x90, 52, 90)
        first.append(engine.process(6000))
        engine.reset()
    assert np.array_equal(*first)


@pytest.mark.parametrize("rate", [8000.0, 44099.0, 768000.0, float("nan"), float("inf"), -48000.0])
def test_impossible_sample_rates_are_refused(rate):
    with pytest.raises(ParameterError, match="sample_rate"):
        Engine(load_preset("classical"), rate)


def test_a_signal_that_does_not_exist_is_refused():
    with pytest.raises(ParameterError, match="signal"):
        Engine(load_preset("classical"), signal="midi")


def test_blocks_that_cannot_be_written_are_refused():
    engine = Engine(load_preset("paper"), signal="bridge-force")
    sealed = np.zeros((8, 1))
    sealed.flags.writeable = False
    for out in (np.zeros((8, 1), np.float32), np.zeros((8, 2)), np.zeros((16, 1))[::2], sealed):
        with pytest.raises(ParameterError, match=r"out .* writable C-contiguous float64"):
            engine.process_into(out)
    assert engine.frame == 0

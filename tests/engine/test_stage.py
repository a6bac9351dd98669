"""The stage: what acts is journaled and can be replayed bit for bit; floods, cut cables and full scale are survived."""


import numpy as np
import pytest

from ukrt.engine import layout as instance_at
from ukrt.engine import stage_layout as at
from ukrt.engine.attached import Attached
from ukrt.engine.callback_type import CALLBACK
from ukrt.engine.engine import Engine
from ukrt.engine.instance import Instance
from ukrt.engine.kernels.card import KNEE, limiter_gain
from ukrt.errors import ParameterError, UkrtError
from ukrt.model.presets import load_preset

NOTES = (40, 45, 50, 55, 59, 64, 67, 52, 71, 48)


def live(preset="classical", **options):
    engine = Engine(load_preset(preset), 48000.0, shared=True, **options)
    engine.output_gain = 0.3
    engine.shed_budget = 0.0  # here shedding is asked for, so that no run depends on how busy the machine is
    return engine


def replayed(entries, load, frames, settings, block):
    """A fresh engine's samples for a card, from the journal of another."""
    engine = live()
    engine.message_cap = 0
    engine.apply(settings)
    parts = []
    for frame, word in [*entries, (frames, None)]:
        if word is None or word >> at.KIND_SHIFT == at.KIND_SWAP or word == at.KIND_RESET << at.KIND_SHIFT:
            while engine.frame < frame:
                parts.append(engine.process_card(min(block, frame - engine.frame)))
        if word is None:
            break
        if word >> at.KIND_SHIFT == at.KIND_SWAP:
            number = word & at.VALUE_MASK
            load(engine, number)
            engine.swap(frame)
        elif word >> at.KIND_SHIFT == at.KIND_MIDI:
            engine.send(frame, word >> 16, word >> 8, word)
        elif word == at.KIND_RESET << at.KIND_SHIFT:
            assert engine.recover(torn=True)
        else:
            engine.send_event(frame, word >> at.KIND_SHIFT, word & at.VALUE_MASK)
    engine.close()
    return np.concatenate(parts)


@pytest.mark.parametrize("block", [64, 333, 4096])
def test_a_journal_replays_bit_for_bit_whatever_the_blocks(block):
    """Random messages at odd times, random blocks, a limiter at work, something that is no number, a torn host."""
    random = np.random.default_rng(7)
    engine = live()
    engine.output_gain = 3.0
    settings, parts, down = engine.settings(), [], []
    for step in range(120):
        for _ in range(random.integers(0, 4)):
            kind = random.integers(0, 5)
            if kind < 3:
                down.append(int(random.choice(NOTES)))
                engine.send(at.AT_ONCE, 0x90, down[-1], int(random.integers(60, 128)))
            elif kind == 3 and down:
                engine.send(engine.frame + int(random.integers(0, 700)), 0x80, down.pop(0), 0)
            else:
                engine.send(at.AT_ONCE, 0xE0, 0, int(random.integers(40, 90)))
        if step in (10, 60, 90):
            engine.send_event(at.AT_ONCE, at.KIND_SHED, 1 + step // 40)
        if step == 40:
            engine.send_event(at.AT_ONCE, at.KIND_SHED, 0)
        if step == 50:
            engine._d[instance_at.STATE + 5] = np.nan
        if step == 80:  # a host ended within the callback: frames that no card has got, and the limiter not seen
            engine.process(100)
            parts.append(np.zeros((100, 2), np.float32))
            engine._si[at.G_BUSY] = 1
            assert engine.recover() and not engine.recover()
        parts.append(engine.process_card(int(random.choice([1, 10, 17, 64, 256, 1024, 1536, 2027]))))
    played, (_, entries, lost) = np.concatenate(parts), engine.journal(0)
    counts = engine.counters()
    assert counts["nonfinite_resets"] == 1 and counts["limited_samples"] > 100 and counts["resets"] == 1 and lost == 0
    assert np.abs(played).max() > 0.5
    again = replayed(entries.tolist(), None, len(played), settings, block)
    _, ring, _ = engine.recorded(0)
    assert np.array_equal(ring, played)
    torn = next(frame for frame, word in entries.tolist() if word == at.KIND_RESET << at.KIND_SHIFT)
    assert not played[torn - 100 : torn].any()
    again[torn - 100 : torn] = 0.0  # computed, but never played
    assert np.array_equal(played.view(np.int32), again.view(np.int32))
    engine.close()


def test_a_change_of_guitar_replays_bit_for_bit():
    names, gains = {1: "drop-d", 2: "paper"}, {1: 0.2, 2: 0.4}

    def load(engine, number):
        engine.load(Instance(load_preset(names[number]), 48000.0, shared=True), gains[number])

    engine, parts = live(), []
    settings = engine.settings()
    for step in range(60):
        if step % 7 == 0:
            engine.send(at.AT_ONCE, 0x90, NOTES[step % 10], 100)
        if step in (10, 30, 50):
            engine.send_event(at.AT_ONCE, at.KIND_SHED, {10: 2, 30: 3, 50: 0}[step])
        if step in (20, 40):
            load(engine, step // 20)
            assert engine.swap() == step // 20
            assert engine.swapping
            with pytest.raises(UkrtError, match="still being carried out"):
                engine.load(engine.instance)
        parts.append(engine.process_card(331))
    played, (_, entries, _) = np.concatenate(parts), engine.journal(0)
    assert engine.guitar.name == load_preset("paper").name and engine.counters()["swaps"] == 2
    again = replayed(entries.tolist(), load, len(played), settings, 777)
    assert np.array_equal(played.view(np.int32), again.view(np.int32))
    engine.close()


def test_only_instances_of_the_same_signal_may_take_over():
    engine = live()
    with pytest.raises(ParameterError, match="pressure in 2 channels"):
        engine.load(Instance(load_preset("classical"), 48000.0, "bridge-force"))
    with pytest.raises(UkrtError, match="no other guitar"):
        engine.swap()
    engine.close()


def test_the_limiter_never_exceeds_full_scale_and_touches_nothing_below_its_knee():
    """Continuous with slope 1 at the knee, rising, below 1 at any level; a channel's share stays as it was."""
    envelopes = np.concatenate([np.linspace(1e-3, 4.0, 4001), [1e3, 1e6, 1e12]])
    out = np.array([limiter_gain(e) * e for e in envelopes])
    assert np.array_equal(out[envelopes <= KNEE], envelopes[envelopes <= KNEE])
    assert (np.diff(out[:-3]) > 0.0).all() and out.max() <= 1.0
    step = 1e-6
    assert (limiter_gain(KNEE + step) * (KNEE + step) - KNEE) / step == pytest.approx(1.0, abs=1e-4)


def test_what_a_card_gets_stays_below_full_scale_at_any_gain():
    quiet, loud = live(), live()
    quiet.output_gain = 0.02
    loud.output_gain = 200.0
    for engine in (quiet, loud):
        for note in NOTES[:6]:
            engine.send(0, 0x90, note, 127)
    raw, limited = quiet.process_card(9600).astype(float) * (200.0 / 0.02), loud.process_card(9600)
    counts = loud.counters()
    assert np.abs(raw).max() > 10.0 and np.abs(limited).max() <= 1.0
    assert counts["clipped_samples"] == 0 and counts["limited_samples"] > 1000 and counts["limiter_db"] < -20.0
    heard = np.abs(raw).min(axis=1) > 1e-3
    left_over_right = limited[heard, 0].astype(float) / limited[heard, 1]
    assert np.allclose(left_over_right, raw[heard, 0] / raw[heard, 1], rtol=1e-4)
    assert quiet.counters()["limited_samples"] == 0
    loud.limiter = False
    loud.send(at.AT_ONCE, 0x90, 40, 127)
    assert np.abs(loud.process_card(9600)).max() == 1.0 and loud.counters()["clipped_samples"] > 0
    quiet.close(), loud.close()


def test_lanes_are_merged_by_frame():
    engine = live()
    for k, lane in enumerate((2, 0, 1, 0, 2)):
        engine.send(100 + 10 * (k // 2), 0xB0 | lane, 20 + k, k, lane)
    engine.process_card(256)
    frames, words = engine.journal(0)[1].T
    assert frames.tolist() == [100, 100, 110, 110, 120]
    assert [(w >> 16) & 0x0F for w in words.tolist()] == [0, 2, 0, 1, 2]
    assert engine.counters()["late_messages"] == 0
    engine.close()


def test_a_burst_is_spread_in_order_and_nothing_is_lost():
    engine = live()
    for k in range(2000):
        assert engine.send(at.AT_ONCE if k else 0, 0x90 if k % 2 == 0 else 0x80, 40 + k % 30 // 2, 80)
    for _ in range(64):
        engine.process_card(64)
    frames = engine.journal(0)[1][:, 0]
    chunks = np.bincount(frames // 64)
    assert len(frames) == 2000 and chunks.max() <= engine.message_cap and chunks[:31].min() == engine.message_cap
    counts = engine.counters()
    assert counts["midi_received"] == 2000 and counts["late_messages"] == 0 and counts["midi_dropped"] == 0
    assert counts["notes_on"] == 1000
    engine.close()


def test_silence_after_active_sensing_ends_the_notes():
    engine = live()
    engine.send(at.AT_ONCE, 0xFE, lane=at.LANE_JACK)
    engine.send(at.AT_ONCE, 0x90, 64, 100, lane=at.LANE_JACK)
    engine.send(at.AT_ONCE, 0xB0, 66, 127, lane=at.LANE_JACK)  # the sostenuto pedal goes up as well
    for _ in range(10):
        engine.process_card(4800)
        engine.send(at.AT_ONCE, 0xFE, lane=at.LANE_JACK)
    assert engine.counters()["sensing_timeouts"] == 0 and engine.note_log()[0]["end_s"] is None
    engine.process_card(24000)
    assert engine.counters()["sensing_timeouts"] == 1
    end = engine.note_log()[0]["end_s"]
    assert end == pytest.approx(1.0 - 0.1 + at.SENSING_SECONDS, abs=0.11)
    engine.process_card(48000)
    assert engine.counters()["sensing_timeouts"] == 1
    engine.close()


def test_the_ring_tells_what_it_has_lost():
    engine = live()
    engine.send(0, 0x90, 64, 100)
    kept = [engine.process_card(8192) for _ in range(at.RING_FRAMES // 8192 + 2)]
    played = np.concatenate(kept)
    following, samples, lost = engine.recorded(0)
    assert following == len(played) and lost + len(samples) == len(played)
    assert 2 * 8192 <= lost <= 2 * 8192 + at.MAX_PIECE
    assert np.array_equal(samples, played[lost:])
    assert engine.recorded(following)[1:] == (pytest.approx(np.zeros((0, 2))), 0)
    engine.close()


def test_stamps_tell_when_blocks_began():
    import time

    engine = live()
    before = time.monotonic_ns()
    engine.process_card(64)
    engine.process_card(64)
    frame, now = engine.stamp()
    assert frame == 64 and (now == 0 or before < now < time.monotonic_ns())
    engine.close()


def test_another_view_of_the_memory_goes_on_where_the_first_stopped():
    """As another process does it: attach, compute, detach; the sound is as if nothing had happened."""
    one, other = live(), live()
    for engine in (one, other):
        engine.send(0, 0x90, 52, 110)
        engine.send(300, 0x90, 64, 90)
    expected = one.process_card(4096)
    first = other.process_card(1000)
    view, rest = Attached(other.manifest()), np.zeros((3096, 2), np.float32)
    assert view.frame == 1000
    assert CALLBACK(view.callback_address)(None, rest.ctypes.data, 3096, None, 0, view.userdata_address) == 0
    assert np.array_equal(np.concatenate([first, rest]), expected)
    view.close()
    assert other.frame == 4096
    one.close(), other.close()

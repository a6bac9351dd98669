"""What a card of one or of many channels gets, against what the engine gives on two."""

import numpy as np
import pytest

from ukrt.drivers.sound.spread import _SCRATCH_FRAMES, Spread
from ukrt.engine.callback_type import CALLBACK
from ukrt.engine.engine import Engine
from ukrt.engine.stage_layout import UNDERFLOW
from ukrt.model.presets import load_preset

GUITAR = load_preset("paper")


def make_engine(**options):
    engine = Engine(GUITAR, shared=True, **options)
    engine.output_gain, engine.shed_budget = engine.instance.preset_gain, 0.0
    engine.send(100, 0x90, 64, 100)
    return engine


def hear(engine, channels, blocks, flags=0):
    """What a card of ``channels`` channels gets (ndarray (frames, channels) float32), and the last return value."""
    card, heard, code = Spread(engine, channels), [], 0
    call = CALLBACK(card.callback_address)
    for n in blocks:
        out = np.full((n, channels), np.nan, np.float32)
        code = call(None, out.ctypes.data, n, None, flags, card.userdata_address)
        heard.append(out)
    return np.concatenate(heard), code


BLOCKS = [64, 17, 1, 4096, _SCRATCH_FRAMES, _SCRATCH_FRAMES + 1, 3 * _SCRATCH_FRAMES + 5]


@pytest.mark.parametrize("channels", [1, 2, 3, 8])
def test_left_and_right_on_any_number_of_channels(channels):
    stereo, engine = make_engine(), make_engine()
    expected = np.concatenate([stereo.process_card(n) for n in BLOCKS])
    assert np.abs(expected[:, 0] - expected[:, 1]).max() > 0.001
    heard, code = hear(engine, channels, BLOCKS)
    assert code == 0 and engine.frame == stereo.frame == len(heard)
    if channels == 1:
        assert np.array_equal(heard[:, 0], np.float32(0.5) * (expected[:, 0] + expected[:, 1]))
    else:
        assert np.array_equal(heard[:, :2], expected) and not heard[:, 2:].any()
    stereo.close()
    engine.close()


def test_one_channel_goes_to_both_sides():
    mono, engine = make_engine(signal="bridge-force"), make_engine(signal="bridge-force")
    expected = mono.process_card(4800)
    heard, _ = hear(engine, 4, [4800])
    assert np.abs(expected).max() > 0.001
    assert np.array_equal(heard[:, :2], np.repeat(expected, 2, axis=1)) and not heard[:, 2:].any()
    mono.close()
    engine.close()


def test_flags_count_once_and_a_closed_engine_ends_the_stream():
    engine = make_engine()
    assert hear(engine, 1, [2 * _SCRATCH_FRAMES], UNDERFLOW)[1] == 0
    assert engine.counters()["underflows"] == 1
    card = Spread(engine, 1)
    engine._host.close()  # as `Engine.close` begins; its memory must outlive this call
    out = np.zeros((64, 1), np.float32)
    assert CALLBACK(card.callback_address)(None, out.ctypes.data, 64, None, 0, card.userdata_address) == 2
    engine.close()

"""Tunings by MIDI: RPNs and SysEx built byte by byte; what the strings then sound is fret and tension, in cents."""

import math
import random

import numpy as np
import pytest
from engine import sysex
from player_bench import Bench

from ukrt.engine import player_layout as at
from ukrt.engine.player_tables import make_player_tables

FAR = 20_000  # frames by which everything asked for has happened


def send(bench, frame, whole, channel_messages=()):
    """A SysEx at a frame; channel messages may come between its pieces."""
    for piece in sysex.messages(whole):
        bench.send(frame, *piece)
        for message in channel_messages:
            bench.send(frame, *message)


def rpn(bench, frame, number, msb, lsb=None, channel=0):
    for controller, value in ((101, 0), (100, number), (6, msb), (38, lsb)):
        if value is not None:
            bench.cc(frame, controller, value, channel)


def sounding(bench):
    """Key -> cents above MIDI note 0 of every note that sounds, as fret and tension have it."""
    bench.run(bench.frame + FAR)
    found = {}
    for s, (key, _, fret) in bench.held().items():
        found[key] = 100.0 * (bench.open[s] + fret) + 600.0 * math.log2(bench.strings[s].tension)
    return found


def frets(bench):
    return {key: fret for key, _, fret in bench.held().values()}


def pitch_of(bench, frame, key, channel=0):
    """Play one note, say what it sounds, end it."""
    bench.on(frame, key, channel=channel)
    heard = sounding(bench)[key]
    bench.off(bench.frame, key, channel=channel)
    bench.run(bench.frame + FAR)
    return heard


def test_fine_tuning_of_a_channel_in_its_14_bits():
    bench = Bench()
    bench.on(0, 60, channel=2)
    values = ((0, 0, -100.0), (64, 0, 0.0), (127, 127, 8191 / 81.92), (96, 0, 50.0), (64, 64, 64 / 81.92))
    for msb, lsb, cents in values:
        rpn(bench, bench.frame, 1, msb, lsb, channel=2)
        assert sounding(bench)[60] == pytest.approx(6000.0 + cents, abs=1e-9)
    bench.cc(bench.frame, 97, 0, channel=2)
    assert sounding(bench)[60] == pytest.approx(6000.0 + 63 / 81.92, abs=1e-9)
    bench.on(bench.frame, 64, channel=3)
    assert sounding(bench)[64] == 6400.0
    bench.bend(bench.frame, 4096, channel=2)  # adds to a bend
    assert sounding(bench)[60] == pytest.approx(6100.0 + 63 / 81.92, abs=1e-9)
    assert bench.counters["rpn_ignored"] == 0


def test_coarse_tuning_takes_other_frets_for_notes_to_come():
    bench = Bench()
    bench.on(0, 60)
    rpn(bench, 10, 2, 64 + 3, 99)  # the least significant byte means nothing
    assert sounding(bench)[60] == 6000.0
    assert pitch_of(bench, bench.frame, 62) == 6500.0
    for step in (96, 97, 97):
        bench.cc(bench.frame, step, 0)
    assert pitch_of(bench, bench.frame, 64) == 6600.0
    bench.off(bench.frame, 60)
    assert bench.held() == {}
    rpn(bench, bench.frame, 2, 127)
    assert pitch_of(bench, bench.frame + FAR, 100) % 1200.0 == (100 + 63) * 100.0 % 1200.0
    assert bench.counters["notes_folded"] == 1 and bench.counters["notes_off_unmatched"] == 0


def test_the_depth_of_vibrato_follows_rpn_5():
    """The extremes of the tension's swing are the depth that semitones and 1/128 semitones say, 0.1 s on."""
    for msb, lsb, cents in ((0, 64, 50.0), (2, 0, 200.0), (0, 0, 0.0)):
        bench = Bench(tick=True)
        rpn(bench, 0, 5, msb, lsb)
        bench.on(10, 60)
        bench.cc(20, 1, 127)
        ratios = _swing(bench, 96_000)
        assert max(ratios) == pytest.approx(2 ** (cents / 600), rel=0.002 * cents / 50 + 1e-12)
        assert min(ratios) == pytest.approx(2 ** (-cents / 600), rel=0.002 * cents / 50 + 1e-12)
        rpn(bench, bench.frame, 5, 0, 0)
        assert _swing(bench, 96_000)[-1] == 1.0 and bench.i[at.C_DEPTH] == 0


def _swing(bench, frames):
    """Tension ratios asked for in the last half of a stretch of time in which vibrato has its slots."""
    from ukrt.engine.kernels.player_vibrato import follow_vibrato

    seen, end = [1.0], bench.frame + frames
    for frame in range(-(-bench.frame // 64) * 64, end, 64):
        bench.run(frame)
        follow_vibrato(bench.d, bench.i, frame)
        if frame > end - frames // 2:
            seen += [string.tension for string in bench.strings]
    return seen


@pytest.mark.parametrize("device", [0x7F, 0x00, 0x10])
def test_master_tunings_move_the_whole_guitar(device):
    bench = Bench()
    bench.on(0, 60)
    send(bench, 10, sysex.master_fine(8192 + 4096, device))
    assert sounding(bench)[60] == pytest.approx(6050.0, abs=1e-9)
    rested = [string.tension for s, string in enumerate(bench.strings) if s not in bench.held()]
    np.testing.assert_allclose(rested, 2 ** (50 / 600), rtol=1e-12)
    send(bench, bench.frame, sysex.master_coarse(64 - 2, device))
    assert pitch_of(bench, bench.frame, 67) == pytest.approx(6550.0, abs=1e-9)
    bench.off(bench.frame, 60)
    send(bench, bench.frame, sysex.master_fine(0, device))  # while it is being damped
    bench.run(bench.frame + FAR)
    np.testing.assert_allclose([string.tension for string in bench.strings], 2 ** (-100 / 600), rtol=1e-12)


@pytest.mark.parametrize("bank", [None, 0])
def test_single_notes_move_at_once_and_to_any_pitch(bank):
    bench = Bench()
    bench.on(0, 60)
    bench.on(0, 45)
    send(bench, 10, sysex.note_tuning({60: 60.3, 64: 71.75, 45: None, 0: 52.5}, bank=bank))
    step = 100 / 16384
    heard = sounding(bench)
    assert heard[60] == pytest.approx(6030.0, abs=step) and heard[45] == 4500.0
    assert pitch_of(bench, bench.frame, 64) == pytest.approx(7175.0, abs=step)
    assert pitch_of(bench, bench.frame, 0) == pytest.approx(5250.0, abs=step)
    assert bench.counters["sysex_refused"] == bench.counters["sysex_ignored"] == bench.counters["notes_folded"] == 0


def test_a_note_that_sounds_moves_an_octave_at_most_and_says_so():
    bench = Bench()
    bench.on(0, 60)
    for target, heard in ((71.9, 7190.0), (73.0, 7200.0), (40.0, 4800.0)):
        send(bench, bench.frame, sysex.note_tuning({60: target}))
        assert sounding(bench)[60] == pytest.approx(heard, abs=100 / 16384)
    assert bench.counters["bends_limited"] == 2


def test_a_note_far_from_its_key_is_fretted_at_the_nearest_semitone():
    bench = Bench()
    for target, fret_pitch in ((63.2, 63), (62.6, 63), (62.4, 62), (60.5, 60), (59.49, 59)):
        send(bench, bench.frame, sysex.note_tuning({60: target}))
        bench.on(bench.frame, 60)
        heard = sounding(bench)[60]
        s = next(iter(bench.held()))
        assert heard == pytest.approx(100 * target, abs=100 / 16384)
        assert bench.open[s] + frets(bench)[60] == fret_pitch
        bench.off(bench.frame, 60)
        bench.run(bench.frame + FAR)


def test_non_real_time_tunings_wait_for_notes_to_come():
    bench = Bench()
    bench.on(0, 60)
    send(bench, 10, sysex.note_tuning({60: 60.5}, bank=0, real_time=False))
    send(bench, 10, sysex.scale_tuning([10] * 12, real_time=False))
    assert sounding(bench)[60] == 6000.0
    bench.bend(bench.frame, 4096)  # bends go on from what the note was tuned to
    assert sounding(bench)[60] == pytest.approx(6100.0, abs=1e-9)
    bench.bend(bench.frame, 0)
    bench.on(bench.frame, 60)
    assert sounding(bench)[60] == pytest.approx(6060.0, abs=1e-9)


@pytest.mark.parametrize("real_time", [True, False])
def test_scales_of_an_octave_for_the_channels_of_the_bitmap(real_time):
    """Quarter-comma meantone in whole cents for some channels, in steps of 100/8192 cents for others."""
    meantone = [10, -14, 3, 21, -3, 14, -10, 7, -17, 0, 17, -7]
    whole, fine = [0, 6, 7, 14, 15], [1, 8, 13]
    bench = Bench()
    send(bench, 0, sysex.scale_tuning(meantone, whole, real_time=real_time))
    steps = [8192 + round(81.92 * 0.37 * cents) for cents in meantone]
    send(bench, 0, sysex.fine_scale_tuning(steps, fine, real_time=real_time))
    for channel in (c for c in range(16) if c != 9):
        for key in (64, 67, 70, 73):
            expected = meantone[key % 12] if channel in whole else 0.0
            expected = (steps[key % 12] - 8192) / 81.92 if channel in fine else expected
            assert pitch_of(bench, bench.frame, key, channel) == pytest.approx(100 * key + expected, abs=1e-9)


def test_a_slur_to_a_key_with_another_offset_takes_its_tension():
    bench = Bench()
    send(bench, 0, sysex.note_tuning({62: 62.3}))
    bench.cc(0, 68, 127)
    bench.on(10, 60)
    bench.on(5000, 62)
    assert bench.log[1]["articulation"] == "hammer-on"
    assert sounding(bench)[62] == pytest.approx(6230.0, abs=0.01)
    bench.off(bench.frame, 60)
    bench.on(bench.frame, 60)
    assert bench.log[2]["articulation"] == "pull-off" and sounding(bench)[60] == pytest.approx(6000.0, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_any_tunings_in_any_order(seed):
    """Every note that begins sounds what a plain model of the specification says, in some octave; the tension takes no
    more than half a semitone of it beside channel's and master's fine tuning."""
    rng = random.Random(seed)
    bench, notes, scale, coarse, fine = Bench(), {}, {}, {}, {}
    master_fine = master_coarse = 0.0
    for _ in range(150):
        kind, frame = rng.randrange(6), bench.frame
        if kind == 0:
            change = {rng.randrange(128): rng.choice([None, rng.uniform(0, 127)]) for _ in range(rng.randrange(5))}
            send(bench, frame, sysex.note_tuning(change, bank=0, real_time=rng.random() < 0.5))
            notes.update({key: round(to * 16384) / 163.84 for key, to in change.items() if to is not None})
        elif kind == 1:
            channels, cents = rng.sample(range(16), 6), [rng.randrange(-64, 64) for _ in range(12)]
            send(bench, frame, sysex.scale_tuning(cents, channels), [(0xB0, 1, 0)])
            scale.update(dict.fromkeys(channels, cents))
        elif kind == 2:
            channel, coarse_value, fine_value = rng.randrange(3), rng.randrange(128), rng.randrange(16384)
            rpn(bench, frame, 2, coarse_value, channel=channel)
            rpn(bench, frame, 1, fine_value >> 7, fine_value & 127, channel=channel)
            coarse[channel], fine[channel] = 100 * (coarse_value - 64), (fine_value - 8192) / 81.92
        elif kind == 3:
            coarse_value, fine_value = rng.randrange(40, 90), rng.randrange(16384)
            send(bench, frame, sysex.master_coarse(coarse_value))
            send(bench, frame, sysex.master_fine(fine_value))
            master_coarse, master_fine = 100 * (coarse_value - 64), (fine_value - 8192) / 81.92
        else:
            key, channel = rng.randrange(128), rng.randrange(3)
            bench.on(frame, key, channel=channel)
            heard, s = sounding(bench)[key], next(iter(bench.held()))
            tuned = notes.get(key, 100.0 * key) + scale.get(channel, [0] * 12)[key % 12]
            bend = fine.get(channel, 0.0) + master_fine
            meant = tuned + coarse.get(channel, 0) + master_coarse + bend
            away = (heard - meant + 600.0) % 1200.0 - 600.0
            beyond_keys = tuned < 0.0 or tuned > 12700.0
            by_tension = 600.0 * math.log2(bench.strings[s].tension) - bend
            assert beyond_keys or (abs(away) < 1e-6 and abs(by_tension) <= 50.0 + 1e-6)
            bench.off(bench.frame, key, channel=channel)
            bench.run(bench.frame + FAR)
            assert bench.held() == {}


def test_on_another_scale_tunings_find_its_frets():
    """19 equal steps: frequencies of the standard are absolute, so the nearest of the guitar's own keys is fingered."""
    from dataclasses import replace
    from types import SimpleNamespace

    from ukrt.model.fingerboard import key_pitches
    from ukrt.model.parameters import Scale

    bench = Bench()
    scale = Scale(name="19", cents=tuple(1200.0 * n / 19 for n in range(1, 20)))
    guitar = replace(bench.guitar, tuning=replace(bench.guitar.tuning, scale=scale))
    make_player_tables(guitar, SimpleNamespace(places=bench.places), 48000.0, bench.d, bench.i)
    pitches = key_pitches(guitar.tuning)
    send(bench, 0, sysex.note_tuning({60: 60.0}))
    bench.on(10, 60)
    bench.run(FAR)
    (s,) = bench.held()
    played = int(bench.i[at.S_PITCH + s])
    assert played == np.argmin(np.abs(pitches - 6000.0))
    assert pitches[played] + 600 * math.log2(bench.strings[s].tension) == pytest.approx(6000.0, abs=1e-3)


def test_what_means_nothing_here_is_counted():
    bench = Bench()
    ignored = [
        sysex.exclusive(0x7E, 0x7F, 0x06, 0x01),  # identity request
        sysex.exclusive(0x7E, 0x7F, 0x08, 0x00, 0x00),  # tuning dump request
        sysex.exclusive(0x7E, 0x7F, 0x08, 0x01, *[0] * 404),  # and its reply
        sysex.exclusive(0x7F, 0x7F, 0x04, 0x02, 0x00, 0x40),  # master balance
        sysex.note_tuning({60: 61.0}, program=1),
        sysex.note_tuning({60: 61.0}, bank=3),
        sysex.exclusive(0x43, 0x10, 0x4C, 0x00),  # a maker's own
        sysex.exclusive(0x7D),
    ]
    whole = sysex.note_tuning({60: 61.0, 62: 64.0})
    refused = [whole[:-2] + b"\xf7", whole[:-1] + b"\x01\xf7", sysex.master_volume(5)[:-2] + b"\xf7"]
    refused += [sysex.scale_tuning([1] * 12)[:-2] + b"\xf7", sysex.general_midi(1)[:-1] + b"\x01\xf7"]
    refused += [sysex.exclusive(0x7F, 0x7F, 0x04), sysex.exclusive(0x7F, *[1] * 600), sysex.exclusive(0x7F)]
    bench.on(0, 60)
    for message in ignored + refused:
        send(bench, 10, message)
    bench.send(10, 0xF7, 1, 1)  # an end of what has not begun
    assert bench.counters["sysex_ignored"] == len(ignored)
    assert bench.counters["sysex_refused"] == len(refused) + 1
    assert sounding(bench) == {60: 6000.0} and pitch_of(bench, bench.frame, 62) == 6200.0


def test_a_message_that_has_lost_any_piece_never_acts():
    for whole in (sysex.note_tuning({60: 61.0, 61: 60.2}), sysex.master_fine(9000), sysex.scale_tuning(range(12))):
        parts = sysex.messages(whole)
        for lost in range(len(parts)):
            bench = Bench()
            before = bench.i[at.I_MASTER_FINE : at.I_SYSEX].copy()
            for piece in parts[:lost] + parts[lost + 1 :]:
                bench.send(0, *piece)
            changed = bench.i[at.I_MASTER_FINE : at.I_SYSEX] != before
            changed[at.I_SYSEX_LENGTH - at.I_MASTER_FINE] = False
            assert not changed.any()
            send(bench, 10, sysex.master_fine(8192))
            told = bench.counters["sysex_refused"] + bench.counters["sysex_ignored"]
            assert bench.i[at.I_SYSEX_LENGTH] == 0 and told == (lost < len(parts) - 1)


@pytest.mark.parametrize("message", [b"\xff", *(sysex.general_midi(what) for what in (1, 2, 3))], ids=str)
def test_resets_bring_back_power_up(message):
    bench = Bench()
    send(bench, 0, sysex.note_tuning({60: 61.5}))
    send(bench, 0, sysex.scale_tuning([20] * 12))
    send(bench, 0, sysex.master_fine(0))
    send(bench, 0, sysex.master_coarse(70))
    send(bench, 0, sysex.master_volume(3))
    for number, value in ((1, 5), (2, 70), (5, 3)):
        rpn(bench, 0, number, value, value)
    for controller in (7, 11, 64, 66, 67):
        bench.cc(0, controller, 77)
    bench.on(10, 60)
    bench.run(5000)
    if len(message) == 1:
        bench.send(5000, 0xFF)
    else:
        send(bench, 5000, message)
    assert bench.held() == {}
    bench.run(5000 + FAR)
    assert all(string.tension == 1.0 for string in bench.strings)
    fresh = Bench()
    first, last = at.I_CHANNEL, at.I_SYSEX
    same = bench.i[first:last] == fresh.i[first:last]
    same[at.I_LEVEL_LEFT - first] = True  # on its way to full volume
    assert same.all() and bench.d[at.D_LEVEL_GOAL] == 1.0
    assert bench.counters["sysex_refused"] == bench.counters["sysex_ignored"] == 0
    bench.on(bench.frame, 60)
    assert sounding(bench) == {60: 6000.0}

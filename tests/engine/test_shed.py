"""Shedding: what each level leaves out, how little of it is heard, that it comes back, and that no note is lost."""

import numpy as np
import pytest
from engine.bench import classical, fret_place, largest_growth, on_bench, run
from engine.random_guitar import even_in_log, random_instance
from engine.shedding import convolver, dense, play, random_levels, sleepers

from ukrt.engine import gestures
from ukrt.engine import layout as at
from ukrt.engine.kernels.hands import perform
from ukrt.engine.kernels.ports import invert_ports, port_motion
from ukrt.engine.kernels.ramps import begin_sample
from ukrt.engine.kernels.shed import EVERY, set_shed, tend_shed
from ukrt.engine.kernels.sleep import bridge_motion, hush_string, sleep_string, wake_string
from ukrt.model.presets import load_preset

HIGH_LATE = (40000, 0x90, 64, 110)
HIGH = (0, 0x90, 64, 110)  # E4, the highest string, open


def _peak_db(samples, reference):
    return 20.0 * np.log10(np.abs(samples).max() / np.abs(reference).max() + 1e-99)


def _jump(force, where):
    """Largest third difference: three times the height of a step, next to nothing of what swings."""
    return np.abs(np.diff(force[:, 0], 3, prepend=[0.0] * 3))[where].max()


def _string(i, s, number):
    return int(i[at.STRING_I + s * at.STRING_I_SIZE + number])


def test_block_size_changes_no_bit_while_levels_change():
    """Random levels at random frames and dense playing: the same bits for any cut into blocks."""
    messages, levels = [*dense(24000), (30000, 0xB0, 123, 0), HIGH_LATE], random_levels(96000, 5)
    whole, _, asleep = play(messages, 96000, levels, block=8192)
    assert np.abs(whole).max() > 0.01 and max(n for _, n in asleep) > 0
    assert len(set(levels.values())) == 4
    for block in (61, 256):
        assert np.array_equal(play(messages, 96000, levels, block=block)[0], whole)


def test_no_note_is_lost_in_a_burst_of_overload():
    """The player does the same whatever is shed: every note, with its string, fret and times, is in the log."""
    messages = [*dense(48000, seed=8), (60000, 0xB0, 123, 0), (80000, 0x90, 64, 110)]
    _, calm, _ = play(messages, 144000)
    samples, busy, asleep = play(messages, 144000, {6000: 1, 9000: 2, 12000: 3, 110000: 2, 120000: 1, 130000: 0})
    assert np.isfinite(samples).all() and max(n for _, n in asleep) > 0
    assert busy.note_log() == calm.note_log()
    for name in ("notes_on", "notes_played", "gestures_executed", "gestures_dropped", "nonfinite_resets"):
        assert busy.counters()[name] == calm.counters()[name]
    assert sleepers(busy._i) == [at.AWAKE] * 6


def test_strings_that_sleep_at_the_first_level_are_not_missed():
    """Idle strings held by the damper fall silent between two chords, sleep, and wake for the next: under -80 dB."""
    guitar = load_preset("classical", {"playing.idle_strings": "damped"})
    chord = [(0, 0x90, 40, 110), (0, 0x90, 47, 110), (60000, 0x80, 40, 0), (60000, 0x80, 47, 0)]
    messages = [*chord, (130000, 0x90, 64, 110)]
    expected = play(messages, 170000, guitar=guitar)[0]
    heard, _, asleep = play(messages, 170000, {8192: 1}, guitar=guitar)
    assert max(n for _, n in asleep) == 6
    assert not np.array_equal(heard, expected)
    assert _peak_db(heard - expected, expected) < -80.0


def test_strings_that_only_ring_along_sleep_at_the_higher_levels():
    """Under one melody string the others sleep; the bridge's force hardly changes."""
    expected = play([HIGH], 140000, signal="bridge-force")[0]
    for level, least, limit in ((2, 1, -55.0), (3, 3, -35.0)):
        heard, engine, _ = play([HIGH], 140000, {20480: level}, signal="bridge-force")
        assert sleepers(engine._i).count(at.ASLEEP) >= least
        assert _peak_db(heard - expected, expected) < limit


@pytest.mark.parametrize("how", ["level", "pluck", "press", "damp"])
def test_waking_makes_no_click(how):
    """A string wakes at frame 60000: in the first samples the bridge hears nothing but the hand."""
    levels = {20480: 3}
    sleeping, engine, _ = play([HIGH], 60064, levels, signal="bridge-force")
    assert sleepers(engine._i)[3] == at.ASLEEP
    _, engine, _ = play([HIGH], 60000, levels, signal="bridge-force")
    d, i = engine._d, engine._i
    if how == "level":
        set_shed(d, i, engine._v, engine._vi, 0)
    elif how == "pluck":
        perform(d, i, gestures.PLUCK, 3, 0.85, 1e-6, 0.0, 480.0)
    elif how == "press":
        perform(d, i, gestures.PRESS, 3, 0.1, 240.0, 0.0, 0.0)
    else:
        perform(d, i, gestures.DAMP, 3, 1.0, 384.0, 0.0, 0.0)
    woken = engine.process(64)
    assert sleepers(i)[3] == at.AWAKE
    assert _jump(woken - sleeping[-64:], slice(0, 8)) < 1e-3 * np.abs(sleeping[-4800:]).max()


def test_falling_asleep_makes_no_click():
    """Neither when the hand is laid on the strings nor when they leave the sum does the force jump."""
    heard, _, asleep = play([HIGH], 40960, {20480: 3}, signal="bridge-force")
    expected = play([HIGH], 40960, signal="bridge-force")[0]
    slept = next(frame for frame, n in asleep if n > 0) - EVERY
    for frame in (20480, slept):
        here = slice(frame - 4, frame + 4)
        assert _jump(heard - expected, here) < 1e-3 * np.abs(expected[frame : frame + 4096]).max()


def test_a_woken_string_and_its_fingers_stand_where_the_bridge_is():
    guitar = classical()
    d, i = on_bench(guitar)
    for s, fret in ((1, 5), (5, 3)):
        perform(d, i, gestures.PRESS, s, fret_place(guitar.strings[s], fret), 100.0, 0.0, 0.0)
    perform(d, i, gestures.DAMP, 1, 1.0, 100.0, 0.0, 0.0)
    run(d, i, 10, 64)
    perform(d, i, gestures.PLUCK, 5, 0.85, 5.0, 0.4, 200.0)
    i[at.H_SHED] = 2
    sleep_string(d, i, 1)
    assert i[at.H_PORTS] == 4
    run(d, i, 47, 64)
    wake_string(d, i, 1)
    assert i[at.H_PORTS] == 6
    motion = bridge_motion(d, i, 1)
    assert abs(motion[0]) > 1e-7
    assert port_motion(d, i, 1, 0, 0) == pytest.approx(motion, rel=1e-9)
    for j in range(1, 6):
        row = j * at.LANES + 1
        now, before = port_motion(d, i, 1, j, 0)
        assert d[at.FIN_Y + row] == now
        assert d[at.FIN_Y1 + row] == pytest.approx(d[at.FIN_A + row] * now + d[at.FIN_B + row] * before)
    stiff = abs(port_motion(d, i, 1, 1, 0)[0])
    assert stiff < 0.02 * abs(motion[0]), "the fret's contact should hold its place against the bridge"


@pytest.mark.parametrize("seed", range(16))
def test_energy_never_grows_whatever_sleeps(seed):
    """Random legal guitars, random hands, random strings hushed, put to sleep and woken, random levels."""
    rng = np.random.default_rng(1000 + seed)
    guitar, d, i, _ = random_instance(rng)
    v, vi = convolver(np.zeros((1, 2, 2)))
    scale, slept = np.zeros(1), 0
    for _ in range(8):
        for s, string in enumerate(guitar.strings):
            _random_hand(rng, d, i, s, string.length)
        assert largest_growth(d, i, 30, 32, scale) < 1e-9
        set_shed(d, i, v, vi, int(rng.integers(0, 4)))
        for s in range(len(guitar.strings)):
            if i[at.H_SHED] > 0 and rng.random() < 0.5 and not _under_way(i, s):
                hush_string(d, i, s, 1)
                if rng.random() < 0.5:
                    sleep_string(d, i, s)
        slept += sleepers(i).count(at.ASLEEP)
        tend_shed(d, i, 4096)
        run(d, i, 80, 32)  # forces of strings that have just fallen asleep fade
        assert largest_growth(d, i, 30, 32, scale) < 1e-9
    assert slept > 0 and np.isfinite(d[at.BRIDGE : at.BRIDGE + 2 * at.CHUNK]).all()


def _random_hand(rng, d, i, s, length):
    kinds = (gestures.PRESS, gestures.LIFT, gestures.DAMP, gestures.UNDAMP, gestures.TENSION, gestures.MOVE)
    kind, frames = int(rng.choice(kinds)), float(rng.integers(1, 300))
    share = {gestures.PRESS: length, gestures.MOVE: length}.get(kind, 1.0)
    value = float(rng.uniform(0.7, 1.4)) if kind == gestures.TENSION else float(rng.uniform(0.05, 0.9)) * share
    if rng.random() < 0.6:
        perform(d, i, kind, s, value, frames, 0.0, 0.0)
    if rng.random() < 0.5:
        force, angle = even_in_log(rng, 0.1, 100.0), float(rng.uniform(-3.0, 3.0))
        perform(d, i, gestures.PLUCK, s, float(rng.uniform(0.02, 0.98)), force, angle, float(rng.integers(2, 600)))


def _under_way(i, s):
    ramps = (at.SI_PLUCK, at.SI_LAND_LENGTH, at.SI_MOVE_LENGTH, at.SI_LIFT_LENGTH, at.SI_DAMP_LENGTH)
    return any(_string(i, s, number) for number in (*ramps, at.SI_TENSION_LENGTH, at.SI_CHANGED, at.SI_SLEEP))


def test_new_fingers_have_one_contact_and_those_that_are_down_stay():
    guitar = classical()
    d, i = on_bench(guitar)
    v, vi = convolver(np.zeros((1, 2, 2)))
    place = fret_place(guitar.strings[2], 5)
    for s, level, contacts in ((2, 0, 3), (3, 3, 1), (4, 2, 3)):
        set_shed(d, i, v, vi, level)
        perform(d, i, gestures.PRESS, s, place, 100.0, 0.0, 0.0)
        perform(d, i, gestures.DAMP, s, 1.0, 100.0, 0.0, 0.0)
        begin_sample(d, i)
        assert _string(i, s, at.SI_FINGER) == contacts
        ports = d[at.STRING + s * at.STRING_D_SIZE + at.S_PORT_X :][: 1 + contacts + min(contacts, 2)]
        assert ports[1] == place  # the contact that sets the pitch
        assert ports[-1] == pytest.approx(max(guitar.damper.places) * guitar.strings[s].length)
        assert _string(i, s, at.SI_DAMPER) == min(contacts, 2)
    assert [_string(i, s, at.SI_FINGER) for s in (2, 3, 4)] == [3, 1, 3]


def test_one_contact_is_the_one_nearest_the_bridge_wherever_it_stands_in_the_list():
    """The whole finger at level 3 moves as a finger made of that contact alone does, to the bit."""
    places = (0.8, 0.6)
    many = load_preset("classical", {"damper.places": str(list(places))})
    alone = load_preset("classical", {"damper.places": str([max(places)])})
    moved = []
    for guitar, level in ((many, 3), (alone, 0)):
        d, i = on_bench(guitar)
        i[at.H_SHED] = level
        perform(d, i, gestures.PLUCK, 0, 0.85, 5.0, 0.4, 200.0)
        perform(d, i, gestures.DAMP, 0, 1.0, 300.0, 0.0, 0.0)
        run(d, i, 15, 64)
        moved.append(d[at.STATE : at.COEF].copy())
    assert np.abs(moved[0]).max() > 0.0
    assert np.array_equal(*moved)


def test_coming_back_to_level_0_everything_is_as_it_was():
    """Awake strings, the solver's lanes of their real ports, and new fingers with all contacts."""
    _, engine, asleep = play([HIGH, (90000, 0x90, 53, 100)], 100000, {20480: 3, 70000: 0})
    assert max(n for _, n in asleep) > 1 and asleep[-1][1] == 0
    d, i = engine._d, engine._i
    lanes = d[at.V : at.V + at.PORTS * at.PORTS * at.LANES].copy()
    for s in range(6):
        invert_ports(d, i, s)
        assert d[at.STRING + s * at.STRING_D_SIZE + at.S_HUSH] == 0.0
    assert np.array_equal(lanes, d[at.V : at.V + at.PORTS * at.PORTS * at.LANES])
    assert max(_string(i, s, at.SI_FINGER) for s in range(6)) == 3

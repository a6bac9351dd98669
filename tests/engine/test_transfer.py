"""A swap of guitars in the middle of playing: what rings goes on, what is held stays held, nothing clicks or sticks."""

from dataclasses import replace

import numpy as np
import pytest
from engine import sysex
from engine.bench import largest_growth, run
from engine.random_guitar import random_instance
from engine.swap_bench import FADE, RATE, counters, crossfade, energy_above, instance, note_log, play, swap
from engine.test_stability import _random_hands

from ukrt.engine import gestures
from ukrt.engine import layout as at
from ukrt.engine import player_layout as player
from ukrt.engine.kernels import convolve_layout as convolver
from ukrt.engine.kernels.energy import string_energy, total_energy
from ukrt.engine.kernels.timeline import timeline_add
from ukrt.engine.kernels.transfer import MOST_ENERGY, transfer_state
from ukrt.model.presets import load_preset

PRESETS = {name: load_preset(name) for name in ("classical", "drop-d", "paper")}
OTHERS = [(old, new) for old in PRESETS for new in PRESETS if old != new]
ON, OFF, CONTROL, BEND = 0x90, 0x80, 0xB0, 0xE0
CHORD = [(100, ON, 40, 100), (200, ON, 52, 90), (300, ON, 57, 90), (400, ON, 67, 110)]
# Around the swap in the moments below: a note damped, one just plucked, a bend, the pedal, a chord, note-offs
BUSY = [
    *CHORD,
    (9000, CONTROL, 64, 127),
    (9500, OFF, 57, 0),
    (10000, BEND, 0, 90),
    (10040, ON, 60, 80),
    (11000, OFF, 60, 0),
    (11500, CONTROL, 64, 0),
    (12000, OFF, 52, 0),
    (15000, BEND, 0, 64),
    (16000, ON, 45, 70),
    (16000, ON, 64, 70),
    (20000, OFF, 40, 0),
    (21000, OFF, 67, 0),
    (22000, OFF, 45, 0),
    (22000, OFF, 64, 0),
]
MOMENTS = [0, 330, 620, 10070, 10250, 11700, 12321, 19200]  # at rest, plucks, landings, bends, damping, ringing


def _few(name, count):
    """A preset without its highest strings."""
    return replace(PRESETS[name], strings=PRESETS[name].strings[:count])


def _idle(name, how):
    return replace(PRESETS[name], playing=replace(PRESETS[name].playing, idle_strings=how))


def _peak_hz(signal, rate, near):
    """Frequency of the strongest partial within a third around ``near`` [Hz], between the bins."""
    spectrum = np.abs(np.fft.rfft(signal * np.hanning(len(signal)), 8 * len(signal)))
    hz = np.fft.rfftfreq(8 * len(signal), 1.0 / rate)
    spectrum[(hz < 0.84 * near) | (hz > 1.19 * near)] = 0.0
    k = int(np.argmax(spectrum))
    low, mid, high = np.log(spectrum[k - 1 : k + 2])
    return (k + 0.5 * (low - high) / (low - 2.0 * mid + high)) * hz[1]


def _cents(one, other):
    return 1200.0 * np.log2(one / other)


@pytest.mark.parametrize("moment", MOMENTS)
def test_the_same_guitar_goes_on_to_the_bit(moment):
    """Force and pressure, counters and notes, whatever is under way; the instance that goes is not disturbed either."""
    whole, old, new = (instance(PRESETS["classical"]) for _ in range(3))
    expected = play(whole, 0, 30000, BUSY)
    before = play(old, 0, moment, BUSY)
    swap(old, new, moment)
    after = play(new, moment, 30000 - moment, BUSY)
    assert np.array_equal(np.concatenate([before, after]), expected)
    assert np.array_equal(play(old, moment, 30000 - moment, BUSY), expected[moment:])
    assert counters(new) == counters(whole) and note_log(new) == note_log(whole)


def _tuned():
    """Messages that leave tunings, volume and pedals behind, and a SysEx whose pieces come at two frames."""
    early = sysex.messages(sysex.note_tuning({40: 40.4, 57: 59.2})) + sysex.messages(sysex.master_fine(9000))
    early += [(CONTROL, 66, 127), (CONTROL, 67, 127), (CONTROL, 101, 0), (CONTROL, 100, 1), (CONTROL, 6, 70)]
    torn = sysex.messages(sysex.scale_tuning(range(-6, 6)))
    late = [(5000, *piece) for piece in torn[:4]] + [(5400, *piece) for piece in torn[4:]]
    fades = [(5000, CONTROL, 7, 30), (7000, CONTROL, 11, 90), (9000, CONTROL, 66, 0)]
    return [*CHORD, *((500, *message) for message in early), (600, OFF, 57, 0), *late, *fades, (8000, ON, 57, 90)]


@pytest.mark.parametrize("moment", [5100, 5400, 7203, 9100])
def test_tunings_volume_and_pedals_go_on_to_the_bit(moment):
    """In the middle of a SysEx, of a move of the volume and while the sostenuto pedal holds."""
    whole, old, new = (instance(PRESETS["classical"]) for _ in range(3))
    expected = play(whole, 0, 12_000, _tuned())
    before = play(old, 0, moment, _tuned())
    swap(old, new, moment)
    after = play(new, moment, 12_000 - moment, _tuned())
    assert np.array_equal(np.concatenate([before, after]), expected)
    assert counters(new) == counters(whole) and note_log(new) == note_log(whole)


def test_tunings_and_volume_on_another_guitar():
    """At another sample rate, with strings that the old one lacked: volume arrives, every idle string is in tune."""
    old = instance(_few("classical", 4))
    new = instance(PRESETS["classical"], 44100.0)
    play(old, 0, 5100, _tuned())
    swap(old, new, 5100)
    play(new, 5100, 9000, _tuned())
    assert new.d[player.D_LEVEL] == new.d[player.D_LEVEL_GOAL] == pytest.approx((30 / 100 * 90 / 127) ** 2)
    fine = (9000 - 8192) / 8192 * 100.0
    idle = [s for s in range(6) if new.i[player.S_STATE + s] == player.IDLE]
    assert {4, 5} & set(idle)
    np.testing.assert_allclose([new.d[player.D_TENSION + s] for s in idle], 2 ** (fine / 600), rtol=1e-12)
    pitches = new.i[[player.I_NOTE_PITCH + key for key in (40, 57)]] / player.TUNING_UNIT
    np.testing.assert_allclose(pitches, [4040.0, 5920.0], atol=100 / 16384)


def test_a_slide_goes_on_to_the_bit_and_elsewhere_sets_out_anew():
    whole, old, same, other = (instance(PRESETS[name]) for name in ("classical", "classical", "classical", "drop-d"))
    for one in (whole, old):
        assert timeline_add(one.d, one.i, 4000, gestures.MOVE, 0, 0.2, 3000.0, 0.0, 0.0, 0.0)
    stopped = [(100, ON, 43, 100)]
    expected = play(whole, 0, 12000, stopped)[5000:]
    play(old, 0, 5000, stopped)
    swap(old, same, 5000)
    swap(old, other, 5000)
    assert np.array_equal(play(same, 5000, 7000), expected)
    play(other, 5000, 7000)
    assert other.d[at.STRING + at.S_FINGER_PLACE] == pytest.approx(0.2, rel=1e-12)
    assert other.i[at.STRING_I + at.SI_MOVE_LENGTH] == 0


def test_radiation_goes_on_where_the_plan_is_the_same_and_begins_at_rest_elsewhere():
    old, same, other = (instance(PRESETS["classical"], n_taps=n) for n in (3000, 3000, 700))
    play(old, 0, 3000, CHORD)
    swap(old, same, 3000)
    swap(old, other, 3000)
    for new, rings in ((same, True), (other, False)):
        state = new.v[new.vi[convolver.STATE_START] : new.vi[convolver.STATE_STOP]]
        assert state.any() == rings


@pytest.mark.parametrize("notes", [CHORD, [(100, ON, 40, 100)], [(100, ON, 43, 100)]], ids=["chord", "open", "stopped"])
@pytest.mark.parametrize("moment", [24000, 24037, 9600])
@pytest.mark.parametrize(("name", "other"), OTHERS)
def test_a_swap_does_not_click(name, other, moment, notes):
    """Above 5 kHz every 1024 samples have at most 5 dB more than without a swap, or less than -54 dB of the whole."""
    whole, old, new = instance(PRESETS[name]), instance(PRESETS[name]), instance(PRESETS[other])
    expected = play(whole, 0, moment + 9600, notes)
    before = play(old, 0, moment, notes)
    swap(old, new, moment)
    after = crossfade(play(old, moment, FADE), play(new, moment, 9600))
    heard = np.concatenate([before, after])[:, 0]
    for start in range(moment - 512, moment + 8000, 256):
        window = slice(start, start + 1024)
        usual, whole_energy = (energy_above(expected[window, 0], hz) for hz in (5000.0, 20.0))
        assert energy_above(heard[window], 5000.0) < max(3.2 * usual, 10**-5.4 * whole_energy)


@pytest.mark.parametrize(("name", "other"), OTHERS)
def test_strings_keep_their_energy(name, other):
    old, new = instance(PRESETS[name]), instance(PRESETS[other])
    play(old, 0, 24000, CHORD)
    swap(old, new, 24000)
    held = [np.array([string_energy(one.d, one.i, s) for s in range(6)]) for one in (old, new)]
    assert held[0].min() > 1e-9
    assert np.abs(held[1] / held[0] - 1.0).max() < 0.05
    assert abs(total_energy(new.d, new.i) / total_energy(old.d, old.i) - 1.0) < 0.03


@pytest.mark.parametrize(("note", "sounds"), [(40, 38), (43, 41)])
def test_a_string_rings_on_at_the_new_guitars_pitch(note, sounds):
    """Open and stopped: the same fret of the string that is tuned down now."""
    old, new, fresh = (instance(PRESETS[name]) for name in ("classical", "drop-d", "drop-d"))
    play(old, 0, 9600, [(100, ON, note, 60)])
    swap(old, new, 9600)
    heard = play(new, 9600, 100000)[4000:, 0]
    plucked = play(fresh, 0, 109600, [(100, ON, sounds, 60)])[13600:, 0]
    near = 440.0 * 2.0 ** ((sounds - 69) / 12.0)
    assert abs(_cents(_peak_hz(heard, RATE, near), _peak_hz(plucked, RATE, near))) < 2.0
    assert note_log(new)[0]["end_s"] is None


@pytest.mark.parametrize("rates", [(48000.0, 96000.0), (96000.0, 44100.0)])
def test_another_sample_rate_keeps_pitch_notes_and_times(rates):
    """A note rings on in tune; one being damped comes to rest when it should have."""
    old, new = (instance(PRESETS["classical"], rate) for rate in rates)
    scale = rates[0] / 48000.0
    now = int(12321 * scale)
    messages = [(int(frame * scale), *message) for frame, *message in [(100, ON, 43, 90), (200, ON, 60, 90)]]
    play(old, 0, now, [*messages, (int(12000 * scale), OFF, 60, 0)])
    lifts = old.i[player.S_LIFT : player.S_LIFT + 6]
    damped = int(np.argmax(lifts))
    due = (lifts[damped] - now) / rates[0]
    swap(old, new, now)
    assert (new.i[player.S_LIFT + damped] - now) / rates[1] == pytest.approx(due, abs=1e-4)
    heard = play(new, now, int(2.0 * rates[1]))[:, 0]
    assert abs(_cents(_peak_hz(heard[len(heard) // 10 :], rates[1], 98.0), 97.999)) < 6.0
    assert new.i[player.S_STATE + damped] == player.IDLE
    assert string_energy(new.d, new.i, damped) < 1e-3 * string_energy(new.d, new.i, 0)


@pytest.mark.parametrize("name", ["drop-d", "paper", "classical"])
@pytest.mark.parametrize("moment", MOMENTS[1:])
def test_every_note_still_ends(name, moment):
    old, new = instance(PRESETS["classical"]), instance(PRESETS[name])
    play(old, 0, moment, BUSY)
    swap(old, new, moment)
    play(new, moment, 72000 - moment, BUSY)
    assert set(new.i[player.S_STATE : player.S_STATE + 6]) == {player.IDLE}
    assert not new.i[player.I_OWED : player.I_OWED + 16 * 128].any()
    assert counters(new)["notes_off_unmatched"] == 0
    assert all(note["end_s"] is not None for note in note_log(new))
    fingers = new.i[at.STRING_I : at.STRING_I + 6 * at.STRING_I_SIZE].reshape(6, -1)[:, [at.SI_FINGER, at.SI_DAMPER]]
    assert not fingers.any()


def test_notes_of_strings_that_are_gone_end_and_their_note_offs_are_owed():
    old, few, more = instance(PRESETS["classical"]), instance(_few("drop-d", 3)), instance(PRESETS["paper"])
    play(old, 0, 9600, CHORD)
    strings = [note["string"] for note in note_log(old)]
    assert max(strings) >= 3 > min(strings)
    swap(old, few, 9600)
    fates = [note["fate"] for note in note_log(few)]
    assert fates == ["silenced" if string >= 3 else "played" for string in strings]
    assert few.i[player.I_OWED : player.I_OWED + 16 * 128].sum() == sum(string >= 3 for string in strings)
    offs = [(9700 + k, OFF, note, 0) for k, (_, _, note, _) in enumerate(CHORD)]
    play(few, 9600, 2400, offs)
    swap(few, more, 12000)
    heard = play(more, 12000, 24000, [(12100, ON, 76, 100)])
    assert counters(more)["notes_off_unmatched"] == 0
    assert note_log(more)[-1]["string"] == 5 and np.abs(heard[:, 0]).max() > 0.1


@pytest.mark.parametrize("how", ["damped", "open"])
def test_strings_without_a_note_idle_as_the_new_guitar_wants(how):
    old, new = instance(_idle("classical", "open" if how == "damped" else "damped")), instance(_idle("paper", how))
    play(old, 0, 9000, [(100, ON, 40, 100), (200, ON, 64, 100), (8000, OFF, 64, 0)])
    swap(old, new, 9000)
    play(new, 9000, 24000)
    dampers = new.i[at.STRING_I : at.STRING_I + 6 * at.STRING_I_SIZE].reshape(6, -1)[:, at.SI_DAMPER]
    assert dampers[0] == 0
    assert (dampers[1:] > 0).all() == (dampers[1:] > 0).any() == (how == "damped")


def _at_random(rng, first, last):
    """Any messages from ``first`` on, and all notes off at the end."""
    messages = []
    for frame in np.sort(rng.integers(first, last, 120)):
        kind = rng.choice([ON, ON, ON, OFF, BEND, CONTROL])
        note = int(rng.integers(36, 84))
        numbers = (64, int(rng.integers(0, 128))) if kind == CONTROL else (note, int(rng.integers(1, 128)))
        messages.append((int(frame), int(kind), *numbers))
    return [*messages, (last, CONTROL, 64, 0), (last, CONTROL, 123, 0)]


@pytest.mark.parametrize("seed", range(4))
def test_ten_seconds_at_random_between_random_presets(seed):
    """Swaps at any moment, rates too: all numbers stay numbers, energy stays what playing gives, all notes end."""
    rng = np.random.default_rng(seed)
    guitars = [*PRESETS.values(), _few("paper", 4), _idle("drop-d", "damped")]
    one, now, last = instance(guitars[0], n_taps=200), 0, 10 * 48000
    messages, largest, swaps = _at_random(rng, 0, last), 0.0, 0
    while now < last:
        n = int(rng.integers(1, 30000))
        largest = max(largest, np.abs(play(one, now, n, messages)[:, 0]).max())
        now += n
        new = instance(guitars[rng.integers(len(guitars))], float(rng.choice([44100.0, 48000.0, 96000.0])), n_taps=200)
        before = total_energy(one.d, one.i)
        swap(one, new, now)
        assert total_energy(new.d, new.i) <= 1.0001 * MOST_ENERGY * before
        one, swaps = new, swaps + 1
    assert swaps > 10 and 1.0 < largest < 1000.0
    play(one, now, 200000, messages if now <= last else [(now, CONTROL, 64, 0), (now, CONTROL, 123, 0)])
    strings = len(one.guitar.strings)
    assert set(one.i[player.S_STATE : player.S_STATE + strings]) == {player.IDLE}
    assert all(note["end_s"] is not None for note in note_log(one))


@pytest.mark.parametrize("seed", range(16))
def test_any_legal_guitar_becomes_any_other(seed):
    """A swap at most doubles the energy; thereafter, landings over, it never grows unforced."""
    rng = np.random.default_rng(1000 + seed)
    guitar, d, i, _ = random_instance(rng)
    convolved, plan = np.zeros(8), np.zeros(convolver.HEADER, np.int64)
    for _ in range(4):
        _random_hands(rng, guitar, d, i)
        run(d, i, int(rng.integers(1, 20)), int(rng.integers(1, 65)))
        before = total_energy(d, i)
        guitar, d1, i1, _ = random_instance(rng)
        i1[player.I_LANDING] = 200
        transfer_state(d, i, convolved, plan, d1, i1, convolved, plan, 1000)
        assert total_energy(d1, i1) <= 1.0001 * MOST_ENERGY * before
        run(d1, i1, 40, 64)
        scale = np.array([max(before, total_energy(d1, i1))])
        assert largest_growth(d1, i1, 40, 32, scale) < 1e-9
        d, i = d1, i1

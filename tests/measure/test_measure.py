"""The measuring tools proven on signals and systems whose poles are known."""

import numpy as np
import pytest

from .kernel_poles import poles_from_records, poles_from_steps
from .poles_from_signal import fit_pole, fit_poles, note_pitch_cents

RATE = 48000.0


def tones(parts, seconds, rate=RATE, noise_db=None, seed=1):
    """Sum of a exp(-d t) cos(2 pi f t + phase) for (f, d, a, phase), white noise relative to the first 0.1 s's rms."""
    t = np.arange(round(seconds * rate)) / rate
    signal = sum(a * np.exp(-d * t) * np.cos(2 * np.pi * f * t + phase) for f, d, a, phase in parts)
    if noise_db is not None:
        rms = np.sqrt(np.mean(signal[: int(0.1 * rate)] ** 2))
        signal = signal + rms * 10 ** (noise_db / 20) * np.random.default_rng(seed).standard_normal(t.size)
    return signal


def note(f1, seconds=4.0, **options):
    """A plucked-string-like note: twelve slightly stretched partials, two body modes."""
    parts = [(f1 * n * (1 + 2e-5 * n * n), 0.6 + 0.25 * n, 1.0 / n, 0.7 * n) for n in range(1, 13)]
    return tones([*parts, (89.4, 8.4, 0.5, 0.3), (182.6, 20.0, 0.8, 1.0)], seconds, **options)


def cents(a, b):
    return 1200.0 * np.log2(a / b)


@pytest.mark.parametrize("f1", [82.4069, 110.0, 146.8324, 329.6276, 987.7666])
@pytest.mark.parametrize("partial", [1, 2, 5])
def test_clean_partials(f1, partial):
    """Every partial of a clean note: 0.002 cents and 0.01 % (in truth far better), from a guess 1 Hz off."""
    truth, loss = f1 * partial * (1 + 2e-5 * partial**2), 0.6 + 0.25 * partial
    frequency, decay = fit_pole(note(f1), RATE, truth + 1.0, 25.0, 0.6, 3.2)
    assert abs(cents(frequency, truth)) < 2e-5
    assert decay == pytest.approx(loss, rel=1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_partial_in_noise(seed):
    """Noise 60 dB below the attack: the partial has decayed too, and is still within 0.02 cents and 0.5 %."""
    signal = note(196.0, noise_db=-60.0, seed=seed)
    frequency, decay = fit_pole(signal, RATE, 195.0, 25.0, 0.6, 3.2)
    assert abs(cents(frequency, 196.0 * (1 + 2e-5))) < 0.02
    assert decay == pytest.approx(0.85, rel=5e-3)


def test_nearby_weaker_partial():
    """A partial 30 Hz away, 12 dB weaker, inside and outside the band: neither biases the strong one."""
    signal = tones([(220.0, 1.5, 1.0, 0.4), (250.0, 3.0, 0.25, 2.0)], 4.0)
    for bandwidth in (15.0, 25.0, 40.0):
        frequency, decay = fit_pole(signal, RATE, 221.0, bandwidth, 0.3, 3.0)
        assert abs(cents(frequency, 220.0)) < 1e-6
        assert decay == pytest.approx(1.5, rel=1e-6)
    both = fit_poles(signal, RATE, 221.0, 40.0, 0.3, 3.0)
    assert both[1].frequency_hz == pytest.approx(250.0, abs=1e-6)
    assert both[1].amplitude / both[0].amplitude == pytest.approx(0.25 * np.exp(-0.45), rel=1e-6)
    assert both[0].amplitude == pytest.approx(np.exp(-0.45), rel=1e-6)


@pytest.mark.parametrize(("noise_db", "tolerance_hz"), [(None, 1e-6), (-60.0, 0.004)])
def test_doublet(noise_db, tolerance_hz):
    """Two polarizations 0.3 Hz apart: both found, the one with more energy returned first."""
    signal = tones([(110.0, 1.2, 1.0, 0.2), (110.3, 0.5, 0.4, 1.1)], 4.0, noise_db=noise_db)
    early = fit_poles(signal, RATE, 110.0, 22.0, 0.0, 3.2)
    late = fit_poles(signal, RATE, 110.0, 22.0, 1.6, 4.0)
    assert early[0].frequency_hz == pytest.approx(110.0, abs=tolerance_hz)
    assert early[1].frequency_hz == pytest.approx(110.3, abs=tolerance_hz)
    assert late[0].frequency_hz == pytest.approx(110.3, abs=3 * tolerance_hz)


def test_note_pitch_over_the_instrument():
    """From E2 to B5 with body modes, partials and noise at -60 dB: within 0.03 cents (in truth a tenth of it)."""
    rng = np.random.default_rng(3)
    for midi in range(40, 84, 2):
        target = 440.0 * 2.0 ** ((midi - 69) / 12.0)
        off = rng.uniform(-8.0, 8.0)
        f1 = target * 2.0 ** (off / 1200.0) / (1 + 2e-5)
        signal = note(f1, 3.4, noise_db=-60.0, seed=midi)
        assert note_pitch_cents(signal, RATE, target) == pytest.approx(off, abs=0.03), midi


def test_note_pitch_takes_the_strongest_of_a_beating_pair():
    signal = tones([(196.0, 1.0, 1.0, 0.0), (196.4, 0.8, 0.3, 1.0), (203.0, 6.0, 1.0, 1.0)], 4.0, noise_db=-60.0)
    assert note_pitch_cents(signal, RATE, 196.3) == pytest.approx(cents(196.0, 196.3), abs=0.05)


def test_refusals_name_what_is_missing():
    with pytest.raises(ValueError, match="does not lie"):
        note_pitch_cents(note(110.0, 2.0), RATE, 110.0)
    with pytest.raises(ValueError, match="no component"):
        note_pitch_cents(note(110.0), RATE, 150.0)
    with pytest.raises(ValueError, match="needs"):
        fit_pole(note(110.0, 0.1), RATE, 110.0, 10.0)


class Resonators:
    """Sixty discrete two-pole modes seen through three mixed channels, disturbed once."""

    def __init__(self, seed=5):
        rng = np.random.default_rng(seed)
        slow = np.sort(82.0 * np.arange(1, 47) * (1 + 0.01 * rng.uniform(-1, 1, 46)))
        pairs = slow[[3, 8, 15, 22, 30, 38]] + np.array([1.0, 1.0, 1.0, 0.5, 1.0, 2.0])
        damped = np.array([120.0, 288.0, 450.0, 700.0, 1000.0, 1500.0, 2100.0, 2900.0])
        self.frequencies = np.concatenate([slow, pairs, damped])
        self.decays = np.concatenate([rng.uniform(0.5, 8.0, 52), np.full(8, np.log(1000.0) / 0.1)])
        self.mixing = rng.standard_normal((3, 60)) * rng.uniform(0.2, 1.0, 60)
        self.a = 2 * np.exp(-self.decays / RATE) * np.cos(2 * np.pi * self.frequencies / RATE)
        self.b = -np.exp(-2 * self.decays / RATE)
        self.now, self.before = rng.standard_normal(60), rng.standard_normal(60)
        self.before = self.now * np.cos(2 * np.pi * self.frequencies / RATE) + 0.05 * self.before

    def step(self):
        self.now, self.before = self.a * self.now + self.b * self.before, self.now

    def read(self):
        return self.mixing @ self.now


def test_sixty_modes_from_stepping():
    """60 modes, pairs 0.5 to 2 Hz apart, T60 of 0.1 s among them: 0.005 cents, 0.05 %, slow ones far better."""
    system = Resonators()
    guesses, decays = system.frequencies + 0.02, system.decays
    options = {"half_width_hz": 80.0, "decay_guesses": decays}
    found = poles_from_steps(system.step, system.read, 4 * 48000, RATE, guesses, **options)
    error = np.abs(cents(found[:, 0], system.frequencies))
    loss = np.abs(found[:, 1] / decays - 1.0)
    assert np.all(error < 0.005)
    assert np.all(loss < 5e-4)
    slow = decays < 10.0
    assert np.all(error[slow] < 1e-5)
    assert np.all(loss[slow] < 1e-5)


def constrained_step(n_modes=40, rate=16000.0):
    """One-step matrix of a string tied to ten body modes (q*[k+1] = a q + b q', projected on the constraint)."""
    n = np.arange(1, n_modes + 1)
    omega = np.concatenate([2 * np.pi * 41.2 * (2 * n - 1), 2 * np.pi * np.linspace(90.0, 850.0, 10)])
    sigma = np.concatenate([0.4 + 0.05 * n, np.full(10, 9.0)])
    mass = np.concatenate([np.full(n_modes, 2e-3), np.full(10, 0.5)])
    a = 2 * np.exp(-sigma / rate) * np.cos(np.sqrt(omega**2 - sigma**2) / rate)
    b = -np.exp(-2 * sigma / rate)
    g = (1 - a - b) / (mass * omega**2)
    row = np.concatenate([-((-1.0) ** n), -np.ones(10)])
    projector = np.eye(row.size) - np.outer(g * row, row) / (row @ (g * row))
    return np.block([[projector * a, projector * b], [np.eye(row.size), np.zeros((row.size, row.size))]]), row, g


def test_constrained_system_from_its_constraint_force():
    """Poles seen in the constraint force alone equal the eigenvalues of the step: 1e-5 cents, 1e-5 of the decay."""
    rate = 16000.0
    matrix, row, _ = constrained_step(rate=rate)
    values = np.log(np.linalg.eigvals(matrix).astype(complex)) * rate
    values = values[(values.imag > 2 * np.pi * 60) & (values.imag < 2 * np.pi * 1200)]
    state = np.concatenate([np.linspace(1.0, -0.5, row.size), np.linspace(1.0, -0.5, row.size)])
    half = row.size
    state[:half] -= row * (row @ state[:half]) / (row @ row)
    state[half:] = state[:half]
    records = np.empty((int(3 * rate), 2))
    for k in range(records.shape[0]):
        state = matrix @ state
        records[k] = state[half - 1], state[0] - state[half]
    frequencies, decays = values.imag / (2 * np.pi), -values.real
    found = poles_from_records(records, rate, frequencies + 0.05, half_width_hz=60.0, decay_guesses=decays)
    assert values.size > 15
    assert np.max(np.abs(cents(found[:, 0], frequencies))) < 1e-5
    assert np.max(np.abs(found[:, 1] / decays - 1.0)) < 1e-5


def test_silence_is_refused():
    with pytest.raises(ValueError, match="zero"):
        poles_from_records(np.zeros((48000, 2)), RATE, [100.0])

"""Make the shipped impulse response: body modes of the `classical` preset, a random part above them, to a WAV file.

    python tools/make_impulse_response.py [OUT.wav]      (default: ukrt/radiation/data/classical.wav)

The result is SYNTHETIC: no guitar was measured. It maps the force at the bass and at the treble end of the bridge
[N] to the pressure [Pa] at two points 1 m in front of the soundboard, some 30 degrees to the left and right, the
time of flight taken out; half a second at 48 kHz, four channels of float32 (bass-L, bass-R, treble-L, treble-R).

Below 1 kHz, the preset's body modes (frequencies, damping, masses, shapes at the bridge; Debut & Antunes 2020,
Table I). A mode that shakes with acceleration a_n radiates, as a monopole of area S_n, p = rho S_n a_n / (4 pi r);
as a left-right dipole, pressure in quadrature and of opposite sign at the two points (AREAS). For the breathing
modes S_n is the board's effective area times the factor by which the flow through the sound hole adds to the
board's (`hole_factor`, a Helmholtz resonator driven by the board: Christensen & Vistisen, J. Acoust. Soc. Am.
68(3), 758-766, 1980). All areas are estimates that follow what is known: monopoles of the lowest modes dominate to
300 Hz, dipoles and mixtures above, efficiency is largest from 200 to 600 Hz (I. Perry, Sound radiation measurements
on guitars and other stringed musical instruments, thesis, Cardiff 2014). They make mode 2 turn about 3/10 of its
power into sound, mode 9 about 1/7, and give about 1.8 Pa/N at the peak of mode 2. Each mode's mass line is rolled
off above ROLL_OFF_HZ.

Above 1.05 kHz, random modes: one every 25 Hz at 1 kHz, denser above; Q from 50 at 1 kHz down to 20 (wood: damping
rises with frequency, modes overlap, no lone sharp peaks); random shapes at both ends and random phases at both
points, whose correlation falls with frequency. Level: a mean plate mobility near 1/60 s/kg, a twenty-fifth of the
power radiated, into a half space: about 0.2 Pa/N from 1 to 4 kHz, then -7.5 dB per octave (estimates).
"""

import pathlib
import sys

import numpy as np

RATE = 48_000  # Hz
LENGTH = 24_000  # samples: 0.5 s
FADE = 4_800  # samples at the end
SEED = 20201124

AIR_DENSITY = 1.2  # kg/m^3, at 20 degrees
DISTANCE = 1.0  # m
BOARD_AREA = 0.035  # m^2: about a third of the lower bout, the mean of a breathing mode over it; estimate
HELMHOLTZ_HZ = 105.0  # of the air in the box with all walls rigid: between modes 1 and 2; estimate
ROLL_OFF_HZ = 1500.0

# Area of each mode as a monopole and as a left-right dipole, in parts of BOARD_AREA. Estimates (see above): 1 air,
# 2 board, 3 board and back, 4 across the board, 5 along it, then patches of both signs, more and smaller.
AREAS = ((1.0, 0.0), (1.0, 0.0), (0.55, 0.05), (0.16, 0.7), (-0.55, 0.15), (0.5, 0.5), (-0.4, -0.3), (0.5, -0.4),
         (-0.45, 0.45), (0.5, -0.5))  # fmt: skip
BREATHING = 3  # that many of the lowest modes move the air in the box

RANDOM_FROM_HZ, RANDOM_TO_HZ = 1050.0, 20_000.0
LEVEL = 0.2  # Pa/N, rms over frequency, from 1 to 4 kHz
CORNER_HZ, SLOPE = 4500.0, 1.25  # above the corner as f^-SLOPE: -7.5 dB an octave
ONSET = 12  # samples in which the random part sets in: bending waves take their time to spread


def hole_factor(frequency):
    """Flow out of the guitar over that of the board at ``frequency`` [Hz]: 1 far above HELMHOLTZ_HZ, 0 far below."""
    x = (frequency / HELMHOLTZ_HZ) ** 2
    return x / (x - 1.0)


def _decaying(poles, residues, times):
    """Sum over modes of 2 Re(residue exp(pole t)): residues (n, ...) to (times, ...)."""
    shape = residues.shape[1:]
    flat = residues.reshape(len(poles), -1)
    total = np.zeros((len(times), flat.shape[1]))
    for start in range(0, len(poles), 64):
        part = slice(start, start + 64)
        total += 2.0 * (np.exp(np.outer(times, poles[part])) @ flat[part]).real
    return total.reshape(len(times), *shape)


def body_part(body, times):
    """Response of the preset's body modes: ndarray (times, 2 ends, 2 points) [Pa/N/s].

    Per mode, p(s) = rho / (4 pi r) phi (S_monopole s^2 +- S_dipole omega s) / (m (s^2 + 2 zeta omega s + omega^2)),
    times a Butterworth low-pass of second order at ROLL_OFF_HZ; sampled from its partial fractions.
    """
    if len(body.frequencies_hz) != len(AREAS):
        raise SystemExit(f"the preset has {len(body.frequencies_hz)} body modes, AREAS knows {len(AREAS)}")
    cut = 2.0 * np.pi * ROLL_OFF_HZ
    roll_off = cut * np.exp(0.75j * np.pi)
    result = np.zeros((len(times), 2, 2))
    rows = zip(body.frequencies_hz, body.damping_ratios, body.modal_masses, strict=True)
    for n, (frequency, zeta, mass) in enumerate(rows):
        omega = 2.0 * np.pi * frequency
        mode = omega * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
        monopole, dipole = np.array(AREAS[n]) * BOARD_AREA
        if n < BREATHING:
            monopole *= hole_factor(frequency)
        shapes = np.array([body.shapes_bass[n], body.shapes_treble[n]])
        for point, side in enumerate((1.0, -1.0)):
            residues = []
            for pole, other in ((mode, roll_off), (roll_off, mode)):
                top = (monopole * pole**2 + side * dipole * omega * pole) * cut**2
                residues.append(top / (2j * pole.imag * (pole - other) * (pole - other.conjugate())))
            gain = AIR_DENSITY / (4.0 * np.pi * DISTANCE * mass) * shapes
            result[:, :, point] += _decaying(np.array([mode, roll_off]), np.outer(residues, gain), times)
    return result


def _correlated(rng, correlation, shape):
    """Two sets of complex normal numbers of unit mean square whose correlation is ``correlation`` (n,): (2, *shape)."""
    first, second = (rng.standard_normal((2, *shape)) + 1j * rng.standard_normal((2, *shape))) / np.sqrt(2.0)
    return np.stack([first, correlation * first + np.sqrt(1.0 - correlation**2) * second])


def density(frequency):
    """Modes per hertz: board, back and the air between them, 1 in 25 Hz at 1 kHz and denser above."""
    return (1.0 + frequency / 8000.0) / (25.0 * (1.0 + 1000.0 / 8000.0))


def random_part(times):
    """Response of random modes from 1.05 kHz up: ndarray (times, 2 ends, 2 points) [Pa/N/s]."""
    rng = np.random.default_rng(SEED)
    frequencies, at = [], RANDOM_FROM_HZ
    while at < RANDOM_TO_HZ:
        frequencies.append(at + rng.uniform(0.1, 0.9) / density(at))  # neighbours keep apart, as coupled modes do
        at += 1.0 / density(at)
    frequencies = np.array(frequencies)
    n = len(frequencies)
    quality = np.maximum(50.0 * (frequencies / 1000.0) ** -0.35, 20.0) * rng.uniform(0.85, 1.15, n)
    omega = 2.0 * np.pi * frequencies
    poles = -omega / (2.0 * quality) + 1j * omega
    # Shapes are real: the ends, 0.1 m apart, move much alike at 1 kHz, independently far above; the points likewise
    ends = np.sqrt(2.0) * _correlated(rng, np.exp(-frequencies / 3000.0), (n,)).real
    points = _correlated(rng, np.exp(-frequencies / 2000.0), (n,))
    level = LEVEL / (1.0 + (frequencies / CORNER_HZ) ** 4) ** (SLOPE / 4.0)
    # A mode 2 |c| exp(-sigma t) cos(...) adds |c|^2 / (2 sigma) to the integral of |H|^2 over all positive frequencies
    amplitude = level * np.sqrt(2.0 * -poles.real / density(frequencies))
    residues = amplitude[:, None, None] * np.einsum("en,pn->nep", ends, points)
    onset = np.sin(0.5 * np.pi * np.minimum(np.arange(len(times)) / ONSET, 1.0)) ** 2
    return _decaying(poles, residues, times) * onset[:, None, None]


def make_response(body):
    """The shipped response: ndarray (LENGTH, 2, 2) [Pa/N per sample]."""
    times = np.arange(LENGTH) / RATE
    response = (body_part(body, times) + random_part(times)) / RATE
    response[-FADE:] *= (0.5 + 0.5 * np.cos(np.pi * (np.arange(FADE) + 1) / FADE))[:, None, None]
    return response


def main(arguments):
    """Write the response to the named file."""
    import soundfile

    from ukrt.model.presets import load_preset

    default = pathlib.Path(__file__).resolve().parents[1] / "ukrt" / "radiation" / "data" / "classical.wav"
    path = pathlib.Path(arguments[0]) if arguments else default
    response = make_response(load_preset("classical").body)
    soundfile.write(path, response.reshape(LENGTH, 4).astype(np.float32), RATE, subtype="FLOAT", format="WAV")
    print(f"{path}: {LENGTH} samples at {RATE} Hz, largest {np.abs(response).max():.4f} Pa/N per sample")


if __name__ == "__main__":
    main(sys.argv[1:])

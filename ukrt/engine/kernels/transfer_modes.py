"""One mode from one flow to another: same phase, same energy.

Enter a mode's state and coefficients before, and its coefficients from now on; leave its state. Where a mode's two
samples do not tell its phase (damped beyond oscillation, or next to half the sample rate) it goes on from rest.
"""

import math

from ukrt.engine.kernels.jit import kernel

NYQUIST = -0.98  # cosine of the angle a step turns, below which a phase is not believed (choice: 0.47 of the rate)


@kernel
def _pole(a, b):
    """Decay [Np] and angle [rad] of one step of a free mode; the angle is 0 where it cannot be told."""
    size = math.sqrt(-b)
    cosine = a / (2.0 * size)
    if not (cosine > NYQUIST and cosine < 1.0):
        return 0.0, 0.0
    return -math.log(size), math.acos(cosine)


@kernel
def same_energy(a0, b0, a1, b1):
    """How much larger x = q / sqrt(g) is in the new flow for the same m omega^2 q^2 = (1 - a - b) x^2; 0: no mode."""
    if not (b0 < 0.0 and b1 < 0.0 and 1.0 - a0 - b0 > 0.0 and 1.0 - a1 - b1 > 0.0):
        return 0.0
    return math.sqrt((1.0 - a0 - b0) / (1.0 - a1 - b1))


@kernel
def carry_mode(now, coming, held0, held1, a0, b0, a1, b1):
    """State x[k], x*[k+1] of a mode of flow ``a0, b0`` that from now on flows by ``a1, b1``.

    Where forces hold it (``held0``, from now on ``held1``) is no part of its swing: x*[k+1] lacks the kick that they
    give it every step, so that a mode which they hold still looks as if it were on its way back.
    """
    now, coming = now - held0, coming - (a0 + b0) * held0
    if a0 != a1 or b0 != b1:
        scale = same_energy(a0, b0, a1, b1)
        now, coming = _swing_on(scale * now, scale * coming, a0, b0, a1, b1)
    return held1 + now, (a1 + b1) * held1 + coming


@kernel
def _swing_on(now, coming, a0, b0, a1, b1):
    """The same displacement, and the same velocity over omega, in the new flow."""
    if not (b0 < 0.0 and b1 < 0.0):
        return 0.0, 0.0
    decay0, angle0 = _pole(a0, b0)
    decay1, angle1 = _pole(a1, b1)
    if angle0 == 0.0 or angle1 == 0.0:
        return now, (a1 + b1) * now
    # q = Re[c exp((-decay + i angle) t)], c = now + i turned; velocity over omega = -(decay now + angle turned) / omega
    turned = (now * math.cos(angle0) - coming * math.exp(decay0)) / math.sin(angle0)
    speed = -(decay0 * now + angle0 * turned) / math.sqrt(decay0 * decay0 + angle0 * angle0)
    turned = -(speed * math.sqrt(decay1 * decay1 + angle1 * angle1) + decay1 * now) / angle1
    return now, math.exp(-decay1) * (now * math.cos(angle1) - turned * math.sin(angle1))

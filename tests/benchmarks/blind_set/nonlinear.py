"""States that only a step-by-step solution shows: a lifting support, a rub, oil whirl."""

from __future__ import annotations

import numpy as np
from numba import njit
from structure import Floats

TURN = 2 * np.pi


@njit(cache=True)
def _support(force, step_s, own, damping, lift, gap, soft, knock):
    x = v = 0.0
    extra = np.zeros(force.size)
    for i in range(force.size):
        # Clamped below `lift`; above it only the soft path carries. With a gap: free play on both sides.
        missing = 0.0
        if knock:
            if x > -gap and x < gap:
                missing = (1.0 - soft) * own * own * x
            elif x >= gap:
                missing = (1.0 - soft) * own * own * gap
            else:
                missing = -(1.0 - soft) * own * own * gap
        elif x > lift:
            missing = (1.0 - soft) * own * own * (x - lift)
        v += step_s * (force[i] - 2.0 * damping * own * v - own * own * x + missing)
        x += step_s * v
        extra[i] = missing
    return extra


def loose_support(force: Floats, rate_hz: float, own_hz: float, rng: np.random.Generator) -> Floats:
    """Force that a bilinear support adds to the linear one, for a force per unit mass.

    The support lifts when the alternating displacement passes a preload drawn relative to the linear response, or
    the bearing rattles in a gap of its seat.
    """
    own, damping = TURN * own_hz, 0.04
    linear = _linear_size(force, rate_hz, own, damping)
    knock = bool(rng.random() < 0.35)
    lift, gap = linear * rng.uniform(0.0, 0.5), linear * rng.uniform(0.2, 0.8)
    soft = rng.uniform(0.05, 0.45)
    return _support(force, 1 / rate_hz, own, damping, lift, gap, soft, knock)


def _linear_size(force: Floats, rate_hz: float, own: float, damping: float) -> float:
    spectrum = np.fft.rfft(force)
    omega = TURN * np.fft.rfftfreq(force.size, 1 / rate_hz)
    return float(np.sqrt(2) * np.std(np.fft.irfft(spectrum / (own**2 - omega**2 + 2j * damping * own * omega))))


@njit(cache=True)
def _whirl(angle, rate, noise, own, damping, swirl, hardening, eccentric, gap, offset, stiff, friction, start):
    y = u = v = 0.0
    x = start
    n = angle.size
    out = np.zeros((4, n))
    step = 1.0 / rate
    for i in range(n):
        speed = (angle[min(i + 1, n - 1)] - angle[max(i - 1, 0)]) * rate / (2.0 if 0 < i < n - 1 else 1.0)
        radius2 = x * x + y * y
        k = own * own * (1.0 + hardening * radius2)
        d = 2.0 * damping * own * (1.0 + hardening * radius2)
        ax = -d * u - k * x - d * swirl * speed * y + eccentric * speed * speed * np.cos(angle[i]) + noise[0, i]
        ay = -d * v - k * y + d * swirl * speed * x + eccentric * speed * speed * np.sin(angle[i]) + noise[1, i]
        rx, ry = x - offset, y
        r = np.sqrt(rx * rx + ry * ry)
        fx = fy = 0.0
        if r > gap:
            inward = -(rx * u + ry * v) / r
            push = max(0.0, stiff * own * own * (r - gap) - 0.4 * np.sqrt(stiff) * own * inward)
            fx = -push * (rx - friction * ry) / r
            fy = -push * (ry + friction * rx) / r
        u += step * (ax + fx)
        v += step * (ay + fy)
        x += step * u
        y += step * v
        out[0, i], out[1, i], out[2, i], out[3, i] = x, y, fx, fy
    return out


def journal(
    angle: Floats,
    rate_hz: float,
    speed_hz: float,
    state: str,
    large: float,
    rng: np.random.Generator,
    own: np.random.Generator,
) -> Floats:
    """Shaft motion in an oil-film bearing and contact force per mass [x, y, fx, fy], lengths in unbalance radii.

    Muszynska's model: the film's damper turns at ``swirl`` times the shaft speed, so that the damping force holds a
    cross stiffness; above a threshold speed sqrt(K/m)/swirl the shaft whirls, held by the film's hardening. The rub
    adds a stiff, rubbing stator ring on one side (Muszynska, Rotordynamics, 2005, chs. 4 and 5).
    """
    swirl = own.uniform(0.41, 0.48)
    ratio, damping = own.uniform(0.55, 1.4), own.uniform(0.12, 0.3)  # stable while the ratio is under 1 / swirl
    rub_ratio = own.uniform(0.6, 3.2)
    if state == "oil_whirl":
        ratio, damping = rng.uniform(1.15, 1.5) / swirl, rng.uniform(0.3, 0.6)
    if state.startswith("rub"):
        ratio, damping, swirl = rub_ratio, own.uniform(0.03, 0.1), 0.1
    natural = TURN * speed_hz / ratio
    forced = 1 / abs(1 / ratio**2 - 1 + 2j * damping * (1 - swirl) / ratio)
    hardening = 1 / (large * forced) ** 2 if state == "oil_whirl" else 0.02 / forced**2
    gap, offset = 1e9, 0.0
    if state == "rub":
        # A seal that leans on the orbit from one side; a light touch at the orbit's edge would hardly show.
        offset = -forced * rng.uniform(2.0, 6.0)
        gap = forced * rng.uniform(-0.5, 0.8) - offset
    noise = rng.standard_normal((2, angle.size)) * natural**2 * forced * 0.02 * np.sqrt(rate_hz / natural)
    stiff, friction = rng.uniform(5, 40), rng.uniform(0.02, 0.08)
    start = 0.3 * large * forced if state == "oil_whirl" else 0.0
    return _whirl(angle, rate_hz, noise, natural, damping, swirl, hardening, 1.0, gap, offset, stiff, friction, start)

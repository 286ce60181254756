"""The law of a gear mesh: its stiffness and error at a shaft angle, its force, and where teeth enter and leave.

The formulas are those of `gear_mesh`.
"""

from __future__ import annotations

import math

import numpy as np

from ..law import Law, Timeline, compiled_force
from .tooth_signals import tooth_signals

# Parameters of the law: these, then two polynomials of equal length; with damaged teeth the sound pair's compliance
# and for each tooth (every, first, compliance, error), all polynomials of equal length; then (order, cosine, sine of
# the error, cosine, sine of how many pitches later a pair enters) of each.
ORDER, START, CHANGE, MEAN, DAMPING, BACKLASH, SEPARATES, MEAN_ERROR, POWERS, TEETH, PAIR_POWERS, SERIES = range(12)
#: Numbers of each error among the parameters.
EACH = 5
#: Steps to the angle at which a pair enters; each leaves 3 % of the one before, of a pinion off by 0.2 mm, or less.
ROUNDS = 8


def _mesh_signals(timeline: Timeline, parameters: np.ndarray, *, branch_rad: np.ndarray | None = None) -> np.ndarray:
    """Return stiffness, error and rate of error."""
    powers = int(parameters[POWERS, 0])
    first = parameters[SERIES : SERIES + powers]
    second = parameters[SERIES + powers : SERIES + 2 * powers]
    teeth, pair_powers, series = _layout(parameters[:, 0])
    error, rate, later = _error_signals(timeline, parameters[series:], parameters[ORDER])
    pitches = parameters[ORDER] / (2 * math.pi)
    branch = (timeline.phase_rad if branch_rad is None else branch_rad) * pitches + parameters[START]
    tooth = np.floor(branch - later)
    is_first = branch - tooth < parameters[CHANGE]
    # Unwrapped against the branch's own tooth: past a jump the branch is continued, not the stiffness.
    local = timeline.phase_rad * pitches + parameters[START] - tooth - np.where(is_first, 0.0, parameters[CHANGE])
    stiffness = np.zeros(local.shape)
    for a, b in zip(first[::-1], second[::-1], strict=True):
        stiffness *= local
        stiffness += np.where(is_first, a, b)
    if teeth:
        phase = timeline.phase_rad * pitches + parameters[START] - tooth
        change = tooth_signals(tooth, phase, is_first, parameters[SERIES + 2 * powers : series], pair_powers)
        stiffness = stiffness + change[0]
        error = error + change[1]
        rate = rate + change[2] * pitches * timeline.speed_rad_s
    return np.stack([stiffness, error + parameters[MEAN_ERROR], rate])


def _layout(parameters: np.ndarray) -> tuple[int, int, int]:
    """Return the number of damaged teeth, the length of their polynomials, and where the errors begin."""
    powers, teeth, pair_powers = (int(parameters[row]) for row in (POWERS, TEETH, PAIR_POWERS))
    return teeth, pair_powers, SERIES + 2 * powers + pair_powers + teeth * (2 + 2 * pair_powers)


def _error_signals(
    timeline: Timeline, series: np.ndarray, mesh_order: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the error, its rate, and by how many pitches pairs enter later."""
    error, rate, later = (np.zeros(timeline.phase_rad.shape) for _ in range(3))
    powers: dict[int, np.ndarray] = {}
    for order, a, b, c, d in series.reshape(-1, EACH, *series.shape[1:]):
        if a.any() or b.any() or c.any() or d.any():
            cos, sin = _harmonic(timeline, order, mesh_order, powers)
            error += a * cos
            error += b * sin
            turned = (order * b) * cos
            turned -= (order * a) * sin
            rate += turned
            if c.any() or d.any():
                later += c * cos
                later += d * sin
    rate *= timeline.speed_rad_s
    return error, rate, later


def _harmonic(
    timeline: Timeline, order: np.ndarray, mesh_order: np.ndarray, powers: dict[int, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return cosine and sine of ``order`` times the shaft angle; multiples of the mesh by multiplying."""
    ratio = order / mesh_order
    number = round(float(ratio[0]))
    if not 1 < number < 10 or np.any(ratio != number):
        return timeline.cos_sin(order)
    if not powers:
        cos, sin = timeline.cos_sin(mesh_order)
        powers[1] = cos + 1j * sin
    for multiple in range(2, number + 1):
        if multiple not in powers:
            powers[multiple] = powers[multiple - 1] * powers[1]
    return np.real(powers[number]), np.imag(powers[number])


def _mesh_jumps(parameters: np.ndarray, start_rad: float, stop_rad: float) -> np.ndarray:
    """Return the shaft angles in (start, stop] where a pair of teeth enters or leaves."""
    pitches, offset = parameters[ORDER] / (2 * math.pi), parameters[START]
    series = parameters[_layout(parameters)[2] :].reshape(-1, EACH)
    order, cosine, sine = series[(series[:, 3:] != 0).any(axis=1)][:, [0, 3, 4]].T[:, :, None]
    found = []
    for phase, moves in ((0.0, bool(order.size)), (parameters[CHANGE], False)):
        low, high = start_rad * pitches + offset - phase, stop_rad * pitches + offset - phase
        numbers = np.arange(math.floor(low) + 1 - moves, math.floor(high) + 1 + moves)
        at = (numbers + phase - offset) / pitches
        # From where the pair would enter to where it does: each round is nearer by what moves it within that.
        for _ in range(ROUNDS * moves):
            later = (cosine * np.cos(order * at) + sine * np.sin(order * at)).sum(axis=0)
            at = (numbers + later - offset) / pitches
        found.append(at[(at > start_rad) & (at <= stop_rad)] if moves else at)
    return np.sort(np.concatenate(found))


@compiled_force
def _mesh_force(signals, parameters, x, inputs, outputs, u):  # type: ignore[no-untyped-def]
    approach, speed, acts = inputs[0], inputs[1], outputs[0]
    for lane in range(u.shape[1]):
        gap = x[approach, lane] - signals[1, lane]
        force = signals[0, lane] * gap + parameters[DAMPING, lane] * (x[speed, lane] - signals[2, lane])
        if parameters[SEPARATES, lane] > 0.0 and gap <= 0.0:
            if gap < -parameters[BACKLASH, lane]:
                force += signals[0, lane] * parameters[BACKLASH, lane]
            else:
                force = 0.0
        linear = parameters[MEAN, lane] * x[approach, lane] + parameters[DAMPING, lane] * x[speed, lane]
        u[acts, lane] -= force - linear


GEAR_MESH = Law("gear mesh", _mesh_signals, _mesh_force, _mesh_jumps, counts=(POWERS, TEETH, PAIR_POWERS))

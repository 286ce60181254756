"""Where the tacho's pulse sits on the shaft: a reflective mark or a keyway stands anywhere, a model's angles do not.

A pulse at another angle than the model's zero turns the phase of order k by k times that angle, at every probe and in
every condition, healthy or not. The healthy recordings tell the angle where the machine itself makes lines with a phase
(its residual unbalance, gravity, its coupling); without such lines, or without healthy recordings, it is taken to be 0.
Three guesses compete by the evidence of the healthy lines once calibrated: no turn; the turn by which the machine as
given agrees best; and that turn at which the lines are likeliest wherever the machine's own unbalance points.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline, start, widened_by
from .calibration import calibrated
from .coordinates import Coordinate
from .healthy_evidence import ERROR_FACTORS, covariance_of_all, evidence, is_explained
from .lacking_terms import lacking_terms
from .likely_terms import USUAL
from .line_covariance import LineCovariance
from .lines import OrderLines
from .predict import Predictor
from .unbalance_direction import OwnUnbalance, own_unbalance

#: Angles that are tried round the shaft, and those about the best of them.
ANGLES = np.linspace(-np.pi, np.pi, 180, endpoint=False)
NEARER = np.radians(np.linspace(-2, 2, 41))
#: A turn that the calibration may have hidden in the machine's parameters.
NEAR = np.radians(np.linspace(-45, 45, 181))
#: By which share the machine as given may miss its lines: a line weighs no more than its square allows.
MISSED = 0.3
#: The turned lines must agree better by so much before anything is computed, and after the calibration by so much in
#: the logarithm of the evidence: an angle out of a full turn has to be paid for.
CLEARLY, PLACE_GAIN = 20.0, 10.0
#: Places that are closer together (rad) count as one.
APART = math.radians(5.0)
ROUNDS = 3


@dataclass(frozen=True, eq=False)
class Placed:
    """A calibrated machine and where the pulse sits on its shaft.

    Attributes
    ----------
    machine : Machine
        As given, but for the direction of its own unbalance.
    free : tuple of Coordinate
        What of it has become uncertain: that direction, or nothing.
    at_healthy : Baseline
        Calibrated.
    pulse_rad : float
        Angle by which the machine has turned when the pulse comes.
    evidence : float
        Logarithm, of the healthy lines.
    """

    machine: Machine
    free: tuple[Coordinate, ...]
    at_healthy: Baseline
    pulse_rad: float
    evidence: float


def placings(
    machine: Machine, healthy: OrderLines, predictor: Predictor, *, tell: Callable[[str], None] = lambda _: None
) -> list[Placed]:
    """Return the machine calibrated on its healthy lines with the pulse at its zero, and where else it may sit.

    Others only where those lines are not explained, and clearly likelier then. What the model lacks may take that back.

    Parameters
    ----------
    machine : Machine
    healthy : OrderLines
    predictor : Predictor
        For the healthy conditions.
    """
    plain = placed_at(0.0, machine, (), healthy, predictor, tell=tell)
    if is_explained(plain.at_healthy, healthy):
        return [plain]
    found, given = [plain], predictor.amplitudes(machine)
    angle = best_angle(healthy, given)
    if _agreement(healthy, given, np.array([angle, 0.0])) @ [1, -1] >= CLEARLY:
        best = plain
        for _ in range(ROUNDS):
            other = placed_at(angle, machine, (), healthy, predictor, tell=tell)
            if not is_better(other, best):
                break
            best, angle = other, best_angle(healthy, other.at_healthy.lines)
        found += [best] if best is not plain else []
    own = own_unbalance(machine, predictor)
    if own is not None and (own.angle.prior is None or Coordinate(own.angle).is_angle):
        where, angle = _jointly(machine, own, healthy, predictor)
        free = () if own.angle.prior is not None else (own.coordinate,)
        other = placed_at(angle, where, free, healthy, predictor, tell=tell)
        # Elsewhere than those before it may be right although the machine as given is far off there.
        elsewhere = all(abs(math.remainder(angle - one.pulse_rad, 2 * math.pi)) > APART for one in found)
        likelier = other.evidence > max(one.evidence for one in found) + PLACE_GAIN
        found += [other] if elsewhere or likelier else []
    return found


def placed_at(
    pulse_rad: float,
    machine: Machine,
    free: tuple[Coordinate, ...],
    healthy: OrderLines,
    predictor: Predictor,
    *,
    tell: Callable[[str], None] = lambda _: None,
) -> Placed:
    """Return a machine, with what is uncertain of it although no prior says so, calibrated with the pulse at an angle.

    ``healthy`` are the lines as observed.
    """
    if pulse_rad:
        tell(f"calibration with the pulse at {np.degrees(pulse_rad):.0f} deg")
    here = turned(healthy, pulse_rad)
    found = calibrated(machine, here, predictor, free, tell=tell)
    return Placed(machine, free, found, pulse_rad, evidence(found, here))


def is_better(other: Placed, best: Placed) -> bool:
    """Return whether another place is likelier; leaving the machine's zero has to be paid for."""
    return other.evidence > best.evidence + (PLACE_GAIN if best.pulse_rad == 0.0 else 0.0)


def turned(lines: OrderLines, angle_rad: float) -> OrderLines:
    """Return lines whose phase is counted from the machine's zero instead of the pulse.

    Conditions that are not tied to the shaft's angle stay as they are.
    """
    return replace(lines, amplitudes=_turned(lines, np.array([angle_rad]))[0])


def _turned(lines: OrderLines, angles: np.ndarray) -> np.ndarray:
    """Return the amplitudes turned by each of some angles, shape (angles, conditions, probes, orders)."""
    factor = np.exp(-1j * np.multiply.outer(angles, lines.phase_orders))[:, None, None, :]
    tied = np.array([one.tied for one in lines.conditions])[:, None, None]
    return lines.amplitudes * np.where(tied, factor, 1.0)


def best_angle(lines: OrderLines, expected: np.ndarray) -> float:
    """Return the angle (rad) by which lines have to be turned to agree best with other amplitudes of their shape."""
    rough = ANGLES[np.argmax(_agreement(lines, expected, ANGLES))] + NEARER
    return float(rough[np.argmax(_agreement(lines, expected, rough))])


def _agreement(lines: OrderLines, expected: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return how well the phases agree when the lines are turned by each of some angles, shape (angles,)."""
    tied = np.array([one.tied for one in lines.conditions])[:, None, None]
    used = lines.seen & tied & (lines.phase_orders > 0)
    size = np.maximum(np.abs(lines.amplitudes), np.abs(expected))
    variance = np.where(used, lines.deviations, 1.0) ** 2 + (MISSED * size) ** 2
    product = np.where(used, lines.amplitudes * expected.conj() / np.maximum(variance, 1e-300), 0.0).sum(axis=(0, 1))
    return np.real(np.exp(-1j * np.outer(angles, lines.phase_orders)) @ product)


def _jointly(machine: Machine, own: OwnUnbalance, healthy: OrderLines, predictor: Predictor) -> tuple[Machine, float]:
    """Return the machine with its unbalance where it points likeliest, and the pulse's angle then."""
    angle, where = 0.0, machine
    for _ in range(ROUNDS):
        part = own_unbalance(where, predictor)
        if part is None:
            break
        # With the own unbalance free in size and direction, about none: its two components are slopes like any other.
        current = start(where, predictor)
        loose = replace(
            current,
            slopes=np.concatenate([current.slopes, [part.lines, part.across]]),
            prior=np.append(current.prior, [1.0, 1.0]),
            prior_mean=np.append(current.prior_mean, [-1.0, 0.0]),
        )
        straight = _likeliest(loose, healthy, np.zeros(1))
        best = _likeliest(loose, healthy, _likeliest(loose, healthy, ANGLES).angle_rad + NEARER)
        # Where 1X is all there is, the pulse's place and the direction are one: the pulse stays at the zero.
        best = best if best.density > straight.density + PLACE_GAIN else straight
        angle, where = best.angle_rad, part.turned_in(where, math.atan2(*best.components[::-1]))
    return where, math.remainder(angle, 2 * math.pi)


@dataclass(frozen=True)
class _Turn:
    """A turn of the lines: the logarithm of their density, and where the last two unknowns are then."""

    angle_rad: float
    density: float
    components: tuple[float, float]


def _likeliest(current: Baseline, healthy: OrderLines, angles: np.ndarray) -> _Turn:
    """Return that turn, of some, at which the lines are likeliest."""
    found = _Turn(0.0, -math.inf, (0.0, 0.0))
    for covariance, white in _whitened_turned(current, healthy, angles):
        each = covariance.density(white)
        chosen = int(np.argmax(each))
        if each[chosen] > found.density:
            x, y = current.prior[-2:] ** 2 * (covariance.whole(current.slopes[-2:]) @ white[chosen])
            found = _Turn(float(angles[chosen]), float(each[chosen]), (float(x), float(y)))
    return found


def turn_nearby(current: Baseline, healthy: OrderLines, predictor: Predictor, *, reference_rpm: float) -> float:
    """Return the turn (rad, up to 45 degrees) that makes the lines clearly likelier about a calibrated machine, else 0.

    A small turn may have hidden in the machine's parameters, or in the unbalance of its rotors: these are free here.
    """
    if not any(one.tied for one in healthy.conditions):
        return 0.0
    able, none = predictor.repeats(current.machine), frozenset[float]()
    terms = lacking_terms(current, predictor, reference_rpm=reference_rpm, only=USUAL, missed=none) if able else []
    turning = [term.slopes for term in terms]
    loose = widened_by(current, np.concatenate(turning)) if turning else current
    each = _whitened_turned(loose, healthy, NEAR)
    curve = np.max([covariance.density(white) for covariance, white in each], axis=0)
    return float(NEAR[np.argmax(curve)]) if curve.max() > curve[NEAR.size // 2] + PLACE_GAIN else 0.0


def _whitened_turned(
    current: Baseline, healthy: OrderLines, angles: np.ndarray
) -> list[tuple[LineCovariance, np.ndarray]]:
    """Return for each size of the model error the covariance and the whitened residuals, (angles, reals)."""
    expected = current.lines + np.tensordot(current.prior_mean, current.slopes, 1)
    left = _turned(healthy, angles) - expected
    each = [covariance_of_all(current, healthy, factor) for factor in ERROR_FACTORS]
    return [(covariance, covariance.whole(left)) for covariance in each]

"""What the supports of a model lack, told by healthy recordings before anything is diagnosed.

A machine whose model is wrong in form misses its healthy lines whatever its parameters are, and every fault is then
looked for in the wrong machine. Springs and dampers between a support and the ground are tried: alike or unlike in x
and y, or cross-coupled, constant or growing with the speed or its square. One after the other joins the machine where
it raises the evidence of the healthy lines enough, and is uncertain from then on like the machine's own parameters;
those that later ones make needless leave again. By how much the model is wrong beside them is taken as likely as it can
be, so that a form which no spring makes is no reason to add springs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.effect import Effect
from ...simulators.effects.empirical_stiffness import EmpiricalStiffness
from ...simulators.machine import Machine
from ...simulators.parameter import Normal
from .baseline import Baseline, error_covariance, model_error, noise_covariance
from .calibration import calibrated
from .coordinates import Coordinate
from .lines import OrderLines, stacked
from .predict import Predictor
from .result import Estimate, ModelForm, SupportTerm

#: Powers of the speed that are tried for each strength.
EXPONENTS: dict[str, tuple[float, ...]] = {
    **dict.fromkeys(("stiffness_n_m", "difference_n_m", "cross_n_m"), (0.0, 1.0, 2.0)),
    "damping_n_s_m": (0.0,),
}
#: Roles of the places where a support may be wrong.
SUPPORTS = frozenset({"bearing", "housing"})
#: Healthy conditions needed: what grows with the speed shows at three or more.
LEAST_CONDITIONS = 3
#: Terms at most, and by how much each must raise the logarithm of the evidence, beside that of how many were tried.
MOST_TERMS, LEAST_GAIN = 8, 5.0
#: One standard deviation of a term's strength moves the lines of some probe by this share.
MOVES = 0.3
#: Step for the slopes: as large a share of the lines of the probe that moves most.
STEP, FIRST_TRY = 1e-3, {name: 1.0 if name == "damping_n_s_m" else 100.0 for name in EXPONENTS}
#: Factors of the usual model error of which the likeliest counts.
ERROR_FACTORS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
#: Standard deviations of half of a 90 % interval.
SIGMAS_OF_90 = 1.6449


@dataclass(frozen=True, eq=False)
class Extended:
    """A machine with what its supports lack.

    Attributes
    ----------
    machine : Machine
        As given, with the added terms at zero.
    added : tuple of Coordinate
        Their strengths.
    at_healthy : Baseline
        Calibrated on the healthy lines.
    covariance : ndarray (unknowns, unknowns)
        Of its coordinates and the probes' gains there.
    missed_before, missed : float
        Share of the healthy lines that the calibrated machine misses without and with them.
    """

    machine: Machine
    added: tuple[Coordinate, ...]
    at_healthy: Baseline
    covariance: np.ndarray
    missed_before: float
    missed: float


@dataclass(frozen=True, eq=False)
class _Term:
    """A strength that may be added, and what one standard deviation of it moves."""

    effect: Effect
    strength: str
    deviation: float
    slope: np.ndarray


def extended(
    machine: Machine,
    found: Baseline,
    healthy: OrderLines,
    predictor: Predictor,
    *,
    reference_rpm: float,
    tell: Callable[[str], None] = lambda _: None,
) -> Extended:
    """Return the machine with the springs and dampers that its healthy lines ask for; often none.

    Parameters
    ----------
    machine : Machine
        As given.
    found : Baseline
        The same calibrated on the healthy lines.
    healthy : OrderLines
    predictor : Predictor
        For the healthy conditions.
    reference_rpm : float
        Highest speed of all recordings.
    """
    state = _State(machine, (), found)
    able = predictor.repeats(machine) and len(healthy.conditions) >= LEAST_CONDITIONS
    for count in range(MOST_TERMS if able else 0):
        tell(f"what the supports lack, term {count + 1}")
        terms = _terms(state.current, predictor, reference_rpm)
        gains = _gains(state.current, healthy, terms)
        best = int(np.argmax(gains))
        if gains[best] < LEAST_GAIN + math.log(len(terms)):
            break
        further = state.changed((*state.terms, terms[best]), healthy, predictor)
        if _evidence(further.current, healthy) < _evidence(state.current, healthy) + LEAST_GAIN:
            break
        state = further
    while state.terms and (weakest := _not_needed(state, healthy)) is not None:
        kept = tuple(term for i, term in enumerate(state.terms) if i != weakest)
        state = state.changed(kept, healthy, predictor)
    return Extended(
        machine=state.with_terms()[0],
        added=state.with_terms()[1],
        at_healthy=state.current,
        covariance=_covariance(state.current, healthy),
        missed_before=_missed(found, healthy),
        missed=_missed(state.current, healthy),
    )


@dataclass(frozen=True, eq=False)
class _State:
    """The machine as given, the terms that it has now, and where both are calibrated."""

    machine: Machine
    terms: tuple[_Term, ...]
    current: Baseline

    def with_terms(self) -> tuple[Machine, tuple[Coordinate, ...]]:
        """Return the machine with the terms at zero, and their coordinates."""
        first = len(self.machine.effects)
        coordinates = tuple(_coordinate(term, first + i) for i, term in enumerate(self.terms))
        return self.machine.with_effects(*(term.effect for term in self.terms)), coordinates

    def changed(self, terms: tuple[_Term, ...], healthy: OrderLines, predictor: Predictor) -> _State:
        """Return the state with other terms, calibrated from where this one is."""
        own = len(self.current.coordinates) - len(self.terms)
        known = dict(zip(self.terms, self.current.position[own:], strict=True))
        begin = np.concatenate([self.current.position[:own], [known.get(term, 0.0) for term in terms]])
        there = replace(self, terms=terms)
        machine, coordinates = there.with_terms()
        return replace(there, current=calibrated(machine, healthy, predictor, coordinates, begin=begin))


def _not_needed(state: _State, healthy: OrderLines) -> int | None:
    """Return the number of the term that the evidence needs least, None where it needs all.

    By the densities of its strength at zero before and after the healthy lines (J. M. Dickey, Annals of Mathematical
    Statistics 42 (1971) 204).
    """
    covariance = _covariance(state.current, healthy)
    own = len(state.current.coordinates) - len(state.terms)
    deviation = np.sqrt(np.diag(covariance)[own : own + len(state.terms)])
    needed = 0.5 * (state.current.position[own:] / deviation) ** 2 + np.log(deviation)
    return int(np.argmin(needed)) if needed.min() < LEAST_GAIN else None


def form_of(found: Extended) -> ModelForm:
    """Return what was added, with intervals: what the healthy lines leave open."""
    current, terms = found.at_healthy, []
    own = len(current.coordinates) - len(found.added)
    for number, coordinate in enumerate(found.added, start=own):
        effect = current.machine.effects[coordinate.effect or 0]
        z, name = float(current.position[number]), coordinate.parameter.name
        half = SIGMAS_OF_90 * math.sqrt(found.covariance[number, number])
        value = Estimate(
            effect.values()[name],
            coordinate.value(z - half),
            coordinate.value(z + half),
            coordinate.parameter.unit,
        )
        law = effect.values()
        terms.append(SupportTerm(effect.at, name, law["speed_exponent"], law["reference_speed_rpm"], value))
    return ModelForm(tuple(terms), found.missed_before, found.missed)


def _covariance(current: Baseline, healthy: OrderLines) -> np.ndarray:
    """Return the covariance of the machine's unknowns and the probes' gains after the healthy lines."""
    slopes = stacked(current.slopes, healthy.parts)
    factor = max(ERROR_FACTORS, key=lambda one: _whitened(current, healthy, one)[2])
    moved = np.linalg.solve(_lines_covariance(current, healthy, factor), slopes.T)
    return np.linalg.inv(slopes @ moved + np.diag(current.prior**-2))


def _coordinate(term: _Term, number: int) -> Coordinate:
    declared = next(p for p in term.effect.parameters() if p.name == term.strength)
    return Coordinate(replace(declared, prior=Normal(0.0, term.deviation)), number)


def _terms(current: Baseline, predictor: Predictor, reference_rpm: float) -> list[_Term]:
    """Return what can be added at each support, but for what has been."""
    machine = current.machine
    places = [
        p for p in machine.bare_assembly().places.values() if SUPPORTS & p.roles and {"x", "y"} <= set(p.directions)
    ]
    nothing = {name: 0.0 for name in EXPONENTS}
    tried: list[tuple[Effect, str]] = []
    for place in places:
        for strength, powers in EXPONENTS.items():
            for power in powers:
                one = EmpiricalStiffness(
                    at=place.name, speed_exponent=power, reference_speed_rpm=reference_rpm, **nothing
                )
                if not any(_is_same(one, strength, other) for other in machine.effects):
                    tried.append((one, strength))
    first = _changes(current, tried, [FIRST_TRY[strength] for _, strength in tried], predictor)
    sizes = _sizes(first, current.lines)
    moving = [i for i, size in enumerate(sizes) if size > 0]
    steps = [FIRST_TRY[tried[i][1]] * STEP / sizes[i] for i in moving]
    found = []
    for i, step, change in zip(
        moving, steps, _changes(current, [tried[i] for i in moving], steps, predictor), strict=True
    ):
        deviation = step * MOVES / _sizes([change], current.lines)[0]
        found.append(_Term(*tried[i], deviation, change / step * deviation))
    return found


def _is_same(one: Effect, strength: str, other: Effect) -> bool:
    return (
        isinstance(other, EmpiricalStiffness)
        and (one.at, one.values()["speed_exponent"]) == (other.at, other.speed_exponent)
        and other.values()[strength] != 0.0
    )


def _changes(
    current: Baseline, tried: Sequence[tuple[Effect, str]], steps: Sequence[float], predictor: Predictor
) -> list[np.ndarray]:
    """Return by how much the lines change with each strength at its step."""
    machines = [
        current.machine.with_effects(effect.with_values(**{strength: step}))
        for (effect, strength), step in zip(tried, steps, strict=True)
    ]
    predictor.prepare(machines)
    return [predictor.amplitudes(machine) - current.lines for machine in machines]


def _sizes(changes: Sequence[np.ndarray], lines: np.ndarray) -> list[float]:
    """Return each change as a share of the lines of the probe where that is largest."""
    whole = np.sqrt((np.abs(lines) ** 2).sum(axis=(0, 2)))
    there = whole > 0
    return [
        float((np.sqrt((np.abs(one) ** 2).sum(axis=(0, 2)))[there] / whole[there]).max(initial=0.0)) for one in changes
    ]


def _whitened(current: Baseline, healthy: OrderLines, factor: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the Cholesky factor of the lines' covariance, the whitened residual, and the logarithm of its density.

    The machine's own unknowns and the gains are integrated out, about the calibrated machine.
    """
    parts = healthy.parts
    slopes = stacked(current.slopes, parts)
    left = stacked(healthy.amplitudes - current.lines, parts) - current.prior_mean @ slopes
    covariance = _lines_covariance(current, healthy, factor) + (slopes.T * current.prior**2) @ slopes
    lower = np.linalg.cholesky(covariance)
    white = np.linalg.solve(lower, left)
    return lower, white, -0.5 * float(white @ white) - float(np.log(np.diag(lower)).sum())


def _lines_covariance(current: Baseline, healthy: OrderLines, factor: float) -> np.ndarray:
    """Return the covariance of noise and model error, the usual one times a factor."""
    error = factor * model_error(current.lines)
    return noise_covariance(healthy) + error_covariance(healthy.conditions, error, healthy.parts)


def _evidence(current: Baseline, healthy: OrderLines) -> float:
    """Return the logarithm of the evidence of the healthy lines, up to a constant."""
    return max(_whitened(current, healthy, factor)[2] for factor in ERROR_FACTORS)


def _gains(current: Baseline, healthy: OrderLines, terms: Sequence[_Term]) -> np.ndarray:
    """Return by how much each term raises the logarithm of the evidence, shape (terms,)."""
    if not terms:
        return np.array([-math.inf])
    slopes = np.stack([stacked(term.slope[None], healthy.parts)[0] for term in terms], axis=1)
    plain, with_term = [], []
    for factor in ERROR_FACTORS:
        lower, white, density = _whitened(current, healthy, factor)
        moved = np.linalg.solve(lower, slopes)
        more = 1 + (moved**2).sum(axis=0)
        plain.append(density)
        with_term.append(density + 0.5 * (white @ moved) ** 2 / more - 0.5 * np.log(more))
    return np.max(with_term, axis=0) - max(plain)


def _missed(current: Baseline, healthy: OrderLines) -> float:
    """Return the share of the healthy lines that the machine misses, of the probe where it is largest."""
    seen = healthy.seen & (np.abs(healthy.amplitudes) > 3 * np.where(healthy.seen, healthy.deviations, np.inf))
    size = np.where(seen, np.abs(healthy.amplitudes) ** 2, 0.0).sum(axis=(0, 2))
    left = np.where(seen, np.abs(healthy.amplitudes - current.lines) ** 2, 0.0).sum(axis=(0, 2))
    return float(np.sqrt(left[size > 0] / size[size > 0]).max(initial=0.0))

"""What the model of a healthy machine lacks, told by healthy recordings before anything is diagnosed.

A machine whose model is wrong in form misses its healthy lines whatever its parameters are, and every fault is then
looked for in the wrong machine. Terms (`lacking_terms.py`) join the machine one after the other where they raise the
evidence of the healthy lines enough, and are uncertain from then on like the machine's own parameters; those that later
ones make needless leave again. By how much the model is wrong beside them is taken as likely as it can be, so that a
form which no term makes is no reason to add terms.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline
from .calibration import calibrated
from .coordinates import Coordinate
from .healthy_evidence import ERROR_FACTORS, evidence, raised, unknowns_covariance, whitened
from .lacking_terms import TURNING, Term, lacking_terms
from .lines import OrderLines, stacked
from .predict import Predictor
from .pulse_place import Placed
from .result import Estimate, LackingTerm, ModelForm
from .stable import is_stable
from .whitening import lower_solved

#: Healthy conditions needed: what grows with the speed shows at three or more.
LEAST_CONDITIONS = 3
#: Terms at most, and by how much each must raise the logarithm of the evidence, beside that of how many were tried.
MOST_TERMS, LEAST_GAIN = 8, 5.0
#: What every machine has, only not how much: unbalance of each rotor, run-out of each coupling; and how much likelier
#: that is than a given change of a support.
USUAL, ODDS = frozenset(effect.NAME for effect, _, _ in TURNING), 20.0
#: Terms are kept where all of them together leave at most this share of what was missed.
MUCH_LESS = 0.7
#: Standard deviations of half of a 90 % interval.
SIGMAS_OF_90 = 1.6449


@dataclass(frozen=True, eq=False)
class Extended:
    """A machine with what its model lacks.

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
        Share of a probe's healthy lines that the calibrated machine misses without and with them, median of the probes.
    """

    machine: Machine
    added: tuple[Coordinate, ...]
    at_healthy: Baseline
    covariance: np.ndarray
    missed_before: float
    missed: float


def extended(
    placed: Placed,
    healthy: OrderLines,
    predictor: Predictor,
    *,
    reference_rpm: float,
    tell: Callable[[str], None] = lambda _: None,
) -> Extended:
    """Return the machine with what its healthy lines ask for beside it; often nothing.

    Parameters
    ----------
    placed : Placed
        Calibrated on the healthy lines.
    healthy : OrderLines
        Their phases counted from the machine's zero.
    predictor : Predictor
        For the healthy conditions.
    reference_rpm : float
        Highest speed of all recordings.
    """
    found = placed.at_healthy
    start = state = _State(placed.machine, (), found, placed.free)
    speeds = sorted({*(one.speed_rpm for one in healthy.conditions), reference_rpm})
    able = predictor.repeats(placed.machine) and len(healthy.conditions) >= LEAST_CONDITIONS
    for count in range(MOST_TERMS if able else 0):
        tell(f"what the model lacks when healthy, term {count + 1}")
        terms = lacking_terms(state.current, predictor, reference_rpm=reference_rpm)
        further = _grown(state, terms, healthy, predictor, speeds)
        if further is None or evidence(further.current, healthy) < evidence(state.current, healthy) + LEAST_GAIN:
            break
        state = further
    while state.terms and (weakest := _not_needed(state, healthy)) is not None:
        kept = tuple(term for i, term in enumerate(state.terms) if i != weakest)
        state = state.changed(kept, healthy, predictor)
    if len(state.terms) > 1:
        again = state.changed(state.terms, healthy, predictor, afresh=True)
        state = max((state, again), key=lambda one: one.evidence(healthy))
    if state.terms and not state.runs(speeds):
        state = start
    before = _missed(found, healthy)
    if _missed(state.current, healthy) > MUCH_LESS * before:
        # What the evidence asks for there are small lines; what is missed is something else.
        state = start
    return Extended(
        machine=state.with_terms()[0],
        added=state.with_terms()[1],
        at_healthy=state.current,
        covariance=unknowns_covariance(state.current, healthy),
        missed_before=before,
        missed=_missed(state.current, healthy),
    )


@dataclass(frozen=True, eq=False)
class _State:
    """The machine as given, the terms that it has now, and where both are calibrated."""

    machine: Machine
    terms: tuple[Term, ...]
    current: Baseline
    free: tuple[Coordinate, ...]

    def with_terms(self) -> tuple[Machine, tuple[Coordinate, ...]]:
        """Return the machine with the terms at zero, and their coordinates."""
        first = len(self.machine.effects)
        coordinates = tuple(c for i, term in enumerate(self.terms) for c in term.coordinates(first + i))
        return self.machine.with_effects(*(term.effect for term in self.terms)), coordinates

    def evidence(self, healthy: OrderLines) -> float:
        """Return the logarithm of the evidence, with what is likely of any machine, up to a constant."""
        usual = sum(term.effect.NAME in USUAL for term in self.terms)
        return evidence(self.current, healthy) + usual * math.log(ODDS)

    def runs(self, speeds_rpm: Sequence[float]) -> bool:
        """Return whether the calibrated machine is stable, or was not so as given."""
        return is_stable(self.current.machine, speeds_rpm) or not is_stable(self.machine, speeds_rpm)

    @property
    def first(self) -> int:
        """Number of the first coordinate of the terms."""
        return len(self.current.coordinates) - sum(len(term.strengths) for term in self.terms)

    @property
    def parts(self) -> list[slice]:
        """Coordinates of each term."""
        ends = self.first + np.cumsum([0, *(len(term.strengths) for term in self.terms)])
        return [slice(int(a), int(b)) for a, b in itertools.pairwise(ends)]

    def changed(
        self, terms: tuple[Term, ...], healthy: OrderLines, predictor: Predictor, *, afresh: bool = False
    ) -> _State:
        """Return the state with other terms, calibrated from where this one is, or from the machine as given.

        Parameters that made up for what was lacking may lie beyond a hill from where they belong.
        """
        first = self.first
        known = {term: self.current.position[part] for term, part in zip(self.terms, self.parts, strict=True)}
        begin = [known.get(term, np.zeros(len(term.strengths))) for term in terms]
        own = self.current.given if afresh else self.current.position
        begin = np.concatenate([own[:first], *begin])
        there = replace(self, terms=terms)
        machine, coordinates = there.with_terms()
        return replace(there, current=calibrated(machine, healthy, predictor, (*self.free, *coordinates), begin=begin))


def _grown(
    state: _State, terms: Sequence[Term], healthy: OrderLines, predictor: Predictor, speeds_rpm: Sequence[float]
) -> _State | None:
    """Return the state with the best further term; None where none promises enough or none leaves it stable."""
    tried = _worth_trying(_gains(state.current, healthy, terms), terms)
    # What slopes promise is not what is there: each is calibrated, the first one from the machine as given.
    grown = [state.changed((*state.terms, one), healthy, predictor, afresh=not state.terms) for one in tried]
    return max((one for one in grown if one.runs(speeds_rpm)), key=lambda one: one.evidence(healthy), default=None)


def _worth_trying(gains: np.ndarray, terms: Sequence[Term]) -> list[Term]:
    """Return the best term of those that every machine has, and of the others, where they promise enough."""
    usual = np.array([term.effect.NAME in USUAL for term in terms], dtype=bool)
    found = []
    for kind in (usual, ~usual):
        best = int(np.argmax(np.where(kind, gains, -math.inf))) if kind.any() else None
        if best is not None and gains[best] >= LEAST_GAIN + math.log(len(terms)):
            found.append(terms[best])
    return found


def _not_needed(state: _State, healthy: OrderLines) -> int | None:
    """Return the number of the term that the evidence needs least, None where it needs all.

    By the densities of its strength at zero before and after the healthy lines (J. M. Dickey, Annals of Mathematical
    Statistics 42 (1971) 204).
    """
    covariance = unknowns_covariance(state.current, healthy)
    needed = []
    for part in state.parts:
        position, own = state.current.position[part], covariance[part, part]
        needed.append(0.5 * float(position @ np.linalg.solve(own, position)) + 0.5 * np.linalg.slogdet(own)[1])
    return int(np.argmin(needed)) if min(needed) < LEAST_GAIN else None


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
        power, reference = law.get("speed_exponent", 0.0), law.get("reference_speed_rpm", 0.0)
        terms.append(LackingTerm(effect.NAME, effect.at, name, power, reference, value))
    return ModelForm(tuple(terms), found.missed_before, found.missed)


def _gains(current: Baseline, healthy: OrderLines, terms: Sequence[Term]) -> np.ndarray:
    """Return by how much each term raises the logarithm of the evidence, shape (terms,)."""
    if not terms:
        return np.zeros(0)
    slopes = [stacked(term.slopes, healthy.parts).T for term in terms]
    plain, with_term = [], []
    for factor in ERROR_FACTORS:
        lower, white, density = whitened(current, healthy, factor)
        plain.append(density)
        with_term.append([density + raised(lower_solved(lower, own), white) for own in slopes])
    return np.max(with_term, axis=0) - max(plain)


def _missed(current: Baseline, healthy: OrderLines) -> float:
    """Return the share of a probe's healthy lines that the machine misses, the median of the probes."""
    seen = healthy.seen & (np.abs(healthy.amplitudes) > 3 * np.where(healthy.seen, healthy.deviations, np.inf))
    size = np.where(seen, np.abs(healthy.amplitudes) ** 2, 0.0).sum(axis=(0, 2))
    left = np.where(seen, np.abs(healthy.amplitudes - current.lines) ** 2, 0.0).sum(axis=(0, 2))
    return float(np.median(np.sqrt(left[size > 0] / size[size > 0]))) if (size > 0).any() else 0.0

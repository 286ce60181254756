"""What the model of a healthy machine lacks, told by healthy recordings before anything is diagnosed.

A machine whose model is wrong in form misses its healthy lines whatever its parameters are, and every fault is then
looked for in the wrong machine. All terms (`lacking_terms.py`) that the healthy lines ask for together
(`likely_terms.py`) join the machine, and are uncertain from then on like its own parameters; those that the evidence
does not need once all are calibrated leave again. By how much the model is wrong beside them is taken as likely as it
can be, so that a form which no term makes is no reason to add terms.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline, again, with_others
from .baseline import start as as_given
from .calibration import calibrated, settled
from .coordinates import Coordinate
from .healthy_evidence import evidence, fitted, is_explained
from .lacking_terms import Term, lacking_terms, missed_orders
from .likely_terms import TERM_GAIN, USUAL, likely_terms, needed_terms, price_of
from .lines import OrderLines, different_speeds
from .predict import Predictor
from .pulse_place import Placed
from .result import Estimate, LackingTerm, ModelForm
from .stable import is_stable

#: Healthy speeds needed for changes of supports: what grows with the speed shows at three or more.
LEAST_SPEEDS = 3
#: Rounds in which terms are chosen.
ROUNDS = 3
#: Changes of supports are kept where all terms together leave at most this share of what was missed.
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
    price : float
        By how much the terms had to raise the logarithm of the evidence.
    """

    machine: Machine
    added: tuple[Coordinate, ...]
    at_healthy: Baseline
    covariance: np.ndarray
    missed_before: float
    missed: float
    price: float


def extended(
    placed: Placed,
    healthy: OrderLines,
    predictor: Predictor,
    *,
    reference_rpm: float,
    known: float = -math.inf,
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
    known : float
        Evidence of the machine with what it lacks at another place of the pulse: one that is farther from it with all
        terms than these have brought is not followed.
    """
    start = _State(placed.machine, (), placed.at_healthy, placed.free)
    speeds = sorted({*(one.speed_rpm for one in healthy.conditions), reference_rpm})
    state = _grown(start, healthy, predictor, speeds, known=known, tell=tell)
    given_up = state is start and known > -math.inf
    if predictor.repeats(placed.machine) and not (given_up or is_explained(state.current, healthy)):
        # Parameters that made up for what was lacking lie on a hill of their own, and what is lacking beside them is
        # something else than beside the machine as given.
        begin = replace(start, current=as_given(placed.machine, predictor, placed.free))
        other = _grown(begin, healthy, predictor, speeds, known=known, tell=tell)
        if evidence(other.current, healthy) >= evidence(state.current, healthy) + TERM_GAIN:
            state = other
    state = _kept(state, start, healthy, predictor, speeds)
    return Extended(
        machine=state.with_terms()[0],
        added=state.with_terms()[1],
        at_healthy=state.current,
        covariance=fitted(state.current, healthy)[1],
        missed_before=_missed(start.current, healthy),
        missed=_missed(state.current, healthy),
        price=sum(map(price_of, state.terms)),
    )


def _grown(
    state: _State,
    healthy: OrderLines,
    predictor: Predictor,
    speeds_rpm: Sequence[float],
    *,
    known: float,
    tell: Callable[[str], None],
) -> _State:
    """Return the state with the terms that its lines ask for, chosen in a few rounds."""
    repeats, reference = predictor.repeats(state.machine), speeds_rpm[-1]
    # How an unbalance grows with the speed is known; how a spring does, only several speeds tell.
    only = None if repeats and different_speeds(healthy.conditions) >= LEAST_SPEEDS else USUAL
    for count in range(ROUNDS if repeats else 1):
        tell(f"what the model lacks when healthy, round {count + 1}")
        missed = missed_orders(state.current, healthy)
        terms = lacking_terms(state.current, predictor, reference_rpm=reference, only=only, missed=missed)
        # Of what every machine has, slopes over sizes that are near 0 do not say what is needed: priors hold it there.
        further = likely_terms(state.current, healthy, terms) if repeats else terms
        if not further:
            break
        # What slopes promise is not what is there; parameters that made up for it first go back to where they were.
        grown = state.changed((*state.terms, *further), healthy, predictor, afresh=not state.terms)
        reached = evidence(grown.current, healthy)
        if known - reached > max(reached - evidence(state.current, healthy), TERM_GAIN):
            break
        grown = _pruned(grown, healthy, predictor, speeds_rpm) if repeats else grown.afresh(healthy, predictor)
        if evidence(grown.current, healthy) < evidence(state.current, healthy) + TERM_GAIN:
            break
        state = grown
    return state


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
        if not predictor.repeats(self.machine):
            return self._with(terms, healthy, predictor)
        first = self.first
        known = {term: self.current.position[part] for term, part in zip(self.terms, self.parts, strict=True)}
        begin = [known.get(term, np.zeros(len(term.strengths))) for term in terms]
        own = self.current.given if afresh else self.current.position
        begin = np.concatenate([own[:first], *begin])
        there = replace(self, terms=terms)
        machine, coordinates = there.with_terms()
        return replace(there, current=calibrated(machine, healthy, predictor, (*self.free, *coordinates), begin=begin))

    def _with(self, terms: tuple[Term, ...], healthy: OrderLines, predictor: Predictor) -> _State:
        """Return the state with other terms where each slope is a simulation: those that are known have to do."""
        known = {
            term: (self.current.position[part], self.current.slopes[part])
            for term, part in zip(self.terms, self.parts, strict=True)
        }
        there, others = replace(self, terms=terms), []
        machine, coordinates = there.with_terms()
        for term in terms:
            others += zip(*known.get(term, (np.zeros(len(term.strengths)), term.slopes)), strict=True)
        joined = [(one, float(where), slopes) for one, (where, slopes) in zip(coordinates, others, strict=True)]
        begin = with_others(self.current, machine, self.first, joined, predictor)
        return replace(there, current=settled(begin, machine, healthy, predictor))

    def afresh(self, healthy: OrderLines, predictor: Predictor) -> _State:
        """Return the state calibrated once more, by the slopes of where it is."""
        machine = self.with_terms()[0]
        return replace(self, current=settled(again(self.current, machine, predictor), machine, healthy, predictor))


def _kept(
    state: _State, start: _State, healthy: OrderLines, predictor: Predictor, speeds_rpm: Sequence[float]
) -> _State:
    """Return the state where it takes away enough of what is missed; else with unbalance and turning forces alone.

    What the evidence asks for otherwise are small lines; what is missed is something else. Unbalance and forces that
    turn with the shaft do not change how the machine answers, and stay, where they are asked for at all.
    """
    if _missed(state.current, healthy) <= MUCH_LESS * _missed(start.current, healthy):
        return state
    usual = tuple(term for term in state.terms if term.effect.NAME in USUAL)
    if len(usual) < len(state.terms):
        state = _pruned(start.changed(usual, healthy, predictor, afresh=True), healthy, predictor, speeds_rpm)
    return state if evidence(state.current, healthy) >= evidence(start.current, healthy) + TERM_GAIN else start


def _pruned(state: _State, healthy: OrderLines, predictor: Predictor, speeds_rpm: Sequence[float]) -> _State:
    """Return the state without the terms that the evidence does not need, nor those that leave it unstable."""
    while state.terms:
        runs = state.runs(speeds_rpm) or all(term.effect.NAME in USUAL for term in state.terms)
        kept = needed_terms(state.current, healthy, state.terms, state.parts)
        fewer = state.changed(tuple(kept), healthy, predictor) if len(kept) < len(state.terms) else None
        # What slopes say of a term, its calibration need not bear out.
        if fewer is None or _loses(fewer, state, healthy):
            if runs:
                break
            fewer = state.changed(_without_weakest(state, healthy), healthy, predictor)
        state = fewer
    return state


def _loses(fewer: _State, state: _State, healthy: OrderLines) -> bool:
    """Return whether a state with fewer terms has lost more evidence than these had to bring."""
    price = sum(price_of(term) for term in state.terms if term not in fewer.terms)
    return evidence(fewer.current, healthy) < evidence(state.current, healthy) - price


def _without_weakest(state: _State, healthy: OrderLines) -> tuple[Term, ...]:
    """Return the terms but for that change of a support which is known least, as a share of what is uncertain of it.

    Unbalance and forces that turn with the shaft leave no machine unstable.
    """
    covariance = fitted(state.current, healthy)[1]
    size = []
    for term, part in zip(state.terms, state.parts, strict=True):
        position = state.current.position[part]
        told = float(position @ np.linalg.solve(covariance[part, part], position))
        size.append(math.inf if term.effect.NAME in USUAL else told)
    return tuple(term for i, term in enumerate(state.terms) if i != int(np.argmin(size)))


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
        terms.append(LackingTerm(effect.NAME, effect.at, name, power, reference, value, law.get("order")))
    return ModelForm(tuple(terms), found.missed_before, found.missed)


def _missed(current: Baseline, healthy: OrderLines) -> float:
    """Return the share of a probe's healthy lines that the machine misses, the median of the probes."""
    seen = healthy.seen & (np.abs(healthy.amplitudes) > 3 * np.where(healthy.seen, healthy.deviations, np.inf))
    size = np.where(seen, np.abs(healthy.amplitudes) ** 2, 0.0).sum(axis=(0, 2))
    left = np.where(seen, np.abs(healthy.amplitudes - current.lines) ** 2, 0.0).sum(axis=(0, 2))
    return float(np.median(np.sqrt(left[size > 0] / size[size > 0]))) if (size > 0).any() else 0.0

"""What a model may lack of a healthy machine: springs and dampers at supports, unbalance, forces, weight, a mesh's own.

Springs stand between a support and the ground: alike or unlike in x and y, or cross-coupled, constant or growing with
the speed or its square. An unbalance, a coupling's force, a gear's run-out has two strengths, its components; so has
the error of all teeth at each multiple of the mesh. What acts on every machine of the kind (`Effect.PERMANENT`:
gravity) may be there although the machine is given without it: a coupling whose stiffness turns makes lines of the sag.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.assembly import Place
from ...simulators.effect import Effect, effect_catalogue
from ...simulators.effects.empirical_mesh import EmpiricalMesh
from ...simulators.effects.empirical_stiffness import EmpiricalStiffness
from ...simulators.effects.residual_coupling_force import ResidualCouplingForce
from ...simulators.effects.residual_coupling_harmonic import FORCES, MOMENTS, ResidualCouplingHarmonic
from ...simulators.effects.residual_gear_run_out import ResidualGearRunOut
from ...simulators.effects.residual_unbalance import ResidualUnbalance
from ...simulators.errors import RotorwiseError
from ...simulators.machine import Machine
from ...simulators.parameter import Normal
from .baseline import Baseline
from .coordinates import Coordinate
from .lines import OrderLines
from .predict import Predictor

#: Powers of the speed that are tried for each strength of a support.
EXPONENTS: dict[str, tuple[float, ...]] = {
    **dict.fromkeys(("stiffness_n_m", "difference_n_m", "cross_n_m"), (0.0, 1.0, 2.0)),
    "damping_n_s_m": (0.0,),
}
#: What turns with the shaft: at places of which role, and its components.
TURNING: tuple[tuple[type[Effect], str, tuple[str, str]], ...] = (
    (ResidualUnbalance, "rotor", ("moment_x_kg_m", "moment_y_kg_m")),
    (ResidualCouplingForce, "coupling", ("force_x_n", "force_y_n")),
    (ResidualGearRunOut, "gear", ("sine_m", "cosine_m")),
)
#: Multiples of a revolution of what the halves of a coupling push each other with, and its components.
COUPLING_ORDERS = (1.0, 2.0, 3.0)
BETWEEN_HALVES = (
    *((f"{way}_cosine_n", f"{way}_sine_n") for way in FORCES),
    *((f"{way}_cosine_n_m", f"{way}_sine_n_m") for way in MOMENTS),
)
#: A healthy line is missed where the machine is so many of its deviations away.
CLEAR = 5.0
#: What is fitted together of a mesh.
MESH = (*((f"{n}_sine_m", f"{n}_cosine_m") for n in ("first", "second", "third")), ("stiffness_share",))
#: Roles of the places where a support may be wrong.
SUPPORTS = frozenset({"bearing", "housing"})
#: One standard deviation of a strength moves the lines of some probe by this share.
MOVES = 0.3
#: Step for the slopes: as large a share of the lines of the probe that moves most.
STEP = 1e-3
FIRST_TRY = {
    **dict.fromkeys(EXPONENTS, 100.0),
    "damping_n_s_m": 1.0,
    **dict.fromkeys(("moment_x_kg_m", "moment_y_kg_m"), 1e-6),
    **dict.fromkeys(("force_x_n", "force_y_n"), 0.01),
}


@dataclass(frozen=True, eq=False)
class Term:
    """Something that may be added.

    Attributes
    ----------
    effect : Effect
        With all its strengths at zero.
    strengths : tuple of str
        Those that are fitted.
    deviation : float
        Standard deviation of each before any measurement.
    slopes : ndarray (strengths, conditions, probes, orders), complex
        What one standard deviation of each moves.
    """

    effect: Effect
    strengths: tuple[str, ...]
    deviation: float
    slopes: np.ndarray

    def coordinates(self, number: int) -> tuple[Coordinate, ...]:
        """Return its coordinates as the machine's effect of this number."""
        declared = {one.name: one for one in self.effect.parameters()}
        prior = Normal(0.0, self.deviation)
        return tuple(Coordinate(replace(declared[name], prior=prior), number) for name in self.strengths)


def lacking_terms(
    current: Baseline,
    predictor: Predictor,
    *,
    reference_rpm: float,
    only: frozenset[str] | None = None,
    missed: frozenset[float] = frozenset(COUPLING_ORDERS),
) -> list[Term]:
    """Return what can be added to a machine, but for what has been.

    Parameters
    ----------
    current : Baseline
        Calibrated, in the predictor's conditions.
    predictor : Predictor
    reference_rpm : float
        From this speed on nothing grows: the highest of all recordings.
    only : frozenset of str, optional
        Names of the effects that are looked at.
    missed : frozenset of float
        Orders that the machine misses, see `missed_orders`: a coupling is asked for forces at these only.
    """
    tried = [
        (effect, strengths)
        for effect, strengths in _options(current.machine, reference_rpm, missed)
        if (only is None or effect.NAME in only)
        and not any(_is_same(effect, strengths, other) for other in current.machine.effects)
    ]
    if not predictor.repeats(current.machine):
        return _in_time(current, tried, predictor)
    first = _changes(current, tried, [_first_try(*one) for one in tried], predictor)
    steps = [_step(*one, size) for one, size in zip(tried, _sizes(first, current.lines), strict=True)]
    moving = [(one, step) for one, step in zip(tried, steps, strict=True) if step > 0]
    second = _changes(current, [one for one, _ in moving], [step for _, step in moving], predictor)
    found = []
    for ((effect, strengths), step), change in zip(moving, second, strict=True):
        deviation = _usual_size(effect) or step * MOVES / _sizes([change], current.lines)[0]
        found.append(Term(effect, strengths, deviation, change / step * deviation))
    return found


def _in_time(current: Baseline, tried: Sequence[tuple[Effect, tuple[str, ...]]], predictor: Predictor) -> list[Term]:
    """Return the terms that move lines at all, with slopes over the size that such things commonly have.

    Where every change is a simulation, none is spent on finding a size; and sizes of lines without phase, near 0 in a
    sound machine, have no slope there that would tell what a usual strength does.
    """
    usual = [_common_size(*one) for one in tried]
    changes = _changes(current, tried, usual, predictor)
    every = zip(tried, usual, changes, _sizes(changes, current.lines), strict=True)
    return [Term(effect, names, size, change) for (effect, names), size, change, moves in every if moves > STEP]


def _common_size(effect: Effect, strengths: tuple[str, ...]) -> float:
    """Return the size that the prior of an effect's last strength states."""
    (prior,) = (one.prior for one in effect.parameters() if one.name == strengths[-1])
    assert isinstance(prior, Normal)
    return abs(prior.mean) or prior.deviation


def _first_try(effect: Effect, strengths: tuple[str, ...]) -> float:
    usual = _usual_size(effect)
    if usual is None and strengths[0] in FIRST_TRY:
        return FIRST_TRY[strengths[0]]
    return STEP * (usual or _common_size(effect, strengths))


def _step(effect: Effect, strengths: tuple[str, ...], size: float) -> float:
    """Return the step for the slopes in a term of which the first try moves the lines by ``size``; 0 of what does not.

    What acts on every machine may move next to nothing: a strength that would move more is none that it can have.
    """
    first = _first_try(effect, strengths)
    if _usual_size(effect) is not None:
        return first if size > STEP**2 else 0.0
    step = first * STEP / size if size > 0 else math.inf
    (most,) = (one.bounds[1] for one in effect.parameters() if one.name == strengths[0])
    # What moves lines by rounding alone would have to be larger than it can be.
    return step if step * MOVES / STEP < most else 0.0


def slopes_in(terms: Sequence[Term], current: Baseline, predictor: Predictor) -> list[np.ndarray]:
    """Return what one standard deviation of each term's strengths moves in the predictor's conditions.

    ``current`` is the machine in these.
    """
    tried = [(term.effect, term.strengths) for term in terms]
    # The step that moved the lines of some probe by `STEP` where the terms were made.
    share = STEP / MOVES
    changes = _changes(current, tried, [share * term.deviation for term in terms], predictor)
    return [change / share for change in changes]


def missed_orders(current: Baseline, healthy: OrderLines) -> frozenset[float]:
    """Return the orders whose healthy lines stand out, in two conditions, of what the machine makes of them."""
    left = np.where(healthy.seen, np.abs(healthy.amplitudes - current.lines), 0.0)
    clear = (left > CLEAR * np.where(healthy.seen, healthy.deviations, np.inf)).any(axis=1).sum(axis=0)
    phase = [kind.phase for kind in healthy.kinds]
    return frozenset(o for o, own, count in zip(healthy.orders, phase, clear, strict=True) if own and count > 1)


def _options(machine: Machine, reference_rpm: float, missed: frozenset[float]) -> list[tuple[Effect, tuple[str, ...]]]:
    every = [p for p in machine.bare_assembly().places.values() if {"x", "y"} <= set(p.directions)]
    found: list[tuple[Effect, tuple[str, ...]]] = []
    for place in every:
        if SUPPORTS & place.roles:
            found += _springs(place, reference_rpm)
        for kind, role, components in TURNING:
            if role in place.roles:
                found.append((kind(at=place.name, **dict.fromkeys(components, 0.0)), components))
    return found + _couplings(machine, missed) + _meshes(machine) + _permanent(machine)


def _couplings(machine: Machine, missed: frozenset[float]) -> list[tuple[Effect, tuple[str, ...]]]:
    """Return what the halves of each coupling that has both in the model may push each other with."""
    names = dict.fromkeys(itertools.chain(*BETWEEN_HALVES), 0.0)
    parts = machine.bare_assembly().components.values()
    return [
        (ResidualCouplingHarmonic(at=part.name, order=order, **names), pair)
        for part in parts
        if ResidualCouplingHarmonic.ROLE in part.roles
        for order in COUPLING_ORDERS
        if order in missed
        for pair in BETWEEN_HALVES
    ]


def _meshes(machine: Machine) -> list[tuple[Effect, tuple[str, ...]]]:
    """Return what a mesh whose teeth are known may lack: the same at both gears."""
    assembly = machine.bare_assembly()
    gears = [place.name for place in assembly.places.values() if EmpiricalMesh.ROLE in place.roles]
    effect = EmpiricalMesh(at=gears[0] if gears else "", **dict.fromkeys(itertools.chain(*MESH), 0.0))
    return [(effect, strengths) for strengths in MESH] if acts(effect, machine) else []


def acts(effect: Effect, machine: Machine) -> bool:
    """Return whether the machine has the parts on which an effect acts."""
    try:
        effect.contribute(machine.bare_assembly())
    except RotorwiseError:
        return False
    return True


def _permanent(machine: Machine) -> list[tuple[Effect, tuple[str, ...]]]:
    """Return what acts on every machine of the kind, but not on this one as it is given."""
    found: list[tuple[Effect, tuple[str, ...]]] = []
    for effect in (kind() for kind in effect_catalogue().values() if kind.PERMANENT):
        if not acts(effect, machine):
            continue
        strengths = tuple(one.name for one in effect.parameters() if one.zero is not None)
        found.append((effect.with_values(**dict.fromkeys(strengths, 0.0)), strengths))
    return found


def _usual_size(effect: Effect) -> float | None:
    """Return how strong what acts on every machine is; None of what has no size of its own."""
    sizes = [one.prior.median for one in effect.parameters() if effect.PERMANENT and one.prior is not None]
    return max(map(abs, sizes), default=None)


def _springs(place: Place, reference_rpm: float) -> list[tuple[Effect, tuple[str, ...]]]:
    nothing = dict.fromkeys(EXPONENTS, 0.0)
    return [
        (
            EmpiricalStiffness(at=place.name, speed_exponent=power, reference_speed_rpm=reference_rpm, **nothing),
            (strength,),
        )
        for strength, powers in EXPONENTS.items()
        for power in powers
    ]


def _is_same(one: Effect, strengths: tuple[str, ...], other: Effect) -> bool:
    if (one.NAME, one.at) != (other.NAME, other.at):
        return False
    own, others = one.values(), other.values()
    alike = all(own[name] == others[name] for name in own if name not in strengths)
    return alike and any(others[name] != 0.0 for name in strengths)


def _changes(
    current: Baseline, tried: Sequence[tuple[Effect, tuple[str, ...]]], steps: Sequence[float], predictor: Predictor
) -> list[np.ndarray]:
    """Return by how much the lines change with each strength at its step, each (strengths, ...)."""
    machines = [
        [current.machine.with_effects(effect.with_values(**{name: step})) for name in strengths]
        for (effect, strengths), step in zip(tried, steps, strict=True)
    ]
    predictor.prepare([one for own in machines for one in own])
    return [np.stack([predictor.amplitudes(one) - current.lines for one in own]) for own in machines]


def _sizes(changes: Sequence[np.ndarray], lines: np.ndarray) -> list[float]:
    """Return each change as a share of the lines of the probe where that is largest, of its strongest strength."""
    whole = np.sqrt((np.abs(lines) ** 2).sum(axis=(0, 2)))
    there = whole > 0
    return [
        float((np.sqrt((np.abs(one) ** 2).sum(axis=(1, 3)))[:, there] / whole[there]).max(initial=0.0))
        for one in changes
    ]

"""The machine as the model knows it, with what is uncertain in it: its own parameters and the gains of the probes.

Lines y = (1 + g) h(z) + model error + noise. z are the machine's parameters with a prior, in standard coordinates; g is
one complex gain error a probe; the model error of each order at each probe is a random function of speed, and may have
the shape of what a model can lack (`form_error.py`). Recordings of the healthy machine fix all as far as they can
(`healthy_machine.py`), and what is left of the uncertainty is part of every later comparison.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.machine import Machine
from ...simulators.parameter import LogNormal, Normal, Parameter
from .coordinates import Coordinate, coordinates_of
from .predict import Predictor
from .size_scale import gained

#: Relative standard deviation of a probe's gain (real and imaginary part): accelerometers and amplifiers in use.
GAIN_DEVIATION = 0.02
#: Relative change of a machine's parameters, and of the probes' gains, between healthy and later recordings.
DRIFT, GAIN_DRIFT = 0.005, 0.002
#: Standard deviation, in rad, that stands for a free angle.
FREE_ANGLE = 1.8
#: A parameter that moves every line by less than this share of its probe's vibration, within its prior, is left alone.
NEGLIGIBLE = 2e-3
#: Steps of the slopes in standard coordinates: of periodic motions, and of motions simulated in time.
STEP, STEP_IN_TIME = 1e-3, 0.1
#: Relative standard deviation of what no prior is given for, by unit: dimensions evenly within 1 %; a material's
#: constants; stiffness, a controller's gains and times, computed or from a data sheet; damping, which nobody computes.
#: Of pure numbers, angles and loads none.
KNOWN_WITHIN = {
    **dict.fromkeys(("m", "kg", "kg.m2", "kg.m"), 0.0058),
    **dict.fromkeys(("Pa", "kg/m3"), 0.01),
    **dict.fromkeys(("N/m", "N.m/rad", "N/A", "V/m", "A/V", "s", "1/s"), 0.03),
    **dict.fromkeys(("N.s/m", "N.m.s/rad"), 0.2),
}


@dataclass(frozen=True, eq=False)
class Baseline:
    """A machine, what it shows, and how that depends on what is uncertain.

    Attributes
    ----------
    machine : Machine
    coordinates : tuple of Coordinate
        Of the machine's uncertain parameters.
    position, given : ndarray (coordinates,)
        Where they are, and where the machine as given has them: the middle of their prior.
    active : ndarray (coordinates,), bool
        Which of them move the lines without any effect; the slopes of the others are taken as 0.
    lines : ndarray (conditions, probes, orders), complex
        What the machine shows at ``position``.
    slopes : ndarray (unknowns, conditions, probes, orders), complex
        Derivatives in the coordinates, in the real and imaginary part of each probe's gain, then in what else may be
        wrong (`form_error.py`).
    prior : ndarray (unknowns,)
        Standard deviations before any measurement, about ``prior_mean``.
    prior_mean : ndarray (unknowns,)
        Relative to ``position`` and gain 1.
    drift : ndarray (unknowns,)
        Standard deviations of their change between the healthy recordings and the others.
    """

    machine: Machine
    coordinates: tuple[Coordinate, ...]
    position: np.ndarray
    given: np.ndarray
    active: np.ndarray
    lines: np.ndarray
    slopes: np.ndarray
    prior: np.ndarray
    prior_mean: np.ndarray
    drift: np.ndarray

    @property
    def further(self) -> np.ndarray:
        """Slopes in what is uncertain beside the machine's coordinates and the gains."""
        return self.slopes[len(self.coordinates) + 2 * self.lines.shape[1] :]


def machine_at(machine: Machine, coordinates: tuple[Coordinate, ...], position: np.ndarray) -> Machine:
    """Return the machine, and the effects that it is given with, with their uncertain parameters at a position."""
    effects = list(machine.effects)
    for coordinate, z in zip(coordinates, position, strict=True):
        if coordinate.effect is not None:
            moved = {coordinate.parameter.name: coordinate.value(float(z))}
            effects[coordinate.effect] = effects[coordinate.effect].with_values(**moved)
    own = [(c, float(z)) for c, z in zip(coordinates, position, strict=True) if c.effect is None]
    values = {c.parameter.name: c.value(z) for c, z in own}
    return replace(machine.with_parameters(**values), effects=tuple(effects))


def start(
    machine: Machine,
    predictor: Predictor,
    added: Sequence[Coordinate] = (),
    *,
    begin: np.ndarray | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> Baseline:
    """Return the machine as given, or at ``begin``, linearised; parameters that move nothing measured are not active.

    ``added`` are coordinates of effects that the machine is given with, or of its own parameters without a prior.
    """
    load = machine.definition.load_parameter
    values = machine.values
    own = coordinates_of([_uncertain(p, values[p.name]) for p in machine.definition.parameters if p.name != load])
    given = [c.coordinate(values[c.parameter.name]) for c in own]
    given += [c.coordinate(_value_in(machine, c)) for c in added]
    coordinates, given = (*own, *added), np.array(given)
    tell(f"slopes of {len(coordinates)} machine parameters")
    position, everything = given if begin is None else begin, np.ones(given.size, dtype=bool)
    found = linearised(machine, coordinates, position, given, everything, predictor)
    scale = np.sqrt(np.mean(np.abs(found.lines) ** 2, axis=(0, 2), keepdims=True)) * NEGLIGIBLE + 1e-300
    active = np.array([found.prior[i] * np.abs(found.slopes[i] / scale).max() > 1 for i in range(given.size)])
    slopes = found.slopes.copy()
    slopes[: given.size][~active] = 0.0
    return replace(found, active=active, slopes=slopes)


def _value_in(machine: Machine, coordinate: Coordinate) -> float:
    own = machine.values if coordinate.effect is None else machine.effects[coordinate.effect].values()
    return own[coordinate.parameter.name]


def _uncertain(parameter: Parameter, value: float) -> Parameter:
    """Return a quantity that is given as one that is known as well as such quantities are."""
    if parameter.prior is not None or parameter.unit not in KNOWN_WITHIN or value == 0:
        return parameter
    deviation = KNOWN_WITHIN[parameter.unit]
    prior = LogNormal(value, 1 + deviation) if value > 0 else Normal(value, deviation * abs(value))
    return replace(parameter, prior=prior)


def linearised(
    machine: Machine,
    coordinates: tuple[Coordinate, ...],
    position: np.ndarray,
    given: np.ndarray,
    active: np.ndarray,
    predictor: Predictor,
    further: np.ndarray | None = None,
) -> Baseline:
    """Return the machine at a position of its coordinates with its slopes there.

    ``further`` are slopes (errors, conditions, probes, orders) in what else may be wrong.
    """
    here = machine_at(machine, coordinates, position)
    lines = predictor.amplitudes(here)
    slopes = np.zeros((len(coordinates), *lines.shape), dtype=complex)
    reach = STEP if predictor.repeats(here) else STEP_IN_TIME
    steps, beside = {}, {}
    for i in np.flatnonzero(active):
        free = coordinates[i].value(position[i] + reach) != coordinates[i].value(position[i])
        steps[i] = reach if free else -reach
        moved = position.copy()
        moved[i] += steps[i]
        beside[i] = machine_at(machine, coordinates, moved)
    predictor.prepare(list(beside.values()), near=here, lasting=True)
    for i, moved_machine in beside.items():
        slopes[i] = (predictor.amplitudes(moved_machine) - lines) / steps[i]
    probes = lines.shape[1]
    prior = [FREE_ANGLE if c.is_angle else 1.0 for c in coordinates] + [GAIN_DEVIATION] * (2 * probes)
    found = Baseline(
        machine=here,
        coordinates=coordinates,
        position=position,
        given=given,
        active=active,
        lines=lines,
        slopes=np.concatenate([slopes, _gain_slopes(lines, predictor)]),
        prior=np.array(prior),
        prior_mean=np.concatenate([given - position, np.zeros(2 * probes)]),
        drift=np.array(
            [_drift(c, z) for c, z in zip(coordinates, position, strict=True)] + [GAIN_DRIFT] * (2 * probes)
        ),
    )
    return widened_by(found, further) if further is not None and len(further) else found


def widened_by(baseline: Baseline, errors: np.ndarray) -> Baseline:
    """Return the baseline with further unknowns of mean 0 and deviation 1: slopes (errors, conditions, ...) in them."""
    count = len(errors)
    return replace(
        baseline,
        slopes=np.concatenate([baseline.slopes, errors]),
        prior=np.concatenate([baseline.prior, np.ones(count)]),
        prior_mean=np.concatenate([baseline.prior_mean, np.zeros(count)]),
        drift=np.concatenate([baseline.drift, np.zeros(count)]),
    )


def without_further(baseline: Baseline) -> Baseline:
    """Return the baseline without what `widened_by` has added."""
    kept = len(baseline.slopes) - len(baseline.further)
    parts = {name: getattr(baseline, name)[:kept] for name in ("slopes", "prior", "prior_mean", "drift")}
    return replace(baseline, **parts)


def _drift(coordinate: Coordinate, position: float) -> float:
    """Return the change of a coordinate that is a relative change of `DRIFT` of its parameter (radians of an angle)."""
    slope = (coordinate.value(position + STEP) - coordinate.value(position - STEP)) / (2 * STEP)
    size = 1.0 if coordinate.is_angle else abs(coordinate.value(position))
    return min(DRIFT * size / abs(slope), 1.0) if slope else 0.0


def shifted(baseline: Baseline, machine: Machine, change: np.ndarray, predictor: Predictor) -> Baseline:
    """Return the baseline with its coordinates changed; the slopes are kept, those of the gains follow the lines."""
    position = baseline.position + change
    here = machine_at(machine, baseline.coordinates, position)
    lines = predictor.amplitudes(here)
    own = position.size
    return replace(
        baseline,
        machine=here,
        position=position,
        lines=lines,
        slopes=np.concatenate([baseline.slopes[:own], _gain_slopes(lines, predictor), baseline.further]),
        prior_mean=np.concatenate([baseline.given - position, baseline.prior_mean[own:]]),
    )


def with_others(
    baseline: Baseline,
    machine: Machine,
    first: int,
    others: Sequence[tuple[Coordinate, float, np.ndarray]],
    predictor: Predictor,
) -> Baseline:
    """Return the baseline with other coordinates from the ``first`` on, without computing any slope.

    Parameters
    ----------
    machine : Machine
        With the effects that they belong to, at zero.
    others : sequence of (Coordinate, position, slopes)
        Slopes in the baseline's conditions. Each coordinate is given as 0.
    """
    old, own = baseline, baseline.position.size
    none = np.zeros(len(others))
    begin = np.append(old.position[:first], [where for _, where, _ in others])
    ones, open_still = np.ones(len(others)), [_drift(one, where) for one, where, _ in others]
    kept = replace(
        old,
        coordinates=(*old.coordinates[:first], *(one for one, _, _ in others)),
        position=begin,
        given=np.append(old.given[:first], none),
        active=np.append(old.active[:first], ones > 0),
        slopes=np.concatenate([old.slopes[:first], *(slopes[None] for _, _, slopes in others), old.slopes[own:]]),
        prior=np.concatenate([old.prior[:first], ones, old.prior[own:]]),
        prior_mean=np.concatenate([old.prior_mean[:first], none, old.prior_mean[own:]]),
        drift=np.concatenate([old.drift[:first], open_still, old.drift[own:]]),
    )
    return shifted(kept, machine, np.zeros(begin.size), predictor)


def again(baseline: Baseline, machine: Machine, predictor: Predictor) -> Baseline:
    """Return the baseline linearised anew at its position; ``machine`` may carry effects.

    ``predictor`` may be for other conditions where nothing else than the machine and the gains is uncertain.
    """
    own = (baseline.coordinates, baseline.position, baseline.given, baseline.active)
    return linearised(machine, *own, predictor, baseline.further)


def _gain_slopes(lines: np.ndarray, predictor: Predictor) -> np.ndarray:
    probes, lines = lines.shape[1], gained(lines, predictor.knees)
    gains = np.zeros((2 * probes, *lines.shape), dtype=complex)
    for probe in range(probes):
        gains[2 * probe, :, probe] = lines[:, probe]
        gains[2 * probe + 1, :, probe] = 1j * lines[:, probe]
    # Where phases are relative to a probe, the phase of that probe's gain turns all others the other way.
    untied = [i for i, one in enumerate(predictor.conditions) if not one.tied]
    for column, probe in enumerate(predictor.reference):
        gains[2 * probe + 1, untied, :, column] -= 1j * lines[untied, :, column]
    return gains

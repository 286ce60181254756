"""What shaft lines say about offset, angle and unbalance: a linear machine's response to one unit of each, inverted.

The lines of a linear machine are a sum over sources, A = sum_s c_s R_s, with R_s the lines of a unit of source s turned
by 0 and by 90 degrees and c_s two real numbers each. Least squares gives c_s; its length is the size, its angle the
phase. The tacho's mark sits anywhere on the shaft, so the angle between mark and coupling is looked for as well.

A machine that is stiffer or lighter than the simulated one has its modes higher: it responds about as the simulated
one does at a lower speed. That speed is fitted too, within `FARTHEST` and held near the true one by a prior.

Every set of sources is fitted: with several the sizes share the lines, alone each says "at most this", and the misfits
say which sets can be. The real machine still differs from the simulated one, so that sizes are features, not answers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ....simulators.effect import Effect
from ....simulators.effects.coupling_misalignment import CouplingMisalignment
from ....simulators.effects.unbalance import Unbalance
from ....simulators.machine import Machine
from ....simulators.solvers.harmonic_balance import harmonic_balance
from .feature_row import ShaftLines

#: Sources and the size, in SI units, at which their responses are computed.
SOURCES: Mapping[str, float] = {"offset": 1e-4, "angle": 1e-2, "unbalance": 1e-4}
#: Orders of the lines.
ORDERS = (1, 2, 3)
#: Relative error of a simulated line, and of a weak one as a share of the largest.
LINE_ERROR, SHARE_ERROR = 0.1, 3e-3
#: Highest order of the harmonic balance: its lines up to 3X are then exact to 1e-4 or better.
_HARMONICS = 6
#: Step of the simulated speeds, how far they go from the true one, and the standard deviation expected; all as log.
SPEED_STEP, FARTHEST, SPEED_PRIOR = 0.01, 0.22, 0.1
_MARKS = 2 * np.pi * np.arange(72) / 72
_SETS = tuple(names for count in (1, 2, 3) for names in combinations(SOURCES, count))
_LEAST = 1e-12


@dataclass(frozen=True, eq=False)
class SourceFit:
    """Sources that explain the lines of a record, by least squares.

    Attributes
    ----------
    vectors : mapping of str to complex
        Size times exp(i phase) of each source, in SI units.
    mark_rad : float
        By how much the tacho's mark (or the record's start) lags the simulation's angle 0.
    speed_rpm : float
        At which the simulated machine does this.
    misfit : float
        Root of the mean weighted square of what is left; 1 is an error of `LINE_ERROR` of every line.
    """

    vectors: Mapping[str, complex]
    mark_rad: float
    speed_rpm: float
    misfit: float


class UnitResponses:
    """Responses of a reference machine to its sources.

    Parameters
    ----------
    machine : Machine
        Linear, with a flexible coupling. Its own unbalance is set to zero: unbalance is one of the sources.
    probes : sequence of str
    """

    def __init__(self, machine: Machine, probes: Sequence[str]) -> None:
        own = {name: 0.0 for name in machine.values if name.endswith("unbalance_kg_m")}
        self.machine, self.probes = machine.with_parameters(**own), tuple(probes)
        self._known: dict[int, np.ndarray] = {}

    def speed_rpm(self, step: int) -> float:
        """Return a speed of the grid; a step is `SPEED_STEP` of the speed."""
        return float(np.exp(SPEED_STEP * step))

    def step(self, speed_rpm: float) -> int:
        """Return the number of the grid's nearest speed."""
        return round(float(np.log(speed_rpm)) / SPEED_STEP)

    def at(self, step: int) -> np.ndarray:
        """Return the lines of each source, shape (sources, 2, probes, orders): in SI units for a size of 1 SI unit."""
        speed = self.speed_rpm(step)
        if step not in self._known:
            healthy = self._lines((), speed)
            turned = [[self._lines((_effect(name, SOURCES[name], phase),), speed) for phase in (0.0, np.pi / 2)]
                      for name in SOURCES]  # fmt: skip
            sizes = np.array(list(SOURCES.values()))[:, None, None, None]
            self._known[step] = (np.array(turned) - healthy) / sizes
        return self._known[step]

    def _lines(self, effects: Sequence[Effect], speed_rpm: float) -> np.ndarray:
        motion = harmonic_balance(self.machine.with_effects(*effects), speed_rpm=speed_rpm, harmonics=_HARMONICS)
        names = [probe.name for probe in motion.probes]
        return motion.amplitudes[[names.index(probe) for probe in self.probes]][:, list(ORDERS)]

    def machine_with(self, vectors: Mapping[str, complex]) -> Machine:
        """Return the reference machine with sources of these sizes and phases."""
        offset, angle = (complex(vectors.get(name, 0.0)) for name in ("offset", "angle"))
        bounds = {declared.name: declared.bounds[1] for declared in CouplingMisalignment.parameters()}
        effects: list[Effect] = [
            CouplingMisalignment(
                offset_m=min(abs(offset), bounds["offset_m"]),
                angle_rad=min(abs(angle), bounds["angle_rad"]),
                offset_phase_rad=float(np.angle(offset)),
                angle_phase_rad=float(np.angle(angle)),
            )
        ]
        unbalance = complex(vectors.get("unbalance", 0.0))
        return self.machine.with_effects(*effects, _effect("unbalance", abs(unbalance), float(np.angle(unbalance))))


def _effect(source: str, size: float, phase_rad: float) -> Effect:
    if source == "unbalance":
        return Unbalance(moment_kg_m=size, angle_rad=phase_rad)
    offset, angle = (size if source == name else 0.0 for name in ("offset", "angle"))
    return CouplingMisalignment(offset_m=offset, angle_rad=angle, offset_phase_rad=phase_rad, angle_phase_rad=phase_rad)


def line_weights(lines: ShaftLines) -> np.ndarray:
    """Return one over the standard deviation of each line's real (and imaginary) part, shape (probes, orders)."""
    amplitudes, noise = lines.amplitudes, lines.noise
    size = np.abs(amplitudes)
    largest = float(size.max())
    return 1.0 / np.sqrt(noise**2 + (LINE_ERROR * size) ** 2 / 2 + (SHARE_ERROR * largest) ** 2 + _LEAST**2)


def fit_sources(
    responses: UnitResponses, lines: ShaftLines, *, sources: Sequence[str] = tuple(SOURCES), step: int | None = None
) -> SourceFit:
    """Return the sources that explain measured lines best.

    Parameters
    ----------
    responses : UnitResponses
    lines : ShaftLines
    sources : sequence of str
        Those that may act.
    step : int, optional
        Number of the simulated speed; looked for when left out.
    """
    if step is not None:
        return _fit_at(responses, lines, sources, step)
    middle, far = responses.step(lines.speed_rpm), round(FARTHEST / SPEED_STEP)
    # Neighbouring speeds hardly differ; every second one is enough.
    shifts = range(-far, far + 1, 2)
    fits = [_fit_at(responses, lines, sources, middle + shift) for shift in shifts]
    values = 2 * lines.amplitudes.size
    costs = [
        values * fit.misfit**2 + (SPEED_STEP * shift / SPEED_PRIOR) ** 2
        for fit, shift in zip(fits, shifts, strict=True)
    ]
    return fits[int(np.argmin(costs))]


def _fit_at(responses: UnitResponses, lines: ShaftLines, sources: Sequence[str], step: int) -> SourceFit:
    unit = responses.at(step)
    rows = [list(SOURCES).index(name) for name in sources]
    weights = line_weights(lines)
    matrix = _stacked((unit[rows] * weights).reshape(2 * len(rows), -1)).T
    scale = np.linalg.norm(matrix, axis=0) + _LEAST
    turned = lines.amplitudes * np.exp(1j * _MARKS[:, None, None] * np.array(ORDERS))
    wanted = _stacked((turned * weights).reshape(_MARKS.size, -1)).T
    inverse = np.linalg.pinv(matrix / scale, rcond=1e-8)
    found = inverse @ wanted
    left = ((wanted - (matrix / scale) @ found) ** 2).mean(axis=0)
    best = int(np.argmin(left))
    parts = (found[:, best] / scale).reshape(-1, 2)
    vectors = {name: complex(*part) for name, part in zip(sources, parts, strict=True)}
    return SourceFit(vectors, float(_MARKS[best]), responses.speed_rpm(step), float(np.sqrt(left[best])))


def _stacked(values: np.ndarray) -> np.ndarray:
    return np.hstack([np.real(values), np.imag(values)])


def source_features(responses: UnitResponses, lines: ShaftLines) -> dict[str, float]:
    """Return log10 of sizes and misfits for every set of sources, and the log of simulated over true speed.

    ``offset+angle.offset``, ``offset+angle.misfit``, ``speed_ratio``. All sets are fitted at the simulated speed that
    suits all sources together; ``unshifted.misfit`` is theirs at the true speed.
    """
    whole = fit_sources(responses, lines)
    step = responses.step(whole.speed_rpm)
    here = _fit_at(responses, lines, tuple(SOURCES), responses.step(lines.speed_rpm))
    values = {
        "speed_ratio": float(np.log(whole.speed_rpm / lines.speed_rpm)),
        "unshifted.misfit": float(np.log10(here.misfit + 1e-9)),
    }
    for names in _SETS:
        fit = _fit_at(responses, lines, names, step)
        key = "+".join(names)
        values[f"{key}.misfit"] = float(np.log10(fit.misfit + 1e-9))
        values |= {f"{key}.{name}": float(np.log10(abs(vector) + _LEAST)) for name, vector in fit.vectors.items()}
    return values

"""Interface forces: everything in a machine that is not its linear core.

A machine is y' = L y + B u(t, phase, C y). Each `InterfaceForce` reads a few rows of C y and adds to a few entries
of u. Its `Law` splits the work in two. *Signals* depend on time and shaft angle only; they are computed for many
instants at once with numpy. What depends on the motion is either linear in it, with the signals as coefficients
(`force` is None), or a small compiled function.

Linear laws serve time stepping, harmonic balance and Floquet analysis from the same signals.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .errors import InvalidValueError

#: A linear combination of degrees of freedom by name: {"disc.x": 1.0}.
Direction = Mapping[str, float]


#: So many evenly spaced instants share their cosines and sines with the first of them.
RUN = 64


@dataclass
class Timeline:
    """Instants at which signals are wanted, for several lanes (runs side by side).

    Attributes
    ----------
    time_s : ndarray, shape (instants, lanes)
    phase_rad, speed_rad_s, acceleration_rad_s2 : ndarray, shape (instants, lanes)
        Angle, speed and angular acceleration of the reference shaft.
    advance_rad : ndarray, optional
        Shape (lanes,): by how much the angle advances from each instant to the next where that is always the same,
        else not a number. Cosines and sines then cost little.
    """

    time_s: np.ndarray
    phase_rad: np.ndarray
    speed_rad_s: np.ndarray
    acceleration_rad_s2: np.ndarray
    advance_rad: np.ndarray | None = None
    _cached: dict[float, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    _whole: tuple[Timeline, Any] | None = None

    def select(self, lanes: np.ndarray) -> Timeline:
        """Return the timeline of some of its lanes; it shares the cosines and sines already computed."""
        if lanes.size == self.phase_rad.shape[1] and np.array_equal(lanes, np.arange(lanes.size)):
            return self
        index = (slice(None), lanes)
        return Timeline(
            self.time_s[index],
            self.phase_rad[index],
            self.speed_rad_s[index],
            self.acceleration_rad_s2[index],
            _whole=(self, index),
        )

    def cos_sin(self, order: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return cos and sin of ``order`` times the shaft angle; computed once for each scalar order."""
        if np.ndim(order):
            distinct = np.unique(order)
            if distinct.size > 1:
                return np.cos(order * self.phase_rad), np.sin(order * self.phase_rad)
            order = float(distinct[0])
        key = float(order)
        if key not in self._cached:
            if self._whole is not None:
                cos, sin = self._whole[0].cos_sin(key)
                self._cached[key] = cos[self._whole[1]], sin[self._whole[1]]
            else:
                self._cached[key] = _cos_sin(key, self.phase_rad, self.advance_rad)
        return self._cached[key]


def joined_timelines(parts: Sequence[Timeline]) -> Timeline:
    """Return the instants of several timelines with as many lanes one after the other."""
    return Timeline(
        np.concatenate([one.time_s for one in parts]),
        np.concatenate([one.phase_rad for one in parts]),
        np.concatenate([one.speed_rad_s for one in parts]),
        np.concatenate([one.acceleration_rad_s2 for one in parts]),
    )


def _cos_sin(order: float, phase_rad: np.ndarray, advance_rad: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    even = np.zeros(phase_rad.shape[1], dtype=bool) if advance_rad is None else np.isfinite(advance_rad)
    if advance_rad is not None and even.all():
        return _even_cos_sin(order, phase_rad, advance_rad)
    cos, sin = np.cos(order * phase_rad), np.sin(order * phase_rad)
    if advance_rad is not None and even.any():
        # The same way as without the other lanes, so that these do not change its bits.
        cos[:, even], sin[:, even] = _even_cos_sin(order, phase_rad[:, even], advance_rad[even])
    return cos, sin


def _even_cos_sin(order: float, phase_rad: np.ndarray, advance_rad: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return cos and sin of evenly spaced angles: those of every `RUN`-th, turned on by the angles in between."""
    count, lanes = phase_rad.shape
    coarse, fine = order * phase_rad[::RUN, None], order * (np.arange(min(count, RUN))[:, None] * advance_rad)[None]
    cos_a, sin_a, cos_b, sin_b = np.cos(coarse), np.sin(coarse), np.cos(fine), np.sin(fine)
    cos, sin = cos_a * cos_b, sin_a * cos_b
    cos -= sin_a * sin_b
    sin += cos_a * sin_b
    return cos.reshape(-1, lanes)[:count], sin.reshape(-1, lanes)[:count]


Signals = Callable[[Timeline, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Law:
    """How an interface force comes about.

    Parameters
    ----------
    name : str
    signals : callable
        ``signals(timeline, parameters) -> ndarray (signals, instants, lanes)``; ``parameters`` has shape
        (parameters, lanes). For a linear law the signals are, for n outputs and p inputs, first the n forces that do
        not depend on the motion, then the n x p coefficients, row by row.
    force : callable, optional
        Compiled with `compiled_force`: ``force(signals, parameters, x, inputs, outputs, u)`` adds to ``u`` in place.
        None for a linear law.
    jumps : callable, optional
        For signals that jump at known angles: ``jumps(parameters (parameters,), start_rad, stop_rad) -> angles`` gives
        the reference-shaft angles in (start, stop] at which they do. `signals` is then called with the extra keyword
        ``branch_rad``, the angle (instants, lanes) whose branch must be continued.
    stiffest : callable, optional
        For a contact: ``stiffest(parameters (parameters,)) -> float``, the largest local stiffness in N/m that the
        linear core does not hold. The solver shortens its step accordingly and says so.
    counts : tuple of int
        Parameters that are numbers of things and say what the others mean. Runs in which they differ do not go side by
        side.
    nearly_linear : bool
        Whether the slopes of a nonlinear force hardly change along the motions for which the machine's model holds.
        Beside other nonlinear forces a balance then keeps those that it begins with, and computes others only where
        that leads nowhere.
    self_excited : bool
        Whether the force drives a motion of its own rhythm. A balance of what repeats with the shaft would find the
        equilibrium beneath it, which no machine keeps.
    wave : callable, optional
        For a force that is one sinusoid: ``wave(parameters (parameters,), speed_rad_s) -> (order, frequency_hz,
        amplitudes (outputs,) complex)``, the real part of amplitude exp(i (order phi + 2 pi f t)) at constant speed.
    """

    name: str
    signals: Signals
    force: Any = None
    jumps: Callable[[np.ndarray, float, float], np.ndarray] | None = None
    stiffest: Callable[[np.ndarray], float] | None = None
    counts: tuple[int, ...] = ()
    nearly_linear: bool = False
    self_excited: bool = False
    wave: Callable[[np.ndarray, float], tuple[float, float, np.ndarray]] | None = None

    @property
    def is_linear(self) -> bool:
        """Whether the force is linear in the motion."""
        return self.force is None


@dataclass(frozen=True)
class InterfaceForce:
    """A law at work in a machine.

    Parameters
    ----------
    name : str
        Unique in the machine, for messages.
    law : Law
    parameters : tuple of float
    displacements, velocities : tuple of Direction
        What the law reads: first all displacements, then all velocities.
    outputs : tuple of Direction
        Where each force acts, as a generalised force.
    """

    name: str
    law: Law
    parameters: tuple[float, ...]
    outputs: tuple[Direction, ...]
    displacements: tuple[Direction, ...] = ()
    velocities: tuple[Direction, ...] = ()

    def __post_init__(self) -> None:
        if not all(math.isfinite(value) for value in self.parameters):
            raise InvalidValueError(
                f"Force {self.name} has parameters {self.parameters}; allowed: finite numbers. Check the machine's "
                "parameters and effects."
            )


def no_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    """Return no signals, for laws that depend on the motion only."""
    return np.zeros((0, *timeline.time_s.shape))


@contextlib.contextmanager
def no_collecting() -> Iterator[None]:
    """Do not look for garbage meanwhile: among the many objects that compiling makes, that costs a tenth of it."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()


@functools.cache
def force_signature() -> Any:
    """Return the numba signature that every compiled force has."""
    import numba

    matrix = numba.float64[:, ::1]
    return numba.void(matrix, matrix, matrix, numba.int64[::1], numba.int64[::1], matrix)


class CompiledForce:
    """A force function, compiled when first needed and kept on disk.

    ``force(...)`` runs the compiled function, ``force.py_func(...)`` the plain Python one.
    """

    def __init__(self, function: Callable[..., None]) -> None:
        self.py_func = function

    @functools.cached_property
    def compiled(self) -> Any:
        """The compiled function, as numba's dispatcher."""
        from .compiled_code import njit

        options: dict[str, Any] = {
            "cache": True,
            "error_model": "numpy",
            "nogil": True,
            "no_cfunc_wrapper": True,
            "_nrt": False,
        }
        with no_collecting():
            return njit(force_signature(), **options)(self.py_func)

    def __call__(self, *arguments: np.ndarray) -> None:
        """Call the compiled function."""
        self.compiled(*arguments)


def compiled_force(function: Callable[..., None]) -> CompiledForce:
    """Make ``function(signals, parameters, x, inputs, outputs, u)`` a compiled force.

    All matrices have the lanes last: ``signals`` (signals, lanes), ``parameters`` (parameters, lanes), ``x`` (rows of
    C y, lanes), ``u`` (interface forces, lanes). ``inputs`` and ``outputs`` say which rows belong to the force. The
    function loops over the lanes and adds to ``u``. It makes no arrays of its own: it is compiled without the counting
    of references that these need.
    """
    return CompiledForce(function)

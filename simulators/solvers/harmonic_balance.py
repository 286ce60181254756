"""Steady periodic motion by harmonic balance on the interface.

With y = sum of y_k exp(i k w t) every harmonic obeys (i k w - L) y_k = B u_k, so that the motions which forces read
follow from the forces alone: x_k = C (i k w - L)^-1 B u_k =: H_k u_k. Unknown are the few interface motions, not the
states. For forces linear in the motion, u(t) = s(t) + S(t) x(t), the balance is one linear system; other forces are
sampled over the period and Newton's method repeats it with the force's local slope as S(t).

References: W. Von Groll, D. J. Ewins, J. Sound Vib. 241 (2001) 223; M. Krack, J. Gross, Harmonic Balance for
Nonlinear Vibration Problems, Springer 2019, chapter 2 (alternating frequency-time sampling).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..assembly import Probe
from ..errors import InvalidValueError, RotorwiseError
from ..machine import Machine
from ..speed_profile import SpeedProfile, steady
from ..system import System, build_system
from .blas import single_blas_thread
from .frequency_response import Spinning, responses
from .newton_balance import WORST, balanced_newton
from .periodic_balance import Responses, balanced_linear
from .periodic_forces import periodic_forces
from .periodic_stability import largest_multipliers

#: Signals are sampled this many times finer than the highest harmonic; finer where they jump, as a jump is then known
#: to within one sample.
OVERSAMPLING, OVERSAMPLING_OF_JUMPS = 8, 128
#: Growth of a disturbance in a period above which a motion is taken not to last: slopes are sampled.
UNSTABLE = 1.01
#: Systems that are kept for further speeds.
KEPT_SYSTEMS = 16


class NoPeriodicMotionError(RotorwiseError):
    """Newton's method found no periodic motion, or one that does not last."""


@dataclass(frozen=True)
class PeriodicMotion:
    """Steady periodic motion of a machine.

    Signals are the real part of the sum of ``amplitudes[:, k] exp(i orders[k] phi)``, phi the reference-shaft angle;
    a complex amplitude's modulus is the peak value of that line.

    Attributes
    ----------
    orders : ndarray (orders,)
        Multiples of the reference-shaft speed, from 0.
    amplitudes : ndarray (probes, orders), complex
        Of the probes.
    motions : ndarray (motions, orders), complex
        Of the interface motions.
    probes : tuple of Probe
    speed_rad_s : float
    residual : float
        Largest change of the interface motions in the last Newton step over their size; 0 for a linear machine.
    """

    orders: np.ndarray
    amplitudes: np.ndarray
    motions: np.ndarray
    probes: tuple[Probe, ...]
    speed_rad_s: float
    residual: float

    def waveform(self, phase_rad: np.ndarray) -> np.ndarray:
        """Return the probe signals at the given shaft angles, shape (probes, angles)."""
        return np.real(self.amplitudes @ powers(np.exp(1j * self.orders[1] * phase_rad), self.orders.size))

    def amplitude(self, probe: str, order: float) -> complex:
        """Return the complex amplitude of one probe at one order of this motion."""
        names = [p.name for p in self.probes]
        where = np.flatnonzero(np.isclose(self.orders, order))
        if probe not in names or where.size == 0:
            raise InvalidValueError(
                f"No order {order:g} at probe {probe!r}; allowed: {', '.join(names)} and orders up to "
                f"{self.orders[-1]:g} in steps of {self.orders[1] if self.orders.size > 1 else 0:g}."
            )
        return complex(self.amplitudes[names.index(probe), where[0]])


def harmonic_balance(machine: Machine, *, speed_rpm: float, harmonics: int = 8, revolutions: int = 1) -> PeriodicMotion:
    """Return the steady periodic motion at constant speed.

    This is the motion of the machine: effects of the stages speed and sensor do not act here. A speed that changes has
    no steady motion, and a sensor's errors come after the physics; use `simulate` for both.

    Parameters
    ----------
    machine : Machine
    speed_rpm : float
    harmonics : int
        Highest order of the reference shaft.
    revolutions : int
        Period in revolutions: 1 for integer orders, 2 for half orders.

    Raises
    ------
    InvalidValueError
        When the signals do not repeat after so many revolutions.
    NoPeriodicMotionError
        When a nonlinear machine's balance does not converge, or a force excites itself.
    """
    return harmonic_balance_at_speeds(machine, [speed_rpm], harmonics=harmonics, revolutions=revolutions)[0]


def harmonic_balance_at_speeds(
    machine: Machine, speeds_rpm: Sequence[float], *, harmonics: int = 8, revolutions: int = 1
) -> list[PeriodicMotion]:
    """Return the steady periodic motion at each of several constant speeds; cheaper than one after the other.

    Parameters and errors as in `harmonic_balance`; one speed without a periodic motion fails them all.
    """
    (found,) = harmonic_balances([(machine, speeds_rpm)], harmonics=harmonics, revolutions=revolutions)
    if isinstance(found, RotorwiseError):
        raise found
    return found


@single_blas_thread
def harmonic_balances(
    cases: Sequence[tuple[Machine, Sequence[float]]],
    *,
    harmonics: int = 8,
    revolutions: int = 1,
    near: Sequence[Sequence[PeriodicMotion] | None] | None = None,
    only_stable: Sequence[bool] | None = None,
) -> list[list[PeriodicMotion] | RotorwiseError]:
    """Return the steady periodic motions of several machines, each at several speeds, side by side.

    Parameters as in `harmonic_balance`, and ``near``: for each case the motions of a machine that is nearly the same,
    at each speed, or None. A nonlinear machine's motion is then sought from there, not from rest: in fewer steps, and
    of several motions the one close by. Of the cases that ``only_stable`` says, a nonlinear machine's motion that the
    least disturbance ends counts as none. A machine without a periodic motion at one of its speeds has that error in
    its place.
    """
    if harmonics < 1 or revolutions < 1:
        raise InvalidValueError(f"{harmonics} harmonics over {revolutions} revolutions; allowed: 1 or more of both.")
    found: dict[tuple[int, int], PeriodicMotion] = {}
    failed: dict[int, RotorwiseError] = {}
    groups: dict[object, list[_Lane]] = {}
    near, only_stable = near or [None] * len(cases), only_stable or [False] * len(cases)
    for number, ((machine, speeds_rpm), beside, stable) in enumerate(zip(cases, near, only_stable, strict=True)):
        profiles = [steady(speed_rpm=speed) for speed in speeds_rpm]
        try:
            systems = _systems(machine, profiles)
        except RotorwiseError as problem:
            failed[number] = problem.with_traceback(None)
            continue
        wiring = {id(system): _wiring(system) for system in systems}
        for index, (profile, system) in enumerate(zip(profiles, systems, strict=True)):
            lane = _Lane((number, index), system, profile.speeds_rad_s[0], beside[index] if beside else None, stable)
            groups.setdefault(wiring[id(system)], []).append(lane)
    for group in groups.values():
        for lane, motion in zip(group, _side_by_side(group, harmonics * revolutions, revolutions), strict=True):
            if isinstance(motion, PeriodicMotion):
                found[lane.place] = motion
            else:
                failed.setdefault(lane.place[0], motion)
    return [
        failed[number] if number in failed else [found[number, index] for index in range(len(speeds))]
        for number, (_, speeds) in enumerate(cases)
    ]


@dataclass(frozen=True, eq=False)
class _Lane:
    """One machine at one speed; ``place`` is the number of the case, then of the speed; ``near`` a motion close by.

    ``only_stable`` says that a motion that does not last is none.
    """

    place: tuple[int, int]
    system: System
    speed_rad_s: float
    near: PeriodicMotion | None
    only_stable: bool


def _side_by_side(lanes: list[_Lane], count: int, revolutions: int) -> list[PeriodicMotion | RotorwiseError]:
    """Return the motions of lanes; where some force does not repeat, one machine after the other."""
    try:
        return _motions(lanes, count, revolutions)
    except RotorwiseError as problem:
        cases: dict[int, list[_Lane]] = {}
        for lane in lanes:
            cases.setdefault(lane.place[0], []).append(lane)
        if len(cases) == 1:
            # Its traceback would keep all that was computed until then.
            return [problem.with_traceback(None)] * len(lanes)
        return [one for own in cases.values() for one in _side_by_side(own, count, revolutions)]


def _systems(machine: Machine, profiles: Sequence[SpeedProfile]) -> list[System]:
    """Return the machine's matrices at each speed: the same system where nothing in it but gyroscopic terms follows it.

    Interface forces and everything else that is read here does not contain the speed then.
    """
    key = (machine.definition, machine.preset_name, tuple(sorted(machine.changed.items())), machine.effects)
    kept = _kept_systems.pop(key, None)
    if kept is None:
        systems = []
        for profile in profiles:
            assembly = machine.assembly(speed_rpm=profile)
            follows = assembly.follows_speed
            systems.append(build_system(assembly))
            if not follows:
                kept = systems[0]
                break
        else:
            return systems
    _kept_systems[key] = kept
    while len(_kept_systems) > KEPT_SYSTEMS:
        _kept_systems.pop(next(iter(_kept_systems)))
    return [kept] * len(profiles)


_kept_systems: dict[object, System] = {}


def forget() -> None:
    """Forget the systems of all machines."""
    _kept_systems.clear()


def kept_systems() -> int:
    """Return of how many machines the system is kept."""
    return len(_kept_systems)


def _wiring(system: System) -> object:
    """Return what lanes that are balanced together share."""
    forces = tuple(
        (force.law, len(force.parameters), *(force.parameters[i] for i in force.law.counts)) for force in system.forces
    )
    ends = tuple(tuple(rows.tolist()) for rows in (*system.inputs, *system.outputs))
    return forces, ends, system.motion_rows.tobytes(), system.force_directions.tobytes()


def _motions(lanes: list[_Lane], count: int, revolutions: int) -> list[PeriodicMotion | RotorwiseError]:
    """Return the motions of lanes with the same forces, up to ``count`` harmonics of the period."""
    systems, speeds_rad_s = [lane.system for lane in lanes], [lane.speed_rad_s for lane in lanes]
    first, orders = systems[0], np.arange(count + 1) / revolutions
    excited = [force.name for force in first.forces if force.law.self_excited]
    if excited:
        raise NoPeriodicMotionError(
            f"{', '.join(excited)} can excite a motion that does not repeat with the shaft; allowed: forces that "
            "follow it. Simulate the machine in time instead."
        )
    # First, as it says whether there is a period.
    forces = periodic_forces(systems, speeds_rad_s, instants_for(first, count), revolutions) if first.forces else None
    responding, growth = interface_responses(systems, speeds_rad_s, count, revolutions), np.zeros(len(systems))
    if forces is not None:
        if first.is_linear:
            pushed = balanced_linear(forces, responding)
            residuals = np.where(np.isfinite(pushed).all(axis=(1, 2)), 0.0, np.nan)
        else:
            pushed, residuals = balanced_newton(
                forces, responding, _starts(lanes, responding), [lane.place[0] for lane in lanes]
            )
            looked_at = np.array([lane.only_stable for lane in lanes])
            if looked_at.any():
                found = responding.motions(np.where(residuals[:, None, None] < WORST, pushed, 0.0))
                growth = np.where(looked_at, largest_multipliers(forces, found, speeds_rad_s, revolutions), 0.0)
    else:
        pushed, residuals = np.zeros((len(systems), count + 1, 0), dtype=complex), np.zeros(len(systems))
    motions = _one_sided(responding.motions(pushed).swapaxes(1, 2))
    probes = _one_sided((responding.of_probes @ pushed[..., None])[..., 0].swapaxes(1, 2))
    return [
        _no_motion(residuals[i], growth[i])
        or PeriodicMotion(orders, probes[i], motions[i], system.probes, speed, float(residuals[i]))
        for i, (system, speed) in enumerate(zip(systems, speeds_rad_s, strict=True))
    ]


def _no_motion(residual: float, growth: float) -> NoPeriodicMotionError | None:
    """Return why a balance is no motion of the machine; None where it is one."""
    if not residual < WORST:
        return NoPeriodicMotionError(
            f"The harmonic balance of this machine did not converge (last relative change {residual:.2g}). Its "
            "motion may not be periodic, or it needs more harmonics; simulate it in time instead."
        )
    if growth > UNSTABLE:
        return NoPeriodicMotionError(
            f"The periodic motion of this machine does not last: a disturbance grows by a factor {growth:.3g} in each "
            "period. Simulate it in time instead."
        )
    return None


def _starts(lanes: list[_Lane], responding: Responses) -> np.ndarray | None:
    """Return where the motions (lanes, K + 1, motions) are sought from: rest where none is known close by."""
    if not any(lane.near for lane in lanes):
        return None
    found = np.zeros(responding.factors.shape, dtype=complex)
    for own, lane in zip(found, lanes, strict=True):
        if lane.near is not None and lane.near.motions.T.shape == own.shape:
            own[:] = two_sided(lane.near.motions).T
    return found


def instants_for(system: System, count: int) -> int:
    """Return at how many instants of a period its forces are sampled for so many harmonics."""
    jumping = any(force.law.jumps is not None for force in system.forces)
    finer = OVERSAMPLING_OF_JUMPS if jumping else OVERSAMPLING
    return 2 ** math.ceil(math.log2(finer * (count + 1)))


def interface_responses(
    systems: list[System],
    speeds_rad_s: list[float],
    count: int,
    revolutions: int,
    further: np.ndarray | None = None,
) -> Responses:
    """Return what the forces of each lane do to its motions and probes.

    After the interface forces come, as further columns, generalised forces (coordinates, forces), if given.
    """
    first, n = systems[0], len(systems[0].coordinates)
    # Each row of motions reads displacements or velocities, never both.
    reads = first.motion_rows[:, :n] + first.motion_rows[:, n : 2 * n]
    number: dict[bytes, int] = {}
    directions = np.array([number.setdefault(row.tobytes(), len(number)) for row in reads], dtype=int)
    distinct = np.unique(directions, return_index=True)[1]
    rows = np.concatenate([reads[distinct], first.probe_directions])
    lanes = [Spinning(speed, speed / revolutions, count) for speed in speeds_rad_s]
    columns = first.force_directions if further is None else np.concatenate([first.force_directions, further], axis=1)
    found = responses(systems, lanes, rows, columns)
    rates = 1j * np.outer([lane.base_rad_s for lane in lanes], np.arange(count + 1))[:, :, None]
    of_directions, of_probes = found[:, :, : distinct.size], found[:, :, distinct.size :]
    derivatives = [("displacement", "velocity", "acceleration").index(probe.quantity) for probe in first.probes]
    of_probes *= (rates ** np.array(derivatives, dtype=int))[..., None]
    factors = np.where(first.motion_rows[:, n : 2 * n].any(axis=1), rates, 1.0)
    return Responses(of_directions, of_probes, directions, factors)


def powers(turning: np.ndarray, count: int) -> np.ndarray:
    """Return the powers 0 to ``count`` - 1 of complex numbers (n,), shape (count, n).

    Of exp(i phi): a product each, where exp(i k phi) would cost a sine and a cosine.
    """
    found = np.empty((count, turning.size), dtype=complex)
    found[0] = 1.0
    for k in range(1, count):
        np.multiply(found[k - 1], turning, out=found[k])
    return found


def balance_matrix(slope: np.ndarray, responses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix I - H S over all harmonics -K..K and the block-diagonal H.

    Parameters
    ----------
    slope : ndarray (forces, motions, instants)
        One period of S(t).
    responses : ndarray (K + 1, motions, forces)
        H_k for k = 0..K.

    Returns
    -------
    matrix : ndarray ((2K + 1) motions, (2K + 1) motions), complex
    wide : ndarray (2K + 1, motions, forces), complex
        H_k for k = -K..K.
    """
    top, motions = responses.shape[0] - 1, responses.shape[1]
    wide = np.concatenate([np.conj(responses[:0:-1]), responses])
    spectrum = np.fft.fft(slope, axis=-1) / slope.shape[-1]
    harmonics = np.arange(-top, top + 1)
    lag = harmonics[:, None] - harmonics[None, :]
    blocks = np.einsum("amf,fnab->ambn", wide, spectrum[:, :, lag])
    size = harmonics.size * motions
    return np.eye(size) - blocks.reshape(size, size), wide


def _one_sided(harmonics: np.ndarray) -> np.ndarray:
    """Turn two-sided harmonics 0..K into peak amplitudes: all but the mean count twice."""
    return harmonics * _sides(harmonics.shape[-1])


def two_sided(amplitudes: np.ndarray) -> np.ndarray:
    """Turn peak amplitudes (..., K + 1) into two-sided harmonics."""
    return amplitudes / _sides(amplitudes.shape[-1])


def _sides(orders: int) -> np.ndarray:
    return np.where(np.arange(orders) == 0, 1.0, 2.0)

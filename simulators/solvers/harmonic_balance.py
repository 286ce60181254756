"""Steady periodic motion by harmonic balance on the interface.

With y = sum of y_k exp(i k w t) every harmonic obeys (i k w - L) y_k = B u_k, so that the motions which forces read
follow from the forces alone: x_k = C (i k w - L)^-1 B u_k =: H_k u_k. Unknown are the few interface motions, not the
states. For forces linear in the motion, u(t) = s(t) + S(t) x(t), the balance is one linear system; other forces are
sampled over the period and Newton's method repeats it with the force's local slope as S(t).

References: W. Von Groll, D. J. Ewins, J. Sound Vib. 241 (2001) 223; M. Krack, J. Gross, Harmonic Balance for
Nonlinear Vibration Problems, Springer 2019, chapter 2 (alternating frequency-time sampling).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from ..assembly import Probe
from ..errors import InvalidValueError, RotorwiseError
from ..machine import Machine
from ..speed_profile import steady
from ..system import System
from .blas import single_blas_thread
from .equilibrium import interface_forces, lane_signals
from .plan import ForcePlan, force_plan

#: Signals are sampled this many times finer than the highest harmonic; finer where they jump, as a jump is then known
#: to within one sample.
OVERSAMPLING, OVERSAMPLING_OF_JUMPS = 8, 128
MOST_STEPS = 40
TOLERANCE = 1e-10


class NoPeriodicMotionError(RotorwiseError):
    """Newton's method found no periodic motion."""


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
        return np.real(self.amplitudes @ np.exp(1j * np.outer(self.orders, phase_rad)))

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


@single_blas_thread
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
        When a nonlinear machine's balance does not converge.
    """
    if harmonics < 1 or revolutions < 1:
        raise InvalidValueError(f"{harmonics} harmonics over {revolutions} revolutions; allowed: 1 or more of both.")
    profile = steady(speed_rpm=speed_rpm)
    system = machine.system(speed_rpm=profile)
    plan = force_plan([system], [profile])
    count = harmonics * revolutions
    finer = OVERSAMPLING_OF_JUMPS if plan.jumping else OVERSAMPLING
    instants = 2 ** math.ceil(math.log2(finer * (count + 1)))
    signals = _periodic_signals(plan, instants, revolutions)
    base = profile.speeds_rad_s[0] / revolutions
    resolvents = _resolvents(system.core.tobytes(), base, count)
    responses = system.motion_rows @ (resolvents @ system.force_columns)
    if system.is_linear:
        motions, residual = _balance_linear(system, plan, signals, responses), 0.0
    else:
        motions, residual = _balance_newton(system, plan, signals, responses)
    forces = _force_harmonics(system, plan, signals, motions, instants)[:, : count + 1]
    states = np.einsum("kij,jk->ik", resolvents, system.force_columns @ forces)
    amplitudes = system.probe_rows @ states + system.probe_columns @ forces
    return PeriodicMotion(
        orders=np.arange(count + 1) / revolutions,
        amplitudes=_one_sided(amplitudes),
        motions=_one_sided(motions),
        probes=system.probes,
        speed_rad_s=profile.speeds_rad_s[0],
        residual=residual,
    )


@functools.lru_cache(maxsize=32)
def _resolvents(core: bytes, base_rad_s: float, count: int) -> np.ndarray:
    """Return (i k w - L)^-1 for k = 0..count, shape (count + 1, states, states).

    Kept, as runs with other forces on the same core are usual. A machine with a motion that nothing holds has no
    static response there: that part is left out.
    """
    matrix = np.frombuffer(core).reshape(2 * [math.isqrt(len(core) // 8)])
    unit = np.eye(matrix.shape[0])
    moving = np.linalg.inv(1j * base_rad_s * np.arange(1, count + 1)[:, None, None] * unit - matrix)
    return np.concatenate([_static_response(matrix, unit)[None], moving])


def _static_response(core: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return -L^-1 B without the motions that nothing holds.

    Balanced first: states in m, m/s and V differ so much in size that the cut for "nothing holds" would hit others.
    """
    from scipy.linalg import matrix_balance

    balanced, (scale, _) = matrix_balance(core, permute=False, separate=True)
    return (np.linalg.lstsq(-balanced, (columns.T / scale).T, rcond=1e-14)[0].T * scale).T


def _periodic_signals(plan: ForcePlan, instants: int, revolutions: int) -> list[np.ndarray]:
    speed = plan.profiles[0].speeds_rad_s[0]
    period = 2 * np.pi * revolutions / speed
    time = period * np.arange(instants) / instants
    signals = lane_signals(plan, 0, plan.lane_timeline(0, time))
    again = lane_signals(plan, 0, plan.lane_timeline(0, time + period))
    for force, first, second in zip(plan.forces, signals, again, strict=True):
        if first.size and np.abs(first - second).max() > 1e-6 * (np.abs(first).max() + 1e-300):
            raise InvalidValueError(
                f"Force {force.name} does not repeat after {revolutions} revolution(s) of the reference shaft; "
                "allowed: a period of all forces. Give more revolutions, or simulate in time."
            )
    return signals


def _linear_parts(system: System, plan: ForcePlan, signals: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return s (forces, instants) and S (forces, motions, instants) of the linear laws."""
    motions, forces = system.motion_rows.shape[0], system.force_columns.shape[1]
    instants = signals[0].shape[1]
    constant, slope = np.zeros((forces, instants)), np.zeros((forces, motions, instants))
    for k, force in enumerate(plan.forces):
        if not force.law.is_linear:
            continue
        reads = plan.inputs[plan.rows[k, 1] : plan.rows[k, 2]]
        acts = plan.outputs[plan.rows[k, 3] : plan.rows[k, 4]]
        for i, act in enumerate(acts):
            constant[act] += signals[k][i]
            for j, read in enumerate(reads):
                slope[act, read] += signals[k][acts.size + i * reads.size + j]
    return constant, slope


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


def _solve_balance(slope: np.ndarray, constant: np.ndarray, responses: np.ndarray) -> np.ndarray:
    """Return the motions' harmonics 0..K, shape (motions, K + 1), of u = constant + slope x."""
    top, motions = responses.shape[0] - 1, responses.shape[1]
    matrix, wide = balance_matrix(slope, responses)
    spectrum = np.fft.fft(constant, axis=-1) / constant.shape[-1]
    right = np.einsum("amf,fa->am", wide, spectrum[:, np.arange(-top, top + 1)])
    solution = np.linalg.solve(matrix, right.ravel()).reshape(2 * top + 1, motions)
    return solution[top:].T


def _balance_linear(system: System, plan: ForcePlan, signals: list[np.ndarray], responses: np.ndarray) -> np.ndarray:
    if not plan.forces:
        return np.zeros((system.motion_rows.shape[0], responses.shape[0]), dtype=complex)
    constant, slope = _linear_parts(system, plan, signals)
    return _solve_balance(slope, constant, responses)


def _balance_newton(
    system: System, plan: ForcePlan, signals: list[np.ndarray], responses: np.ndarray
) -> tuple[np.ndarray, float]:
    motions, forces = system.motion_rows.shape[0], system.force_columns.shape[1]
    instants = signals[0].shape[1]
    found = np.zeros((motions, responses.shape[0]), dtype=complex)
    change = math.inf
    for _ in range(MOST_STEPS):
        x = _waveform(found, instants)
        u, slope = _local_slope(plan, signals, x, forces)
        constant = u - np.einsum("fmt,mt->ft", slope, x)
        following = _solve_balance(slope, constant, responses)
        scale = np.abs(following).max()
        change = float(np.abs(following - found).max() / scale) if scale > 0 else 0.0
        found = following
        if not np.isfinite(change):
            break
        if change < TOLERANCE:
            return found, change
    if change < 1e-6:
        return found, change
    raise NoPeriodicMotionError(
        f"The harmonic balance of this machine did not converge (last relative change {change:.2g}). Its motion may "
        "not be periodic, or it needs more harmonics; simulate it in time instead."
    )


def _local_slope(
    plan: ForcePlan, signals: list[np.ndarray], x: np.ndarray, forces: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return u (forces, instants) and du/dx (forces, motions, instants) by central differences."""
    motions, instants = x.shape
    u = interface_forces(plan, 0, signals, x, forces)
    slope = np.zeros((forces, motions, instants))
    width = 1e-6 * np.abs(x).max(axis=1) + 1e-12
    for j in range(motions):
        move = np.zeros((motions, 1))
        move[j] = width[j]
        above = interface_forces(plan, 0, signals, x + move, forces)
        below = interface_forces(plan, 0, signals, x - move, forces)
        slope[:, j] = (above - below) / (2 * width[j])
    return u, slope


def _force_harmonics(
    system: System, plan: ForcePlan, signals: list[np.ndarray], motions: np.ndarray, instants: int
) -> np.ndarray:
    forces = system.force_columns.shape[1]
    if not plan.forces:
        return np.zeros((forces, instants), dtype=complex)
    u = interface_forces(plan, 0, signals, _waveform(motions, instants), forces)
    return np.fft.fft(u, axis=-1) / instants


def _waveform(motions: np.ndarray, instants: int) -> np.ndarray:
    """Return x(t) over one period from its harmonics 0..K."""
    spectrum = np.zeros((motions.shape[0], instants // 2 + 1), dtype=complex)
    spectrum[:, : motions.shape[1]] = motions * instants
    return np.fft.irfft(spectrum, instants, axis=-1)


def _one_sided(two_sided: np.ndarray) -> np.ndarray:
    """Turn two-sided harmonics 0..K into peak amplitudes: all but the mean count twice."""
    return two_sided * np.where(np.arange(two_sided.shape[1]) == 0, 1.0, 2.0)

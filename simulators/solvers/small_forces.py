"""What small further forces do to a machine that moves periodically: linearised about that motion.

A machine whose stiffness changes with the shaft's angle, or bends with the motion, answers a force at one order with
lines at others too, and its line at the force's own order also follows the force's conjugate. With the displacements z
that interface forces read, a force f and the slopes S of the interface forces along the motion,

    (I - H S) z = H_f f,    lines = P S z + P_f f,

in real and imaginary parts, see `periodic_balance`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..law import Direction
from ..machine import Machine
from ..speed_profile import steady
from ..system import System, build_system
from .along_motion import linearised
from .blas import single_blas_thread
from .harmonic_balance import harmonic_balance_at_speeds, instants_for, interface_responses, two_sided
from .periodic_balance import Responses, Slopes, identity_minus, moved_by_slopes, slopes_of, solved_lanes
from .periodic_forces import PeriodicForces, periodic_forces
from .slope_matrix import slope_matrix


@single_blas_thread
def small_force_responses(
    machine: Machine,
    directions: Sequence[Direction],
    *,
    speeds_rpm: Sequence[float],
    harmonics: int,
    revolutions: int = 1,
) -> np.ndarray:
    """Return the probes' lines at every order, of a small force at one order, per unit of it.

    Parameters
    ----------
    machine : Machine
    directions : sequence of Direction
        Of the generalised forces.
    speeds_rpm : sequence of float
    harmonics : int
        Highest order of the reference shaft.
    revolutions : int
        Period in revolutions: 2 for half orders as well.

    Returns
    -------
    ndarray (2, speeds, orders, orders, probes, directions), complex
        Lines at the first order of a force at the second one. Orders 0 to ``harmonics`` in steps of
        1 / ``revolutions``, that of 0 is left at 0. First of the force cos(order phi), then of -sin(order phi), which
        is complex amplitude 1, and i.

    Raises
    ------
    RotorwiseError
        As `harmonic_balance`, when the machine's own motion is not periodic.
    """
    motions = harmonic_balance_at_speeds(machine, speeds_rpm, harmonics=harmonics, revolutions=revolutions)
    profiles = [steady(speed_rpm=speed) for speed in speeds_rpm]
    systems = [build_system(machine.assembly(speed_rpm=profile)) for profile in profiles]
    speeds = [profile.speeds_rad_s[0] for profile in profiles]
    push = np.stack([systems[0].row(direction)[: len(systems[0].coordinates)] for direction in directions], axis=1)
    count = harmonics * revolutions
    responding = interface_responses(systems, speeds, count, revolutions, push)
    each = np.arange(1, count + 1)
    shape = (2, len(systems), count + 1, count + 1, responding.of_probes.shape[2], len(directions))
    found, acting = np.zeros(shape, dtype=complex), systems[0].force_directions.shape[1]
    direct = responding.of_probes[..., acting:] * np.array([1.0, 1j])[:, None, None, None, None]
    found[:, :, each, each] = direct[:, :, each]
    if systems[0].forces:
        states = np.stack([two_sided(motion.motions).T for motion in motions])
        slopes = _slopes(systems, speeds, states, count, revolutions)
        if slopes.pairs.size:
            forces = _answers(responding, slopes, acting)
            of_probes = responding.of_probes[..., :acting]
            found += np.einsum("lopf,alokfd->alokpd", of_probes, forces, optimize=True)
    found[:, :, 0] = found[:, :, :, 0] = 0.0
    return found


def _slopes(systems: list[System], speeds: list[float], states: np.ndarray, count: int, revolutions: int) -> Slopes:
    """Return the slopes of all interface forces along motions (lanes, K + 1, motions)."""
    instants = instants_for(systems[0], count)
    forces: PeriodicForces = periodic_forces(systems, speeds, instants, revolutions)
    constant, slope = forces.linear_parts()
    linear = slopes_of(slope, count)
    if not forces.nonlinear:
        return linear
    _, bent = linearised(forces, np.arange(len(systems)), states, constant.shape)
    if not linear.pairs.size:
        return bent
    return Slopes(np.concatenate([linear.pairs, bent.pairs]), np.concatenate([linear.spectrum, bent.spectrum]))


def _answers(responding: Responses, slopes: Slopes, acting: int) -> np.ndarray:
    """Return the interface forces at each order of small ones at each, (2, lanes, K + 1, K + 1, forces, directions)."""
    wanted, place = np.unique(responding.directions[slopes.pairs[:, 1]], return_inverse=True)
    own = responding.of_directions[:, :, wanted]
    lanes, orders, size, _ = own.shape
    small = own[..., acting:].transpose(1, 0, 2, 3)
    each = np.arange(orders)
    right = np.zeros((lanes, 2, size, orders, 2, small.shape[-1], orders))
    right[:, 0, :, each, 0, :, each], right[:, 1, :, each, 0, :, each] = np.real(small), np.imag(small)
    right[:, 0, :, each, 1, :, each], right[:, 1, :, each, 1, :, each] = -np.imag(small), np.real(small)
    matrix = identity_minus(moved_by_slopes(own[..., :acting], slopes, place, responding.factors))
    moved = solved_lanes(matrix, right.reshape(lanes, matrix.shape[1], -1))
    acts, reads = slopes.pairs.T
    factors = responding.factors[:, :, reads]
    pushed = slope_matrix(slopes.spectrum, acts, place, factors, sizes=(acting, size)) @ moved
    whole = pushed.reshape(lanes, 2, acting, orders, 2, small.shape[-1], orders)
    whole = whole.transpose(1, 4, 0, 3, 6, 2, 5)
    return whole[0] + 1j * whole[1]

"""Stability of a linear machine whose stiffness repeats with the shaft angle: Floquet multipliers.

A motion of y' = [L + B S(t) C] y is multiplied by the eigenvalues of the one-period transition matrix after each
period; the machine is stable when all lie inside the unit circle. G. Floquet 1883; for rotors see
P. P. Friedmann, J. Sound Vib. 113 (1987) 405.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InvalidValueError
from ..machine import Machine
from ..speed_profile import steady
from ..system import System
from .blas import single_blas_thread
from .equilibrium import lane_signals
from .plan import ForcePlan, force_plan


@dataclass(frozen=True)
class Stability:
    """Floquet multipliers of a machine at one speed.

    Attributes
    ----------
    multipliers : ndarray (states,), complex
        Factors by which the free motions change in one period, largest modulus first.
    growth_rate_1_s : float
        Exponential growth rate of the fastest growing (or slowest decaying) free motion.
    """

    multipliers: np.ndarray
    growth_rate_1_s: float

    @property
    def is_stable(self) -> bool:
        """Whether every free motion decays (a motion that nothing holds counts as neither)."""
        return bool(np.abs(self.multipliers[0]) <= 1 + 1e-6)


@single_blas_thread
def floquet_multipliers(machine: Machine, *, speed_rpm: float, revolutions: int = 1, steps: int = 512) -> Stability:
    """Return the Floquet multipliers of a machine with linear forces.

    Parameters
    ----------
    machine : Machine
    speed_rpm : float
    revolutions : int
        Period of the stiffness in revolutions.
    steps : int
        Steps a period; each takes the fourth-order Magnus approximation of its transition matrix
        (S. Blanes et al., Physics Reports 470 (2009) 151), so that the error falls with the fourth power.
    """
    from scipy.linalg import expm

    profile = steady(speed_rpm=speed_rpm)
    system = machine.system(speed_rpm=profile)
    if not system.is_linear:
        raise InvalidValueError(
            f"Machine {machine.name} has forces that are not linear in the motion; allowed: linear machines. Use "
            "lyapunov_exponent instead."
        )
    plan = force_plan([system], [profile])
    period = 2 * np.pi * revolutions / profile.speeds_rad_s[0]
    step = period / steps
    offset = np.sqrt(3) / 6
    points = (np.arange(steps)[:, None] + [0.5 - offset, 0.5 + offset]).ravel() * step
    if plan.forces:
        _, slope = _linear_parts(system, plan, lane_signals(plan, 0, plan.lane_timeline(0, points)))
    else:
        slope = np.zeros((system.force_columns.shape[1], system.motion_rows.shape[0], points.size))
    if slope.size == 0 or not slope.any():
        transition = expm(period * system.core)
    else:
        transition = np.eye(system.states)
        for k in range(steps):
            first, second = (
                system.core + system.force_columns @ slope[:, :, 2 * k + i] @ system.motion_rows for i in (0, 1)
            )
            exponent = step / 2 * (first + second) - step**2 * np.sqrt(3) / 12 * (first @ second - second @ first)
            transition = expm(exponent) @ transition
    multipliers = np.linalg.eigvals(transition)
    multipliers = multipliers[np.argsort(-np.abs(multipliers))]
    return Stability(multipliers, float(np.log(np.abs(multipliers[0])) / period))


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

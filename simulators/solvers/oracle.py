"""An independent answer for tests and doubts: an implicit solver of scipy or CVODE on the same equations.

It shares with the stepper the linear core and the laws, which it calls as plain Python functions; it shares none of
the exponential tables, of the compiled loop or of the jump correction. At the angles where signals jump it stops and
starts again, so that no jump lies inside a step.
"""

from __future__ import annotations

import importlib
import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import InvalidValueError, RotorwiseError
from ..machine import Machine
from ..speed_profile import SpeedProfile, as_profile
from ..system import System
from .blas import single_blas_thread
from .plan import ForcePlan, force_plan


class OracleError(RotorwiseError):
    """The reference solver gave up."""


@single_blas_thread
def oracle(
    machine: Machine,
    *,
    speed_rpm: float | SpeedProfile,
    start_state: np.ndarray,
    start_s: float,
    times_s: np.ndarray,
    method: str = "Radau",
    relative_tolerance: float = 1e-9,
    absolute_tolerance: float | np.ndarray = 1e-14,
) -> np.ndarray:
    """Return the states at the given times, shape (states, times).

    Parameters
    ----------
    machine : Machine
    speed_rpm : float or SpeedProfile
    start_state : ndarray (states,)
    start_s : float
    times_s : ndarray (times,)
        Increasing, none before ``start_s``.
    method : str
        "Radau", "BDF", "DOP853" or "LSODA" of scipy, or "CVODE", which needs scikit-sundae.
    relative_tolerance, absolute_tolerance : float

    Raises
    ------
    InvalidValueError
        For an unknown method.
    OracleError
        When the solver fails.
    """
    profile = as_profile(speed_rpm)
    system = machine.system(speed_rpm=profile)
    plan = force_plan([system], [profile])
    solve = _solver(method, relative_tolerance, absolute_tolerance)
    stops = _jump_times(plan, start_s, float(times_s[-1]))
    edges = np.unique(np.concatenate([[start_s], stops[(stops > start_s) & (stops < times_s[-1])], [times_s[-1]]]))
    states = np.zeros((system.states, times_s.size))
    state = np.array(start_state, dtype=float)
    for low, high in itertools.pairwise(edges):
        branch = float(profile.phase_rad(np.array([(low + high) / 2]))[0])
        inside = (times_s >= low) & (times_s < high) if high < times_s[-1] else times_s >= low
        wanted = np.unique(np.concatenate([times_s[inside], [low, high]]))
        path = solve(_derivative(system, plan, branch), _jacobian(system, plan, branch), low, high, state, wanted)
        states[:, inside] = path[:, np.searchsorted(wanted, times_s[inside])]
        state = path[:, -1]
    return states


def _jump_times(plan: ForcePlan, start_s: float, stop_s: float) -> np.ndarray:
    profile = plan.profiles[0]
    found = [np.zeros(0)]
    grid = np.linspace(start_s, stop_s, 1 + max(2, int((stop_s - start_s) * 1e5)))
    phase = profile.phase_rad(grid)
    for k in plan.jumping:
        jumps = plan.forces[k].law.jumps
        assert jumps is not None
        angles = jumps(plan.own_parameters(k)[:, 0], float(phase[0]), float(phase[-1]))
        instant = np.interp(angles, phase, grid)
        for _ in range(3):
            instant = instant - (profile.phase_rad(instant) - angles) / profile.speed_rad_s(instant)
        found.append(instant)
    return np.concatenate(found)


def _forces(plan: ForcePlan, branch: float, time_s: float, x: np.ndarray, forces: int) -> np.ndarray:
    """Return u at one instant for several motions (motions, trials): plain Python, no compiled code."""
    timeline = plan.lane_timeline(0, np.array([time_s]))
    u = np.zeros((forces, x.shape[1]))
    for k, force in enumerate(plan.forces):
        parameters = plan.own_parameters(k)
        extra = {"branch_rad": np.array([[branch]])} if force.law.jumps is not None else {}
        own = force.law.signals(timeline, parameters, **extra)[:, :, 0]
        reads = plan.inputs[plan.rows[k, 1] : plan.rows[k, 2]]
        acts = plan.outputs[plan.rows[k, 3] : plan.rows[k, 4]]
        if force.law.is_linear:
            slope = own[acts.size :].reshape(acts.size, reads.size)
            np.add.at(u, acts, own[: acts.size] + slope @ x[reads])
        else:
            wide = np.repeat(own, x.shape[1], axis=1), np.repeat(parameters, x.shape[1], axis=1)
            force.law.force.py_func(*wide, x, reads, acts, u)
    return u


Derivative = Callable[[float, np.ndarray], np.ndarray]


def _derivative(system: System, plan: ForcePlan, branch: float) -> Derivative:
    forces = system.force_columns.shape[1]

    def derivative(time_s: float, state: np.ndarray) -> np.ndarray:
        x = (system.motion_rows @ state)[:, None]
        return system.core @ state + system.force_columns @ _forces(plan, branch, time_s, x, forces)[:, 0]

    return derivative


def _jacobian(system: System, plan: ForcePlan, branch: float) -> Derivative:
    forces, motions = system.force_columns.shape[1], system.motion_rows.shape[0]

    def jacobian(time_s: float, state: np.ndarray) -> np.ndarray:
        x = (system.motion_rows @ state)[:, None]
        width = 1e-11 + 1e-6 * np.abs(x[:, 0])
        points = np.concatenate([x + np.diag(width), x - np.diag(width)], axis=1)
        u = _forces(plan, branch, time_s, points, forces)
        slope = (u[:, :motions] - u[:, motions:]) / (2 * width)
        return system.core + system.force_columns @ slope @ system.motion_rows

    return jacobian


def _solver(method: str, relative: float, absolute: float | np.ndarray) -> Callable[..., np.ndarray]:
    if method == "CVODE":
        return _cvode(relative, absolute)
    if method not in ("Radau", "BDF", "DOP853", "LSODA"):
        raise InvalidValueError(f"Method {method!r}; allowed: Radau, BDF, DOP853, LSODA, CVODE.")

    def solve(f: Derivative, jac: Derivative, low: float, high: float, state: np.ndarray, at: np.ndarray) -> np.ndarray:
        from scipy.integrate import solve_ivp

        options: dict[str, Any] = {} if method == "DOP853" else {"jac": jac}
        found = solve_ivp(f, (low, high), state, method=method, t_eval=at, rtol=relative, atol=absolute, **options)
        if not found.success:
            raise OracleError(f"{method} stopped at {found.t[-1] if found.t.size else low:.6g} s: {found.message}")
        return found.y

    return solve


def _cvode(relative: float, absolute: float | np.ndarray) -> Callable[..., np.ndarray]:
    try:
        make_solver = importlib.import_module("sksundae.cvode").CVODE
    except ImportError:
        raise InvalidValueError(
            "Method CVODE needs scikit-sundae, which is not installed; allowed without it: Radau, BDF, DOP853, LSODA. "
            "Install it: pip install 'rotorwise[oracle]'."
        ) from None

    def solve(f: Derivative, jac: Derivative, low: float, high: float, state: np.ndarray, at: np.ndarray) -> np.ndarray:
        del low, high

        def right(time_s: float, y: np.ndarray, out: np.ndarray) -> None:
            out[:] = f(time_s, y)

        def slope(time_s: float, y: np.ndarray, _: np.ndarray, out: np.ndarray) -> None:
            out[:] = jac(time_s, y)

        solver = make_solver(right, method="BDF", rtol=relative, atol=absolute, jacfn=slope, max_num_steps=1_000_000)
        # Two times mean to CVODE "every step between them"; a third one in the middle avoids that.
        wanted = np.unique(np.concatenate([at, [(at[0] + at[-1]) / 2]]))
        found = solver.solve(wanted, state)
        if not found.success:
            raise OracleError(f"CVODE stopped: {found.message}")
        return np.asarray(found.y).T[:, np.searchsorted(wanted, at)]

    return solve

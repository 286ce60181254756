"""When the signals of a force jump inside a step: the instants, and its signals on both branches."""

from __future__ import annotations

import numpy as np

from ..speed_profile import SpeedProfile
from .plan import ForcePlan


def jump_events(
    plan: ForcePlan, k: int, which: int, half_times: np.ndarray, half_phase: np.ndarray, signals: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Fill in the signals of jumping force ``k``, continued on the branch of each step's start.

    Parameters
    ----------
    plan : ForcePlan
    k, which : int
        Number of the force among all, and among those that jump.
    half_times : ndarray (2 steps + 1,)
    half_phase : ndarray (2 steps + 1, lanes)
    signals : ndarray (steps, 3, signals, lanes)
        The part of force ``k`` is written in place.

    Returns
    -------
    events : ndarray (events, 4)
        Step, lane, ``which``, time left in the step.
    branches : ndarray (events, 3, 2, signals, 1)
        At the jump, half-way to the end and at the end of the step; on the old and the new branch.
    """
    law, parameters = plan.forces[k].law, plan.own_parameters(k)
    start, stop = half_phase[0:-1:2], half_phase[2::2]
    branch = (start + stop) / 2
    events, branches = [], []
    for lane in range(plan.lanes):
        assert law.jumps is not None
        angles = np.sort(law.jumps(parameters[:, lane], float(start[0, lane]), float(stop[-1, lane])))
        if not angles.size:
            continue
        step = np.clip(np.searchsorted(stop[:, lane], angles, side="left"), 0, start.shape[0] - 1)
        before = np.maximum(start[step, lane], np.concatenate([[-np.inf], angles[:-1]]))
        after = np.minimum(stop[step, lane], np.concatenate([angles[1:], [np.inf]]))
        first = np.concatenate([[True], np.diff(step) > 0])
        branch[step[first], lane] = (before[first] + angles[first]) / 2
        instant = _instants(plan.profiles[lane], angles, half_times[2 * step], half_times[2 * step + 2])
        left = half_times[2 * step + 2] - instant
        events.append(np.column_stack([step, np.full_like(left, lane), np.full_like(left, which), left]))
        at = instant[:, None] + left[:, None] * np.array([0.0, 0.5, 1.0])
        parts = []
        for middle in ((before + angles) / 2, (angles + after) / 2):
            timeline = plan.lane_timeline(lane, at.ravel())
            own = law.signals(timeline, parameters[:, [lane]], branch_rad=np.repeat(middle, 3)[:, None])  # type: ignore[call-arg]
            parts.append(np.moveaxis(own, 0, 1).reshape(angles.size, 3, own.shape[0], 1))
        branches.append(np.stack(parts, axis=2))
    place = slice(plan.rows[k, 5], plan.rows[k, 6])
    for stage in range(3):
        timeline = plan.timeline(half_times[stage : stage + 2 * start.shape[0] : 2])
        signals[:, stage, place] = np.moveaxis(law.signals(timeline, parameters, branch_rad=branch), 0, 1)  # type: ignore[call-arg]
    if not events:
        count = int(plan.rows[k, 6] - plan.rows[k, 5])
        return np.zeros((0, 4)), np.zeros((0, 3, 2, count, 1))
    return np.concatenate(events), np.concatenate(branches)


def _instants(profile: SpeedProfile, angles: np.ndarray, start_s: np.ndarray, stop_s: np.ndarray) -> np.ndarray:
    """Return when the shaft passes the angles, each known to lie in a step."""
    low, high = profile.phase_rad(start_s), profile.phase_rad(stop_s)
    instant = start_s + (angles - low) / np.maximum(high - low, 1e-300) * (stop_s - start_s)
    for _ in range(4):
        instant = instant - (profile.phase_rad(instant) - angles) / np.maximum(profile.speed_rad_s(instant), 1e-300)
        instant = np.clip(instant, start_s, stop_s)
    return instant

"""When the signals of a force jump inside a step: the instants, and its signals on both branches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..law import Timeline, joined_timelines
from ..speed_profile import SpeedProfile
from .plan import ForcePlan, on_all_lanes
from .tables import JUMP_POINTS

#: Numbers of an event that follow from the time left: for the jump, half-way and the end four weights of a displacement
#: and four of a velocity (of displacements, then velocities at start and end of the step); nine of the force difference
#: at these instants; interval of the tables and share of it, half-way and at the end.
SHAPE = 37


def all_jumps(
    plan: ForcePlan, half_times: np.ndarray, step_s: float, timeline: Timeline, signals: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the signals of the forces that jump, continued on the branch of each step's start, and their jumps.

    Parameters
    ----------
    plan : ForcePlan
    half_times : ndarray (2 steps + 1,)
    step_s : float
    timeline : Timeline
        At these times.
    signals : ndarray (steps, 3, signals, lanes)
        Is filled.

    Returns
    -------
    signals : ndarray
    events : ndarray (events, 4 + SHAPE)
        Step, lane, number among the forces that jump, time left in the step, and see `SHAPE`. A jump on the end of the
        step, as a mesh in a whole ratio to the step makes, has no time to act in it and is left out.
    branches : ndarray (events, 6, signals, 1)
        At the jump, half-way to the end and at the end of the step on the old branch, then on the new one.
    """
    events, branches = [], []
    for which, k in enumerate(plan.jumping):
        found, parts = _jump_events(plan, k, which, half_times, timeline, signals)
        events.append(found)
        branches.append(parts)
    joined = np.concatenate(events)
    widest = max(part.shape[2] for part in branches)
    padded = [np.pad(part, [(0, 0)] * 2 + [(0, widest - part.shape[2]), (0, 0)]) for part in branches]
    order = np.lexsort((-joined[:, 3], joined[:, 1], joined[:, 0]))
    order = order[joined[order, 3] > 0]
    events = np.concatenate([joined[order], shapes(joined[order, 3], joined[order, 2], step_s)], axis=1)
    return signals, events, np.ascontiguousarray(np.concatenate(padded)[order])


def shapes(left_s: np.ndarray, which: np.ndarray, step_s: float) -> np.ndarray:
    """Return what follows from the time left in the step, shape (events, SHAPE); ``which`` as in `all_jumps`."""
    share = 1 - left_s[:, None] / step_s * np.array([1.0, 0.5, 0.0])
    square, cube = share**2, share**3
    rise, lean = 3 * square - 2 * cube, 6 * (share - square) / step_s
    motion = [1 - rise, rise, step_s * (share - 2 * square + cube), step_s * (cube - square)]
    speed = [-lean, lean, 1 - 4 * share + 3 * square, 3 * square - 2 * share]
    smooth = np.stack([np.stack(motion, axis=2), np.stack(speed, axis=2)], axis=2)
    quadratic = np.array([[1.0, 0.0, 0.0], [-3.0, 4.0, -1.0], [4.0, -8.0, 4.0]])
    weights = quadratic / left_s[:, None, None] ** np.arange(3)[:, None]
    places = left_s[:, None] * np.array([0.5, 1.0]) * ((JUMP_POINTS - 1) / step_s)
    point = np.minimum(np.floor(places), JUMP_POINTS - 2)
    places = np.stack([point + which[:, None] * (JUMP_POINTS - 1), places - point], axis=2)
    count = left_s.size
    return np.concatenate([smooth.reshape(count, 24), weights.reshape(count, 9), places.reshape(count, 4)], axis=1)


def _jump_events(
    plan: ForcePlan, k: int, which: int, half_times: np.ndarray, timeline: Timeline, signals: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return events and branches of one force, and write its part of ``signals``."""
    phase = timeline.phase_rad[:, plan.distinct_columns(k)]
    branch = (phase[0:-1:2] + phase[2::2]) / 2
    found = [
        _lane_jumps(plan, k, lane, half_times, phase[:, i], branch[:, i]) for i, lane in enumerate(plan.distinct[k][0])
    ]
    parts = _both_branches(plan, k, found)
    # Each instant on the branch of the step that begins there, or that it halves.
    halves = np.concatenate([np.repeat(branch, 2, axis=0), branch[-1:]])
    own = plan.distinct_signals(k, timeline, branch_rad=halves)
    ends = own[:, 2::2].copy()
    for i, (jumps, part) in enumerate(zip(found, parts, strict=True)):
        ends[:, jumps.step[jumps.first], i] = part[jumps.first, 2, :, 0].T
    place = slice(plan.rows[k, 5], plan.rows[k, 6])
    for stage, values in enumerate((own[:, 0:-1:2], own[:, 1::2], ends)):
        signals[:, stage, place] = np.moveaxis(on_all_lanes(plan, k, values), 0, 1)
    events, branches = [], []
    for number, (jumps, part) in enumerate(zip(found, parts, strict=True)):
        lanes = np.flatnonzero(plan.distinct[k][1] == number)
        own = np.empty((lanes.size, jumps.step.size, 4))
        own[:, :, 0], own[:, :, 1], own[:, :, 2], own[:, :, 3] = jumps.step, lanes[:, None], which, jumps.left_s
        events.append(own.reshape(-1, 4))
        branches.append(np.tile(part, (lanes.size, 1, 1, 1)))
    return np.concatenate(events), np.concatenate(branches)


@dataclass(frozen=True)
class _Jumps:
    """The jumps of one force in one lane.

    Attributes
    ----------
    lane : int
    step : ndarray of int (jumps,)
    left_s : ndarray (jumps,)
        From the jump to the end of its step.
    first : ndarray of bool (jumps,)
        Whether it is the first one of its step.
    time_s : ndarray (jumps, 3)
        At the jump, half-way to the end and at the end of the step.
    branch_rad : ndarray (2, jumps)
        An angle on the branch before the jump and on that behind it.
    """

    lane: int
    step: np.ndarray
    left_s: np.ndarray
    first: np.ndarray
    time_s: np.ndarray
    branch_rad: np.ndarray


def _lane_jumps(
    plan: ForcePlan, k: int, lane: int, half_times: np.ndarray, phase: np.ndarray, branch: np.ndarray
) -> _Jumps:
    """Return one lane's jumps; sets ``branch`` in their steps."""
    law, parameters = plan.forces[k].law, plan.own_parameters(k)[:, lane]
    start, stop = phase[0:-1:2], phase[2::2]
    assert law.jumps is not None
    angles = np.sort(law.jumps(parameters, float(start[0]), float(stop[-1])))
    step = np.clip(np.searchsorted(stop, angles, side="left"), 0, start.size - 1)
    before = np.maximum(start[step], np.concatenate([[-np.inf], angles[:-1]])[: angles.size])
    after = np.minimum(stop[step], np.concatenate([angles[1:], [np.inf]])[: angles.size])
    first = np.concatenate([[True], np.diff(step) > 0])[: angles.size]
    branch[step[first]] = (before[first] + angles[first]) / 2
    instant = _instants(plan.profiles[lane], angles, half_times[2 * step], half_times[2 * step + 2])
    left = half_times[2 * step + 2] - instant
    at = instant[:, None] + left[:, None] * np.array([0.0, 0.5, 1.0])
    return _Jumps(lane, step, left, first, at, np.stack([(before + angles) / 2, (angles + after) / 2]))


def _both_branches(plan: ForcePlan, k: int, found: Sequence[_Jumps]) -> list[np.ndarray]:
    """Return the signals at each lane's jumps, (jumps, 6, signals, 1); lanes with the same parameters in one call."""
    law, parameters, wide = plan.forces[k].law, plan.own_parameters(k), int(plan.rows[k, 6] - plan.rows[k, 5])
    parts = [np.zeros((jumps.step.size, 6, wide, 1)) for jumps in found]
    alike: dict[bytes, list[int]] = {}
    for i, jumps in enumerate(found):
        if jumps.step.size:
            alike.setdefault(parameters[:, jumps.lane].tobytes(), []).append(i)
    for members in alike.values():
        timeline = joined_timelines([plan.lane_timeline(found[i].lane, found[i].time_s.ravel()) for i in members])
        edges = np.cumsum([found[i].step.size for i in members])[:-1]
        for side in range(2):
            middle = np.repeat(np.concatenate([found[i].branch_rad[side] for i in members]), 3)[:, None]
            own = law.signals(timeline, parameters[:, [found[members[0]].lane]], branch_rad=middle)  # type: ignore[call-arg]
            own = np.moveaxis(own, 0, 1).reshape(-1, 3, wide, 1)
            for i, part in zip(members, np.split(own, edges), strict=True):
                parts[i][:, 3 * side : 3 * side + 3] = part
    return parts


def _instants(profile: SpeedProfile, angles: np.ndarray, start_s: np.ndarray, stop_s: np.ndarray) -> np.ndarray:
    """Return when the shaft passes the angles, each known to lie in a step."""
    low, high = profile.phase_rad(start_s), profile.phase_rad(stop_s)
    instant = start_s + (angles - low) / np.maximum(high - low, 1e-300) * (stop_s - start_s)
    for _ in range(4):
        instant = instant - (profile.phase_rad(instant) - angles) / np.maximum(profile.speed_rad_s(instant), 1e-300)
        instant = np.clip(instant, start_s, stop_s)
    return instant

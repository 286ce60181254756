"""A damaged tooth: a burst once a turn in what its gear's synchronous average holds beside the mesh.

NA4, the kurtosis of the residual signal, is 3 for noise and low for the few lines of an eccentric or worn gear; one bad
tooth among many raises it (J. J. Zakrajsek, NASA TM-105950 (1993)). A sound gear may have a burst of its own from
manufacture (a measured healthy gearbox has NA4 4.7), so that without a baseline it stays well below certainty; with
one, the growth counts. A burst counts that comes at the same place in most turns: what a bearing's impacts leave of an
average has a high kurtosis too, but the scatter of the turns there is as large as the burst.
"""

from __future__ import annotations

from ..compare import comparable
from ..gear_average import GearAverage, gear_averages
from ..observe import Observation
from ..result import Finding

_NOISE = 3.0
#: Excess over noise, and relative growth, at which the odds are the prior odds; they grow with these powers.
_USUAL_EXCESS, _EXCESS_POWER, _PRIOR = 2.0, 2.5, 0.3
_USUAL_GROWTH, _GROWTH_POWER, _PRIOR_OF_GROWTH = 0.5, 3.0, 0.5
_REPEATS = 5.0  # deviations by which a burst must stand out of the scatter of its turns
_SURE = 4.0  # deviations above noise: kurtosis is skewed, and the largest of a dozen averages is taken
_MOST, _MOST_WITH_BASELINE = 0.8, 0.9
_LEAST_PROBABILITY = 0.02
_CHECK = "Inspect the teeth of this gear; compare with a record from when it was new, at the same load."


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return the gears whose average has a burst."""
    if now.speed is None or not now.turning or not now.recording.nameplate.gears:
        return []
    averages = [one for one in gear_averages(now) if one.repeated >= _REPEATS]
    earlier = gear_averages(baseline) if baseline is not None and comparable(now, baseline) else ()
    findings = []
    for gear in dict.fromkeys(one.gear for one in averages):
        best = max((one for one in averages if one.gear == gear), key=lambda one: one.indicators.na4 / one.deviation)
        before = [one.indicators.na4 for one in earlier if one.gear == gear]
        finding = _finding(now, best, max(before) if before else None)
        if finding is not None:
            findings.append(finding)
    return findings


def _finding(now: Observation, best: GearAverage, before: float | None) -> Finding | None:
    na4 = best.indicators.na4
    if na4 < _NOISE + _SURE * best.deviation:
        return None
    if before is None:
        odds = _PRIOR * ((na4 - _NOISE) / _USUAL_EXCESS) ** _EXCESS_POWER
        most, note = _MOST, "without a baseline this may be the gear's own"
    else:
        odds = _PRIOR_OF_GROWTH * (max(na4 / before - 1.0, 0.0) / _USUAL_GROWTH) ** _GROWTH_POWER
        most, note = _MOST_WITH_BASELINE, f"baseline {before:.1f}"
    probability = most * odds / (1.0 + odds)
    if probability < _LEAST_PROBABILITY:
        return None
    summary = (
        f"Averaged over {best.turns} turns, the {best.gear} has a burst at one place of its turn on "
        f"{now.recording.channels[best.channel].name}: NA4 {na4:.1f} (noise 3; {note}), FM4 {best.indicators.fm4:.1f}."
    )
    return Finding("gear_tooth_fault", probability, summary, (), _CHECK, ("gear_eccentricity",))

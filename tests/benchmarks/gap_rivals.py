"""What others make of the blind trials: calibration by least squares, and PySINDy on the residual.

    OPENBLAS_NUM_THREADS=1 python tests/benchmarks/gap_rivals.py MACHINE COUNT SEED [FAMILY]

PySINDy 2.1 must be installed. Of the first COUNT trials at 30 dB, those that hide nothing or one effect of d2 >= 100.
All get the same recordings, hold out the same conditions, and are judged by the same squared error of the lines there,
in dB below that of the machine as given.

* Least squares (scipy) fits the machine's own uncertain parameters and a complex gain for each probe, within four
  standard deviations of their priors, to the fitted conditions. It cannot name anything.
* PySINDy gets, in every fitted condition, what the calibrated machine leaves of the signals, filtered above 8X, its
  derivative, and as inputs the cosines and sines of 1X to 4X, constant and growing with the square of the speed; the
  library is linear in all of them, the threshold the one that predicts each fitted condition best from the others,
  which may be one that leaves no term.
  It names terms, not causes: right are an order and a direction that the hidden effect states.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pysindy
from rotorwise.datasets.recording import Campaign, Recording
from rotorwise.diagnose.gap.baseline import machine_at, start
from rotorwise.diagnose.gap.evidence import Problem
from rotorwise.diagnose.gap.explain import explain_gap, prepare
from rotorwise.diagnose.gap.gain import residual_power
from rotorwise.diagnose.gap.observe import shaft_turns
from rotorwise.diagnose.gap.prepared import Prepared
from rotorwise.diagnose.gap.trials.cases import TrialCase, make_case
from rotorwise.diagnose.gap.trials.scores import DETECTABLE
from scipy.optimize import least_squares
from scipy.signal import butter, sosfiltfilt

ORDERS, GROWTHS, CUT_ORDER, SAMPLES_A_TURN = (1, 2, 3, 4), (0, 2), 8.0, 40
#: The last one leaves no term.
THRESHOLDS, FARTHEST, ACCURACY = (0.003, 0.01, 0.03, 0.1, 0.3, 1e9), 4.0, 0.01


# ---- least squares ----


def calibrated_lines(case: TrialCase, prepared: Prepared, held_out: Sequence[int]) -> np.ndarray:
    """Return the held-out lines of the machine whose parameters and gains fit the other conditions best."""
    fitted = prepared.problem(prepared.fitted)
    begun = start(case.machine, fitted.predictor)
    active, probes = np.flatnonzero(begun.active), fitted.lines.seen.shape[1]
    lines = fitted.lines
    scale = np.hypot(lines.deviations, ACCURACY * np.abs(lines.amplitudes))[lines.seen]

    def expected(values: np.ndarray, predictor) -> np.ndarray:
        position = begun.position.copy()
        position[active] = values[: active.size]
        gains = 1 + values[active.size : active.size + probes] + 1j * values[active.size + probes :]
        return predictor.amplitudes(machine_at(case.machine, begun.coordinates, position)) * gains[None, :, None]

    def misses(values: np.ndarray) -> np.ndarray:
        left = (lines.amplitudes - expected(values, fitted.predictor))[lines.seen] / scale
        return np.concatenate([left.real, left.imag])

    first = np.concatenate([begun.position[active], np.zeros(2 * probes)])
    reach = np.concatenate([np.full(active.size, FARTHEST), np.full(2 * probes, 0.1)])
    found = least_squares(misses, first, bounds=(first - reach, first + reach), diff_step=1e-3, max_nfev=30)
    return expected(found.x, prepared.predictor.select(held_out))


# ---- PySINDy ----


@dataclass(frozen=True, eq=False)
class Residual:
    """What the machine leaves of one recording: displacement-like signals in their scale, and the shaft's angle."""

    signals: np.ndarray
    phase_rad: np.ndarray
    speed_rad_s: float
    step_s: float


def residual_of(recording: Recording, problem: Problem, condition: int, scale: np.ndarray) -> Residual:
    """Return the signals less the machine's lines, filtered and thinned out."""
    names = [channel.name for channel in recording.channels]
    signals = recording.signals[[names.index(probe) for probe in problem.lines.probes]]
    phase = 2 * np.pi * shaft_turns(recording)
    expected = problem.plain().expected[condition]
    for column, (order, kind) in enumerate(zip(problem.lines.orders, problem.lines.kinds, strict=True)):
        if kind.phase and not kind.envelope:
            signals = signals - (expected[:, column, None] * np.exp(1j * order * phase)).real
    speed = problem.lines.conditions[condition].speed_rpm * 2 * np.pi / 60
    cut = CUT_ORDER * speed / (2 * np.pi)
    sos = butter(4, min(cut, 0.45 * recording.rate_hz), fs=recording.rate_hz, output="sos")
    signals = sosfiltfilt(sos, signals - signals.mean(axis=1, keepdims=True), axis=1)
    every = max(int(recording.rate_hz * 2 * np.pi / speed / SAMPLES_A_TURN), 1)
    edge = int(5 * recording.rate_hz * 2 * np.pi / speed)
    part = slice(edge, -edge, every)
    return Residual(signals[:, part] / scale[:, None], phase[part], speed, every / recording.rate_hz)


@dataclass(frozen=True, eq=False)
class Discovered:
    """r'' = A r + B r' + sum of F (speed / reference)^p exp(i k phi), all in units of the reference speed."""

    stiffness: np.ndarray
    damping: np.ndarray
    forces: dict[tuple[int, int], np.ndarray]
    reference_rad_s: float

    def lines(self, speed_rad_s: float) -> dict[int, np.ndarray]:
        """Return the steady motion's amplitude at each order, shape (probes,)."""
        ratio, eye, found = speed_rad_s / self.reference_rad_s, np.eye(len(self.stiffness)), {}
        for order in ORDERS:
            w = order * ratio
            force = sum(self.forces[order, power] * ratio**power for power in GROWTHS)
            found[order] = np.linalg.solve(-(w**2) * eye - self.stiffness - 1j * w * self.damping, force)
        return found


def discovered(residuals: Sequence[Residual], threshold: float) -> Discovered:
    """Return what PySINDy finds with a threshold."""
    reference = float(np.mean([one.speed_rad_s for one in residuals]))
    states, rates, inputs = [], [], []
    smooth = pysindy.SmoothedFiniteDifference(smoother_kws={"window_length": 7})
    for one in residuals:
        step = one.step_s * reference
        velocity = np.asarray(smooth(one.signals.T, t=step))
        rate = np.asarray(smooth(velocity, t=step))
        ratio = one.speed_rad_s / reference
        waves = [f(k * one.phase_rad) * ratio**p for k in ORDERS for p in GROWTHS for f in (np.cos, np.sin)]
        states.append(np.hstack([one.signals.T, velocity]))
        rates.append(np.hstack([velocity, rate]))
        inputs.append(np.stack(waves, axis=1))
    model = pysindy.SINDy(
        optimizer=pysindy.STLSQ(threshold=threshold, alpha=1e-6),
        feature_library=pysindy.PolynomialLibrary(degree=1, include_bias=False),
    )
    model.fit(states, t=residuals[0].step_s * reference, x_dot=rates, u=inputs)
    count = residuals[0].signals.shape[0]
    terms = np.asarray(model.coefficients())[count:]
    forces, column = {}, 2 * count
    for order in ORDERS:
        for power in GROWTHS:
            forces[order, power] = terms[:, column] - 1j * terms[:, column + 1]
            column += 2
    return Discovered(terms[:, :count], terms[:, count : 2 * count], forces, reference)


def best_discovered(residuals: Sequence[Residual], lines: Sequence[dict[int, np.ndarray]]) -> Discovered:
    """Return the discovery whose threshold predicts each fitted condition best from the others."""

    def error(threshold: float) -> float:
        total = 0.0
        for left_out in range(len(residuals)):
            others = [one for i, one in enumerate(residuals) if i != left_out]
            found = discovered(others, threshold).lines(residuals[left_out].speed_rad_s)
            total += sum(float((np.abs(found[k] - lines[left_out][k]) ** 2).sum()) for k in ORDERS)
        return total if math.isfinite(total) else math.inf

    return discovered(residuals, min(THRESHOLDS, key=error))


def sindy(prepared: Prepared, campaign: Campaign, held_out: Sequence[int]) -> tuple[np.ndarray, Discovered]:
    """Return the held-out lines of the calibrated machine with what PySINDy adds, and that."""
    fitted, unseen = prepared.problem(prepared.fitted), prepared.problem(held_out)
    left = np.where(fitted.lines.seen, fitted.lines.amplitudes - fitted.plain().expected, 0.0)
    scale = np.sqrt((np.abs(left) ** 2).sum(axis=(0, 2)) / len(left)) + 1e-300
    residuals = [residual_of(campaign.recordings[number], fitted, i, scale) for i, number in enumerate(prepared.fitted)]
    columns = {k: list(fitted.lines.orders).index(float(k)) for k in ORDERS}
    lines = [{k: left[i, :, columns[k]] / scale for k in ORDERS} for i in range(len(left))]
    found = best_discovered(residuals, lines)
    expected = unseen.plain().expected.copy()
    for i, condition in enumerate(unseen.lines.conditions):
        for order, own in found.lines(condition.speed_rpm * 2 * np.pi / 60).items():
            expected[i, :, columns[order]] += own * scale
    return expected, found


def names_rightly(found: Discovered, case: TrialCase, probes: Sequence[str]) -> bool:
    """Whether the strongest terms have an order and a direction that the hidden effect states."""
    size = {k: np.abs(sum(found.forces[k, p] for p in GROWTHS)) for k in ORDERS}
    order = max(ORDERS, key=lambda k: float((size[k] ** 2).sum()))
    directions = {one.name: one.direction for one in case.machine.bare_assembly().probes}
    strongest = directions[probes[int(np.argmax(size[order]))]]
    effect = case.hidden[0].effect
    return any(
        line.order == order and line.direction in ("any", strongest, *(("lateral",) if strongest in "xy" else ()))
        for line in effect.signature(case.machine)
    )


# ---- the table ----


def main() -> None:
    """Print one row for each trial and the sums."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("machine")
    arguments.add_argument("count", type=int)
    arguments.add_argument("seed", type=int)
    arguments.add_argument("family", nargs="?", default="score")
    given = arguments.parse_args()
    rows = []
    print("| trial | hidden | said | held-out dB: rotorwise | least squares | PySINDy | its terms right | CPU s |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    for number in range(given.count):
        case = make_case(given.machine, number=number, seed=given.seed, snr_db=30.0, family=given.family)
        if case.kind == "none" or (case.kind == "one" and case.d2 >= DETECTABLE):
            rows.append(row(case, number))
    for label, chosen in (
        ("an effect on the machine", [one for one in rows if one.hidden and not one.is_sensor]),
        ("an effect on the measuring chain", [one for one in rows if one.is_sensor]),
        ("nothing hidden", [one for one in rows if not one.hidden]),
    ):
        if not chosen:
            continue
        right = f"{sum(one.is_right for one in chosen)}, PySINDy's terms {sum(one.terms_right for one in chosen)}"
        medians = ", ".join(f"{np.median([one.gains_db[i] for one in chosen]):.1f}" for i in range(3))
        print(f"{label}: {len(chosen)} trials; right: rotorwise {right}; held-out gain, median, dB: {medians}")


@dataclass(frozen=True)
class Row:
    """One trial: what was hidden, who was right, and the gains of rotorwise, least squares and PySINDy."""

    hidden: str
    is_sensor: bool
    is_right: bool
    terms_right: bool
    gains_db: tuple[float, float, float]


def row(case: TrialCase, number: int) -> Row:
    """Print the row of one trial and return it."""
    seconds = [time.process_time()]
    answer = explain_gap(case.campaign, case.machine)
    seconds.append(time.process_time())
    prepared = prepare(case.campaign, case.machine)
    held_out = prepared.held_out
    problem = prepared.problem(held_out)
    before = residual_power(problem, problem.predictor.amplitudes(case.machine))
    seconds.append(time.process_time())
    powers = [residual_power(problem, calibrated_lines(case, prepared, held_out))]
    seconds.append(time.process_time())
    lines, found = sindy(prepared, case.campaign, held_out)
    powers.append(residual_power(problem, lines))
    seconds.append(time.process_time())
    gains = (answer.gain.held_out_db, *(10 * math.log10(before / max(power, 1e-300)) for power in powers))
    truth = {one.effect.NAME for one in case.hidden}
    names = {one.effect for one in answer.causes}
    nothing = not any(np.any(force) for force in found.forces.values())
    made = Row(
        hidden=" + ".join(truth),
        is_sensor=any(one.effect.STAGE == "sensor" for one in case.hidden),
        is_right=names == truth if truth else answer.kind == "none",
        terms_right=names_rightly(found, case, problem.lines.probes) if truth else nothing,
        gains_db=(gains[0], gains[1], gains[2]),
    )
    cells = [str(number), made.hidden or "nothing", " + ".join(sorted(names)) or answer.kind]
    cells += [f"{gain:.1f}" for gain in gains] + ["yes" if made.terms_right else "no"]
    cells.append(", ".join(f"{seconds[i + 1] - seconds[i]:.0f}" for i in (0, 2, 3)))
    print(f"| {' | '.join(cells)} |", flush=True)
    return made


if __name__ == "__main__":
    main()

"""What ``rotorwise orders``, ``envelope`` and ``sidebands`` share: reading a file, the shaft angle, exit codes."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..simulators.errors import InvalidValueError, RotorwiseError
from .look_options import Request
from .look_read import LEAST_SAMPLES, part_words, read_part

if TYPE_CHECKING:
    from rich.table import Table

    from ..datasets.recording import Recording
    from .memory import MemoryNeed
    from .signal.checks import DataCheck

_DONE, _FILE_FAILED, _OUTPUT_FAILED = 0, 3, 4
_STEADY = 1e-3  # relative change of speed below which lines stay sharp
_VARIES = 0.01  # from which a speed tracked in the vibration is taken as varying
_LEAST_CONFIDENCE, _LEAST_WITHOUT_RANGE = 0.5, 0.8
_NEAR_HINT = (0.5, 1.2)  # a run-up ends near its nominal speed
_SPEEDS_HZ = (4.0, 500.0)


@dataclass(frozen=True, eq=False)
class Looked:
    """A file as the commands use it.

    Attributes
    ----------
    recording : Recording
        Usable vibration channels only, missing samples repaired, offset removed.
    tacho : numpy.ndarray or None
    warnings : tuple of str
    """

    recording: Recording
    tacho: np.ndarray | None
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Shaft:
    """How the shaft turned.

    Attributes
    ----------
    method : str
        ``"tacho"``, ``"vibration, tracked"``, or what `speed_from_vibration` says.
    mean_hz, lowest_hz, highest_hz : float
    confidence : float
    phase_turns : numpy.ndarray, shape (samples,)
    has_mark : bool
        Whether angle zero is a mark on the shaft, so that phases mean something.
    time_s, speed_hz, confidences : numpy.ndarray
        The speed over time.
    """

    method: str
    mean_hz: float
    lowest_hz: float
    highest_hz: float
    confidence: float
    phase_turns: np.ndarray
    has_mark: bool
    time_s: np.ndarray
    speed_hz: np.ndarray
    confidences: np.ndarray

    @property
    def varies(self) -> bool:
        """Whether lines smear unless the record is resampled at equal angles."""
        return (self.highest_hz - self.lowest_hz) > _STEADY * self.mean_hz

    @property
    def words(self) -> str:
        """The speed in one line."""
        if self.highest_hz - self.lowest_hz > _VARIES * self.mean_hz:
            speed = f"{60 * self.lowest_hz:.0f} to {60 * self.highest_hz:.0f} rpm"
        else:
            speed = f"{60 * self.mean_hz:.1f} rpm"
        return f"{speed}, {self.method}, confidence {self.confidence:.0%}"

    def data(self) -> dict[str, Any]:
        """Return the speed for JSON."""
        return {
            "mean_rpm": 60 * self.mean_hz,
            "lowest_rpm": 60 * self.lowest_hz,
            "highest_rpm": 60 * self.highest_hz,
            "method": self.method,
            "confidence": self.confidence,
        }


@dataclass(frozen=True, eq=False)
class Answer:
    """What a command found: for JSON, as tables for the terminal, and as a page that is made only when asked for."""

    data: dict[str, Any]
    lines: tuple[str, ...]
    tables: tuple[Table, ...]
    page: Callable[[], str]


def carry_out(request: Request, work: Callable[[Looked], Answer], *, need: MemoryNeed | None = None) -> int:
    """Read, work, print, write the report; return the exit code. ``need`` says what would fill the memory."""
    from .memory import ADVICE
    from .report.write import check_free

    if request.report is not None:
        try:
            # Before the work, not after: nobody wants to wait for a refusal.
            check_free(request.report.resolve(), force=request.force)
        except RotorwiseError as problem:
            return _say(problem, _OUTPUT_FAILED)
    try:
        looked = open_file(request, need=need)
        answer = work(looked)
    except MemoryError:
        return _say(f"{request.file}: no memory left. {ADVICE}", _FILE_FAILED)
    except (RotorwiseError, OSError) as problem:
        message = str(problem)
        name = str(request.file)
        return _say(message if name in message else f"{name}: {message}", _FILE_FAILED)
    _print(request, looked, answer)
    if request.report is None:
        return _DONE
    from .papers_files import write_whole

    try:
        page = answer.page()
        check_free(request.report.resolve(), force=request.force)
        write_whole(request.report, page)
    except RotorwiseError as problem:
        return _say(problem, _OUTPUT_FAILED)
    print(f"report: {request.report}", file=sys.stderr if request.as_json else sys.stdout)
    return _DONE


def _say(problem: object, code: int) -> int:
    print(f"rotorwise: {problem}", file=sys.stderr)
    return code


def _print(request: Request, looked: Looked, answer: Answer) -> None:
    if request.as_json:
        head = {"file": str(request.file), "warnings": list(looked.warnings)}
        print(json.dumps(head | answer.data, indent=2))
        return
    from rich.console import Console

    from .terminal import escape

    console = Console(highlight=False)
    console.print(f"\n[bold underline]{escape(request.file.name)}[/]", soft_wrap=True)
    for line in answer.lines:
        console.print(escape(line))
    for table in answer.tables:
        console.print()
        console.print(table)
    for warning in looked.warnings:
        console.print(f"[yellow]![/] {escape(warning)}")


def open_file(request: Request, *, need: MemoryNeed | None = None) -> Looked:
    """Return the usable channels of a file, or of the part of it that is asked for.

    Raises
    ------
    RotorwiseError
        When the file cannot be read, would fill the memory, or no channel is usable.
    """
    from .signal.checks import UNUSABLE, check_channel, repair

    recording = read_part(request, need)
    warnings, kept, tacho = [*part_words(request, recording), *recording.warnings], [], None
    for index, channel in enumerate(recording.channels):
        if channel.quantity == "tacho" and tacho is None:
            tacho = repair(recording.signals[index])
            found = _tacho_checks(tacho, recording, channel.name)
        elif channel.is_vibration:
            found = check_channel(recording.signals[index], rate_hz=recording.rate_hz, name=channel.name)
            if not any(check.code in UNUSABLE for check in found):
                kept.append(index)
        else:
            continue
        warnings += [check.message for check in found]
    if not kept:
        held = ", ".join(f"{one.name} ({one.quantity or 'no unit'})" for one in recording.channels)
        raise InvalidValueError(" ".join([f"No usable vibration channel; the file holds {held}.", *warnings]))
    if recording.samples < LEAST_SAMPLES:
        raise InvalidValueError(
            f"Record of {recording.samples} samples; allowed: {LEAST_SAMPLES} or more. Give a longer record."
        )
    part = recording.select(kept)
    signals = np.stack([repair(row) for row in part.signals])
    # In place, and the tacho as a copy, so that of a long record nothing but what is used stays in memory.
    signals -= signals.mean(axis=1, keepdims=True)
    return Looked(replace(part, signals=signals), None if tacho is None else tacho.copy(), tuple(warnings))


def _tacho_checks(tacho: np.ndarray, recording: Recording, name: str) -> list[DataCheck]:
    """Say what was put right in a tacho's pulses, or that they give no speed."""
    from .signal.checks import DataCheck, check_tacho
    from .signal.speed import speed_from_tacho

    pulses = recording.pulses_per_revolution
    if speed_from_tacho(tacho, rate_hz=recording.rate_hz, pulses_per_revolution=pulses) is None:
        words = f"{name}: no pulse train in the tacho channel; the speed comes from elsewhere. Check --tacho."
        return [DataCheck("tacho", name, words, 0.3)]
    return check_tacho(tacho, rate_hz=recording.rate_hz, name=name)


def shaft_of(looked: Looked, *, range_hz: tuple[float, float] | None = None) -> Shaft | None:
    """Return how the shaft turned; None when nothing shows it.

    The tacho comes first. Without one, a range asks for a speed that varies; else sharp lines of a constant speed count
    more than a track, which a bearing's comb may lead astray.
    """
    from_tacho = _from_tacho(looked)
    if from_tacho is not None:
        return from_tacho
    hint = looked.recording.condition.speed_rpm or None
    if range_hz is not None:
        return _tracked(looked, range_hz, least=_LEAST_CONFIDENCE)
    steady = _steady(looked, hint)
    if steady is not None:
        return steady
    near_hint = None if hint is None else (_NEAR_HINT[0] * hint / 60, _NEAR_HINT[1] * hint / 60)
    return _tracked(looked, near_hint or _SPEEDS_HZ, least=_LEAST_WITHOUT_RANGE)


def _steady(looked: Looked, hint_rpm: float | None) -> Shaft | None:
    """Return a constant speed seen in the vibration, where it is sure enough."""
    from .signal.order_tracking import constant_speed_phase
    from .signal.speed import speed_from_vibration

    recording = looked.recording
    found = speed_from_vibration(
        recording.signals,
        rate_hz=recording.rate_hz,
        hint_hz=None if hint_rpm is None else hint_rpm / 60.0,
        known_orders=tuple(gear.mesh_order for gear in recording.nameplate.gears if gear.mesh_order < 60),
        bearing_orders=tuple(
            order * one.shaft_ratio
            for one in recording.nameplate.bearings
            for order in (one.geometry.defect_orders().outer_race, one.geometry.defect_orders().inner_race)
        ),
    )
    if found is None or found.confidence < _LEAST_CONFIDENCE:
        return None
    value = found.speed_hz
    phase = constant_speed_phase(samples=recording.samples, rate_hz=recording.rate_hz, speed_hz=value)
    time = np.array([0.0, recording.duration_s])
    speed, sure = np.full(2, value), np.full(2, found.confidence)
    return Shaft(found.method, value, value, value, found.confidence, phase, False, time, speed, sure)


def _from_tacho(looked: Looked) -> Shaft | None:
    from .signal.order_tracking import phase_from_pulses
    from .signal.speed import speed_from_tacho

    recording = looked.recording
    if looked.tacho is None:
        return None
    pulses = recording.pulses_per_revolution
    found = speed_from_tacho(looked.tacho, rate_hz=recording.rate_hz, pulses_per_revolution=pulses)
    if found is None:
        return None
    estimate, times = found
    phase = phase_from_pulses(times, samples=recording.samples, rate_hz=recording.rate_hz, pulses_per_revolution=pulses)
    if np.any(phase[1:] <= phase[:-1]):
        return None
    # Over a turn at least, so that unevenly spaced marks do not show as a varying speed.
    grid = np.linspace(times[0], times[-1], max(min(int(phase[-1] - phase[0]), 400), 2))
    angle = np.interp(grid * recording.rate_hz, np.arange(phase.size), phase)
    speed = np.diff(angle) / np.diff(grid)
    sure = np.full(speed.size, estimate.confidence)
    low, high = (float(value) for value in np.percentile(speed, [1, 99]))
    middle = 0.5 * (grid[1:] + grid[:-1])
    return Shaft("tacho", estimate.speed_hz, low, high, estimate.confidence, phase, pulses == 1, middle, speed, sure)


def _tracked(looked: Looked, range_hz: tuple[float, float], *, least: float) -> Shaft | None:
    """Return the speed tracked in the vibration, where half of the frames are as sure as asked."""
    from .signal.speed_track import track_speed

    recording = looked.recording
    low, high = range_hz
    try:
        found = track_speed(recording.signals, rate_hz=recording.rate_hz, lowest_hz=low, highest_hz=high)
    except InvalidValueError:
        return None  # too short to be tracked
    sure = float(np.median(found.confidence))
    if sure < least:
        return None
    lowest, highest = (float(value) for value in np.percentile(found.speed_hz, [1, 99]))
    mean = float((found.phase_turns[-1] - found.phase_turns[0]) * recording.rate_hz / (recording.samples - 1))
    return Shaft(
        "vibration, tracked", mean, lowest, highest, sure, found.phase_turns, False, found.time_s, found.speed_hz,
        found.confidence,
    )  # fmt: skip


def without_speed(looked: Looked, range_hz: tuple[float, float] | None) -> InvalidValueError:
    """Return the error of a command that needs a speed and has none."""
    hint = looked.recording.condition.speed_rpm
    where, advice = "", "Give --tacho, or --speed RPM, or --speed-range LOW-HIGH for a run-up."
    if range_hz is not None:
        where = f" between {60 * range_hz[0]:g} and {60 * range_hz[1]:g} rpm"
        advice = "Widen --speed-range, or take a longer record."
    elif hint:
        where, advice = f" near {hint:g} rpm", "Give --tacho, or --speed-range LOW-HIGH for a run-up."
    if looked.tacho is not None:
        where = f"{where}, and no even pulses in the tacho channel"
        advice = advice.replace("Give --tacho", "Name another channel with --tacho")
    return InvalidValueError(f"No shaft speed found in the vibration{where}. {advice}")


def at_equal_angles(looked: Looked, shaft: Shaft | None) -> tuple[np.ndarray, float]:
    """Return the signals and their rate, resampled to the mean speed where the speed varies."""
    recording = looked.recording
    if shaft is None or not shaft.varies:
        return recording.signals, recording.rate_hz
    per_turn = int(recording.rate_hz / shaft.mean_hz)
    if per_turn < 8:
        return recording.signals, recording.rate_hz
    from .signal.order_tracking import angular_resample

    even = angular_resample(recording.signals, phase_turns=shaft.phase_turns, samples_per_turn=per_turn)
    return even, per_turn * shaft.mean_hz

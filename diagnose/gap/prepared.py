"""What the search works on: the lines to explain beside a machine that is calibrated on its healthy lines."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline, again, shifted
from .bends import with_bends
from .calibration import relinearised, residual_error, settled_further
from .changed_transfer import ChangedTransfer
from .envelope_lines import Spectrum
from .evidence import Problem
from .form_error import FormErrors
from .healthy_machine import healthy_machine
from .lines import OrderLines
from .loose_contact import Spikes
from .met_lines import with_made_lines
from .model_error import ModelError, model_error
from .model_form import Extended
from .predict import Predictor, UnpredictableError
from .pulse_place import turned
from .record_scatter import record_scatter
from .slow_sway import Sway
from .track_run_out import beside_run_out
from .transfer_error import TransferError, learnt, none_of
from .unsteady import Unsteady
from .without_healthy import UNSEEN, OnLines, on_lines_to_explain, pulse_doubted

#: From so many conditions on, a part of them is held out.
CONDITIONS_TO_HOLD_OUT = 4
#: Relative change of any line from one run of the same machine to the next, its speed and temperature nearly the same.
REPEATABILITY = 0.005


@dataclass(frozen=True, eq=False)
class Prepared:
    """What the search works on.

    Attributes
    ----------
    measured : OrderLines
        All conditions to explain.
    fitted, held_out : tuple of int
        Numbers of the conditions that are fitted, and of those that are not.
    healthy : OrderLines or None
    predictor : Predictor
        For all conditions to explain.
    healthy_predictor : Predictor or None
    baseline : Baseline
        Calibrated, in all conditions to explain.
    at_healthy : Baseline or None
    error : ndarray (probes, orders) or ModelError
    transfer : TransferError
    waveform : mapping of str to tuple of str
        Channels that show an effect of the measuring chain directly, by the effect's name.
    flawed : tuple of str
        Channels whose waveform shows a defect that no effect that competes makes.
    found_lines : tuple of tuple of float
        Order and added frequency (Hz) of the lines that the recordings show and that no effect states.
    pulse_rad : float
        Angle of the machine at the tacho's pulse: the lines' phases are counted from the machine's zero.
    form : Extended or None
        What the healthy recordings say that the model lacks; None where that was not looked for.
    by_lines : OnLines or None
        Without healthy recordings: what the lines to explain say of the machine by itself.
    envelopes : tuple of Spectrum
        What stands out of the envelopes of the recordings to explain; empty where only lines are known.
    mended : bool
        Whether samples that had been lost were put back.
    unsteady : tuple of Unsteady
        Records that do not repeat as the healthy machine does.
    transfers : tuple of ChangedTransfer
        Channels that see the machine by another way than the healthy records did.
    sways : tuple of Sway
        Channels that move more slowly than the records can tell.
    spikes : tuple of Spikes
        Of loose contacts, that were taken out of the recordings, the healthy ones among them.
    """

    measured: OrderLines
    fitted: tuple[int, ...]
    held_out: tuple[int, ...]
    healthy: OrderLines | None
    predictor: Predictor
    healthy_predictor: Predictor | None
    baseline: Baseline
    at_healthy: Baseline | None
    error: np.ndarray | ModelError
    transfer: TransferError
    waveform: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    flawed: tuple[str, ...] = ()
    found_lines: tuple[tuple[float, float], ...] = ()
    pulse_rad: float = 0.0
    form: Extended | None = None
    by_lines: OnLines | None = None
    envelopes: tuple[Spectrum, ...] = ()
    mended: bool = False
    unsteady: tuple[Unsteady, ...] = ()
    transfers: tuple[ChangedTransfer, ...] = ()
    sways: tuple[Sway, ...] = ()
    spikes: tuple[Spikes, ...] = ()

    def problem(self, chosen: Sequence[int]) -> Problem:
        """Return the problem of some of the conditions."""
        part = replace(
            self.baseline, lines=self.baseline.lines[list(chosen)], slopes=self.baseline.slopes[:, list(chosen)]
        )
        predictor = self.predictor.select(chosen)
        healthy = self.healthy_predictor or predictor
        return Problem(
            self.measured.select(chosen),
            part,
            self.healthy,
            self.at_healthy,
            self.error,
            self.transfer,
            predictor,
            healthy,
        )


def put_together(
    machine: Machine,
    measured: OrderLines,
    predictor: Predictor,
    healthy: OrderLines | None = None,
    healthy_predictor: Predictor | None = None,
    *,
    as_given: bool = False,
    tell: Callable[[str], None] = lambda _: None,
) -> Prepared:
    """Return the machine calibrated on its healthy lines, or on those to explain where there are none.

    Parameters
    ----------
    machine : Machine
    measured, healthy : OrderLines
        To explain, and of the healthy machine; of the same probes and lines.
    predictor, healthy_predictor : Predictor
        For their conditions.
    as_given : bool
        Do not add what the healthy lines say that the model lacks.
    """
    held_out = _held_out(measured)
    fitted = tuple(i for i in range(len(measured.conditions)) if i not in held_out)
    found, by_lines = None, None
    if healthy and healthy_predictor:
        highest = max(one.speed_rpm for one in (*measured.conditions, *healthy.conditions))
        calibrated = functools.partial(
            healthy_machine, machine, predictor=healthy_predictor, reference_rpm=highest, as_given=as_given, tell=tell
        )
        found, healthy = beside_run_out(calibrated, healthy, machine, healthy_predictor)
        measured, healthy = turned(measured, found.pulse_rad), turned(healthy, found.pulse_rad)
        baseline, at_calibration = settled_in_both(found.at_healthy, healthy, healthy_predictor, predictor, tell)
    else:
        by_lines = on_lines_to_explain(machine, measured.select(fitted), predictor.select(fitted), tell=tell)
        at_calibration = by_lines.baseline
        baseline = pulse_doubted(again(at_calibration, at_calibration.machine, predictor), predictor)
    if found and found.errors and healthy_predictor:
        baseline, at_calibration = _doubted(found.errors, baseline, predictor, at_calibration, healthy_predictor)
    if healthy and healthy_predictor and predictor.repeats(at_calibration.machine):
        both = [(baseline, predictor), (at_calibration, healthy_predictor)]
        baseline, at_calibration = with_bends(at_calibration, healthy, both)
    error = residual_error(at_calibration, healthy) if healthy else UNSEEN * model_error(at_calibration.lines)
    transfer = _learnt(machine, at_calibration, healthy, error) if healthy else none_of(measured)
    # From here on the model error has it.
    healthy = healthy and replace(healthy, constant=None)
    return Prepared(
        measured=with_made_lines(measured, baseline.lines, at_calibration.lines) if healthy else measured,
        fitted=fitted,
        held_out=held_out,
        healthy=healthy,
        predictor=predictor,
        healthy_predictor=healthy_predictor,
        baseline=baseline,
        at_healthy=at_calibration if healthy else None,
        error=error,
        transfer=replace(transfer, by_record=record_scatter(measured, baseline.lines)),
        pulse_rad=found.pulse_rad if found else 0.0,
        by_lines=by_lines,
        form=found.form if found else None,
    )


def settled_in_both(
    current: Baseline,
    healthy: OrderLines,
    healthy_predictor: Predictor,
    predictor: Predictor,
    tell: Callable[[str], None],
) -> tuple[Baseline, Baseline]:
    """Return the calibrated machine in the conditions to explain and in the healthy ones, linearised at one place.

    Of a machine that does not repeat itself calibration has the slopes of where it began, and a size that passes its
    least falls there with what makes it rise here: the healthy lines would promise the opposite of what they say.
    """
    machine = current.machine
    if predictor.repeats(machine):
        return again(current, machine, predictor), current
    tell("slopes of the calibrated machine")
    current = relinearised(current, machine, healthy_predictor)
    settled = settled_further(current, healthy, healthy_predictor, tell=tell)
    baseline, moved = again(current, machine, predictor), settled.position - current.position
    return (shifted(baseline, machine, moved, predictor) if moved.any() else baseline), settled


def _learnt(
    machine: Machine, at_healthy: Baseline, healthy: OrderLines, error: np.ndarray | ModelError
) -> TransferError:
    """Return by how much responses may be wrong, over the speeds over which what the machine misses changes."""
    known = {"length": error.length, "constant": error.common} if isinstance(error, ModelError) else {}
    return learnt(at_healthy, healthy, machine.bare_assembly().probes, **known)


def _doubted(
    errors: FormErrors,
    baseline: Baseline,
    predictor: Predictor,
    at_healthy: Baseline,
    healthy_predictor: Predictor,
) -> tuple[Baseline, Baseline]:
    """Return the machine in both sets of conditions with its errors of form; without where they cannot be computed."""
    try:
        return errors.joined_to(baseline, predictor), errors.joined_to(at_healthy, healthy_predictor)
    except UnpredictableError:
        return baseline, at_healthy


def _held_out(measured: OrderLines) -> tuple[int, ...]:
    """Return every fourth condition by speed, never the lowest or the highest; none of fewer than four."""
    count = len(measured.conditions)
    if count < CONDITIONS_TO_HOLD_OUT:
        return ()
    by_speed = sorted(range(count), key=lambda i: (measured.conditions[i].speed_rpm, i))
    return tuple(sorted(by_speed[2:-1:4])) or (by_speed[1],)

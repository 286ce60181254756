"""`explain_lines`: the same answer from a table of order lines, where a monitoring system kept no waveforms."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...simulators.errors import InvalidValueError
from ...simulators.machine import Machine
from ...simulators.solvers.blas import single_blas_thread
from .asked import check_machine, known_effects
from .explain import explained
from .lines import OrderLines
from .observe import with_floor, with_reference
from .predict import Predictor
from .prepared import REPEATABILITY, put_together
from .probe_ranges import in_proportion
from .result import GapResult


@single_blas_thread
def explain_lines(
    measured: OrderLines,
    machine: Machine,
    *,
    rate_hz: float,
    duration_s: float,
    healthy: OrderLines | None = None,
    without: frozenset[str] = frozenset(),
    only: frozenset[str] | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> GapResult:
    """Return what a simulated machine gets wrong about measured order lines, its cause, and the gain of adding it.

    What only a waveform shows (clipping, lost samples, lines at unexpected places) is not looked for.

    Parameters
    ----------
    measured : OrderLines
        To explain. Probes are named like the machine's. Deviations say how well a line repeats from one record to the
        next, which a table of single records does not tell by itself.
    machine : Machine
    rate_hz, duration_s : float
        Sampling rate and length of the records that the lines were read from: what is simulated in time or through
        a measuring chain is read like them.
    healthy : OrderLines, optional
        Of the healthy machine, with the same probes, orders and kinds.
    without, only : frozenset of str
        Effects that do not compete, or the only ones that do.
    tell : callable

    Raises
    ------
    InvalidValueError
        For probes that the machine does not have, lines that do not match, or numbers that are none.
    """
    check_machine(machine)
    without, only = known_effects(without, "without"), only and known_effects(only, "only")
    _check(measured, machine, healthy, rate_hz, duration_s)
    measured, *rest = with_reference(
        *(with_floor(one, REPEATABILITY) for one in (measured, healthy) if one is not None)
    )
    before = rest[0] if rest else None
    # No range is known; it holds at least what all lines of a condition sum up to.
    largest = np.max([np.abs(one.amplitudes).sum(axis=2).max(axis=0) for one in (measured, *rest)], axis=0)
    ranges = in_proportion(largest, measured, *rest)
    prepared = put_together(
        machine,
        measured,
        _predictor(measured, rate_hz, duration_s, ranges),
        before,
        None if before is None else _predictor(before, rate_hz, duration_s, ranges),
        tell=tell,
    )
    return explained(prepared, machine, without, only, tell)


def _predictor(lines: OrderLines, rate_hz: float, duration_s: float, ranges: np.ndarray) -> Predictor:
    count = len(lines.conditions)
    samples = round(rate_hz * duration_s)
    return Predictor(
        lines.conditions,
        lines.probes,
        lines.orders,
        (rate_hz,) * count,
        (samples,) * count,
        lines.kinds,
        lines.reference,
        full_scale=ranges,
    )


def _check(
    measured: OrderLines, machine: Machine, healthy: OrderLines | None, rate_hz: float, duration_s: float
) -> None:
    known = [probe.name for probe in machine.bare_assembly().probes]
    strange = [name for name in measured.probes if name not in known]
    if strange:
        raise InvalidValueError(
            f"Probe {strange[0]!r} of the lines is none of {machine.name}; allowed: {', '.join(known)}. Name them like "
            "the machine's."
        )
    for name, value in (("rate_hz", rate_hz), ("duration_s", duration_s)):
        if not (np.isfinite(value) and value > 0):
            raise InvalidValueError(f"{name} = {value!r}; allowed: above 0. Correct it.")
    for one in (measured, healthy):
        if one is None:
            continue
        if not one.conditions:
            raise InvalidValueError("Lines in no condition; allowed: one or more. Give lines.")
        if not np.isfinite(one.amplitudes[one.seen]).all() or not (one.deviations > 0).all():
            raise InvalidValueError(
                "Lines that are not a number, or without a positive deviation; allowed: numbers, and an infinite "
                "deviation for a line that was not seen. Correct them."
            )
        if (one.probes, one.orders, one.kinds) != (measured.probes, measured.orders, measured.kinds):
            raise InvalidValueError(
                f"Healthy lines of {', '.join(one.probes)} at orders {one.orders}; allowed: those of "
                f"the lines to explain, {', '.join(measured.probes)} at {measured.orders}. Make them alike."
            )

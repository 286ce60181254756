"""Run-out of the tracks under proximity probes in healthy recordings, when the machine is calibrated.

A probe sees scratches and out-of-round of the shaft's surface as well: at every whole order the same amount, whatever
the speed. A machine that is calibrated without that bends its parameters for it, and points its unbalance elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline
from .healthy_evidence import evidence
from .healthy_machine import HealthyMachine
from .lines import OrderLines
from .predict import Predictor
from .pulse_place import turned

#: Standard deviations that are tried, m, of 1X; of harmonic n a part n of it. API 670 allows 6 um; the field has more.
SIZES_M = (5e-7, 2e-6, 8e-6, 3.2e-5)
#: Conditions that tell a run-out, and the evidence that it must bring.
FEWEST, LEAST_GAIN = 3, 5.0


def with_run_out(healthy: OrderLines, size_m: float, tracks: Collection[str]) -> OrderLines:
    """Return the lines, those of whole orders with a part that all conditions have alike, of unknown size.

    Parameters
    ----------
    healthy : OrderLines
    size_m : float
        Standard deviation at 1X.
    tracks : collection of str
        Probes that look at a shaft's surface.
    """
    orders = np.array(healthy.orders)
    whole = np.array([kind.phase for kind in healthy.kinds]) & (orders == np.round(orders)) & (orders > 0)
    own = np.array([name in tracks for name in healthy.probes])[:, None] & whole
    return replace(healthy, constant=np.where(own, size_m / np.maximum(orders, 1.0), 0.0))


def likeliest_run_out(current: Baseline, healthy: OrderLines, tracks: Collection[str]) -> OrderLines | None:
    """Return the lines with the run-out that makes them likeliest about a machine; None where none does clearly."""
    tied = all(one.tied for one in healthy.conditions)
    if not tied or len(healthy.conditions) < FEWEST or not set(tracks) & set(healthy.probes):
        return None
    tried = [with_run_out(healthy, size, tracks) for size in SIZES_M]
    worth = [evidence(current, one) for one in tried]
    best = int(np.argmax(worth))
    return tried[best] if worth[best] > evidence(current, healthy) + LEAST_GAIN else None


def beside_run_out(
    calibrated: Callable[[OrderLines], HealthyMachine], healthy: OrderLines, machine: Machine, predictor: Predictor
) -> tuple[HealthyMachine, OrderLines]:
    """Return the machine as its healthy lines show it, and these with the run-out beside which they do so.

    Parameters
    ----------
    calibrated : callable
        What healthy lines say of the machine.
    healthy : OrderLines
    machine : Machine
    predictor : Predictor
        For their conditions. Where the machine does not repeat, another calibration would take minutes: what the
        run-out changes is left to its last steps.
    """
    found = calibrated(healthy)
    tracks = [probe.name for probe in machine.bare_assembly().probes if probe.unit == "m"]
    beside = likeliest_run_out(found.at_healthy, turned(healthy, found.pulse_rad), tracks)
    if beside is None:
        return found, healthy
    healthy = replace(healthy, constant=beside.constant)
    if predictor.repeats(machine):
        other = calibrated(healthy)
        found = max(found, other, key=lambda one: _worth(one, healthy))
    return found, healthy


def _worth(found: HealthyMachine, healthy: OrderLines) -> float:
    price = found.form.price if found.form else 0.0
    return evidence(found.at_healthy, turned(healthy, found.pulse_rad)) - price

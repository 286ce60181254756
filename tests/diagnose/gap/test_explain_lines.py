"""The engine on a table of order lines: 1X with its phase, 2X as a size only, as monitoring systems keep them."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.gap.explain_lines import explain_lines
from rotorwise.diagnose.gap.lines import LineKind, OrderLines
from rotorwise.diagnose.gap.observe import observe_orders
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.errors import InvalidValueError

from .made_campaigns import recorded

SPEEDS_RPM = (600.0, 900.0, 1300.0, 1700.0)
HIDDEN = Unbalance(at="rotor_2", moment_kg_m=8e-3, angle_rad=0.8)
READ_FROM = {"rate_hz": 500.0, "duration_s": 6.0}
COMPETING = frozenset(
    ("unbalance", "rotating_coupling_force", "coupling_misalignment", "bolt_loss", "remounted_sensor", "run_out")
)
#: How well a line repeats, and the instrument's resolution.
SHARE, LEAST_M = 0.01, 2e-7


def _table(recordings) -> OrderLines:
    probes = [channel.name for channel in recordings[0].channels if channel.quantity == "displacement"]
    kinds = (LineKind(), LineKind(phase=False))
    (lines,) = observe_orders(recordings, orders=(1.0, 2.0), channels={name: name for name in probes}, kinds=kinds)
    size = np.abs(lines.amplitudes)
    return replace(lines, deviations=np.hypot(SHARE * size, LEAST_M))


@pytest.fixture(scope="module")
def tables() -> dict[str, OrderLines]:
    real = rigid_coupling.with_parameters(support_2_n_m=1.06 * rigid_coupling.values["support_2_n_m"])
    states = {"healthy": (real, 1), "again": (real, 21), "unbalanced": (real.with_effects(HIDDEN), 11)}
    return {
        name: _table(recorded(machine, SPEEDS_RPM, seed=seed, settle_s=40.0, **READ_FROM))
        for name, (machine, seed) in states.items()
    }


def test_the_hidden_unbalance_is_found_from_the_table(tables):
    answer = explain_lines(tables["unbalanced"], rigid_coupling, healthy=tables["healthy"], only=COMPETING, **READ_FROM)
    assert answer.kind == "one cause"
    (cause,) = answer.causes
    assert (cause.effect, cause.at) == ("unbalance", "rotor_2")
    assert cause.probability > 0.95
    moment, angle = cause.parameters["moment_kg_m"], cause.parameters["angle_rad"]
    assert moment.low < HIDDEN.moment_kg_m < moment.high < 1.5 * moment.low
    assert angle.low < HIDDEN.angle_rad < angle.high
    assert answer.gain.held_out_db > answer.gain.calibration_only_db + 10


def test_a_sound_machine_lacks_nothing(tables):
    answer = explain_lines(tables["again"], rigid_coupling, healthy=tables["healthy"], only=COMPETING, **READ_FROM)
    assert answer.kind == "none"


def test_lines_that_cannot_be_used_are_told(tables):
    lines = tables["again"]
    allowed = {"machine": rigid_coupling, "only": COMPETING, **READ_FROM}
    with pytest.raises(InvalidValueError, match="Probe 'nowhere' of the lines is none of"):
        explain_lines(replace(lines, probes=("nowhere", *lines.probes[1:])), **allowed)
    with pytest.raises(InvalidValueError, match="without a positive deviation"):
        explain_lines(replace(lines, deviations=0 * lines.deviations), **allowed)
    with pytest.raises(InvalidValueError, match="not a number"):
        explain_lines(replace(lines, amplitudes=np.nan * lines.amplitudes), **allowed)
    with pytest.raises(InvalidValueError, match="rate_hz = -1"):
        explain_lines(lines, **{**allowed, "rate_hz": -1.0})
    with pytest.raises(InvalidValueError, match="Make them alike"):
        explain_lines(lines, healthy=replace(lines, orders=(1.0, 3.0)), **allowed)
    with pytest.raises(InvalidValueError, match="in no condition"):
        explain_lines(lines.select([]), **allowed)

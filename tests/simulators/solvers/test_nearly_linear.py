"""Balances that keep the slopes of nearly linear forces: the same motions as with all slopes in every step."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.simulators import find_machine
from rotorwise.simulators.effects import BoltLoss, CouplingMisalignment, Looseness, Rub, Unbalance
from rotorwise.simulators.errors import RotorwiseError
from rotorwise.simulators.law import InterfaceForce
from rotorwise.simulators.rotor_dynamics import bolted_flange_exact
from rotorwise.simulators.solvers import newton_balance
from rotorwise.simulators.solvers.harmonic_balance import forget, harmonic_balance, harmonic_balances

from . import small_machines

RPM = 60.0 / (2 * np.pi)
#: So that Newton's method ends on the last digits in both ways.
CLOSE = 1e-8


def _with_all_slopes(monkeypatch, machine, speed_rpm):
    law = replace(bolted_flange_exact.EXACT_FLANGE, nearly_linear=False)
    with monkeypatch.context() as patched:
        patched.setattr(bolted_flange_exact, "EXACT_FLANGE", law)
        forget()
        assert not any(force.law.nearly_linear for force in machine.system(speed_rpm=speed_rpm).forces)
        found = harmonic_balance(machine, speed_rpm=speed_rpm, harmonics=8).amplitudes
    forget()
    return found


@pytest.mark.parametrize(
    "effects",
    [
        (Unbalance(at="rotor_1", moment_kg_m=2e-2),),
        (Unbalance(at="rotor_1", moment_kg_m=0.1), CouplingMisalignment(offset_m=5e-4)),
        (BoltLoss(loss=0.8), CouplingMisalignment(offset_m=1e-4)),
        (Looseness(at="support_1", loss=0.903, hold=-0.469, rounding=0.094),),
        (Rub(at="seal_2", stiffness_n_m=1e5, friction=0.05, interference_m=2e-6, clearance_m=2e-4),),
    ],
    ids=["unbalance", "large offset", "lost bolt", "loose support", "rub"],
)
def test_a_flange_that_keeps_its_slopes_moves_the_same(monkeypatch, effects):
    machine = find_machine("rigid_coupling").with_effects(*effects)
    assert any(force.law.nearly_linear for force in machine.system(speed_rpm=700.0).forces)
    kept = harmonic_balance(machine, speed_rpm=700.0, harmonics=8).amplitudes
    whole = _with_all_slopes(monkeypatch, machine, 700.0)
    assert np.abs(kept - whole).max(axis=1) == pytest.approx(0.0, abs=CLOSE * np.abs(whole).max())


def _build_with_a_far_stop(assembly, values, switches):
    small_machines._build_duffing(assembly, values, switches)
    x = ({"a": 1.0},)
    assembly.forces.append(InterfaceForce("stop", small_machines.STOP, (1.0, 1e3), x, x))


def _duffing(**values):
    return small_machines.define(_build_with_a_far_stop, step_s=0.05, settle_s=0.0, **values)


def test_slopes_that_change_after_all_are_computed(monkeypatch):
    # The cubic spring has no slope at rest: kept, it leads nowhere where the drive is large.
    values, asked = {"stiffness": 100.0, "cubic": 50.0, "drive": 60.0, "damping": 0.5, "parametric": 0.0}, []
    whole = harmonic_balance(_duffing(**values), speed_rpm=6.0 * RPM, harmonics=7).amplitudes
    have_changed = newton_balance._have_changed
    monkeypatch.setattr(newton_balance, "_have_changed", lambda *given: asked.append(have_changed(*given)) or asked[-1])
    monkeypatch.setattr(small_machines, "CUBIC", replace(small_machines.CUBIC, nearly_linear=True))
    found = harmonic_balance(_duffing(**values), speed_rpm=6.0 * RPM, harmonics=7).amplitudes
    assert asked[0].all()
    np.testing.assert_allclose(found, whole, rtol=CLOSE, atol=CLOSE * np.abs(whole).max())


def test_a_machine_without_a_motion_at_one_speed_is_not_sought_further_at_the_others(monkeypatch):
    loose = Looseness(at="support_1", loss=0.947, hold=0.094, rounding=0.146)
    machine, counted = find_machine("rigid_coupling").with_effects(loose), []
    newton = newton_balance._newton

    def counting(forces, part, lanes, *others, **named):
        counted.append(lanes.size)
        return newton(forces, part, lanes, *others, **named)

    monkeypatch.setattr(newton_balance, "_newton", counting)

    def work(*cases):
        counted.clear()
        found = harmonic_balances(cases, harmonics=8)
        return sum(counted), [not isinstance(one, RotorwiseError) for one in found]

    together, found = work((machine, [700.0, 1500.0]))
    assert found == [False]
    apart, found = work((machine, [700.0]), (machine, [1500.0]))
    assert found == [False, True]
    assert together < apart

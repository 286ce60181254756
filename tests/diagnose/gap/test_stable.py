"""Springs that a machine's damping cannot hold are told, on linear machines and on one whose coupling is not."""

import math

import pytest
from rotorwise.diagnose.gap.stable import is_stable
from rotorwise.simulators import amb_rotor, rigid_coupling, test_rig
from rotorwise.simulators.effects.empirical_stiffness import EmpiricalStiffness

NONE = {"stiffness_n_m": 0.0, "difference_n_m": 0.0, "cross_n_m": 0.0, "damping_n_s_m": 0.0}


def with_cross(machine, at, share):
    """Return a machine with a share of the cross-coupled stiffness that a mass on that support holds, c sqrt(k / m)."""
    values = machine.values
    stiffness, damping, mass = (values[name] for name in ("support_1_n_m", "support_damping_1_n_s_m", "mass_1_kg"))
    cross = share * damping * math.sqrt(stiffness / mass)
    return machine.with_effects(EmpiricalStiffness(at=at, **{**NONE, "cross_n_m": cross}))


@pytest.mark.parametrize("machine", [amb_rotor, rigid_coupling, test_rig], ids=lambda one: one.name)
def test_a_machine_as_given_is_stable(machine) -> None:
    assert is_stable(machine, (900.0, 1500.0))


@pytest.mark.parametrize(("share", "expected"), [(0.3, True), (-0.3, True), (20.0, False), (-20.0, False)])
def test_what_the_damping_holds(share: float, expected: bool) -> None:
    assert is_stable(with_cross(rigid_coupling, "bearing_1", share), (900.0, 1500.0)) is expected


@pytest.mark.parametrize("machine", [amb_rotor, test_rig], ids=lambda one: one.name)
def test_negative_damping_grows(machine) -> None:
    at = next(p.name for p in machine.bare_assembly().places.values() if "bearing" in p.roles)
    driven = machine.with_effects(EmpiricalStiffness(at=at, **{**NONE, "damping_n_s_m": -1e5}))
    assert not is_stable(driven, (900.0, 1500.0))

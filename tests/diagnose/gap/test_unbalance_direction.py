"""The direction of a machine's own unbalance and the pulse's place on the shaft, told apart by healthy lines."""

import math

import numpy as np
import pytest
from rotorwise.diagnose.gap.healthy_machine import healthy_machine
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.pulse_place import turned
from rotorwise.diagnose.gap.unbalance_direction import own_unbalance
from rotorwise.simulators import amb_rotor, gearbox, rigid_coupling, test_rig
from rotorwise.simulators.machine import Machine

ORDERS = (1.0, 2.0, 3.0)
SPEEDS_RPM = (1200.0, 2000.0, 3000.0, 4100.0)
NOISE_M = 1e-8
#: Away from what is given, within the priors.
OFF = {"coupling_stiffness_n_m": 1.06, "coupling_rotational_stiffness_n_m_rad": 0.95, "unbalance_kg_m": 1.05,
       "shaft_diameter_m": 1.002, "shaft_length_m": 0.997}  # fmt: skip


def _predictor(machine: Machine, *, tied: bool = True) -> Predictor:
    probes = tuple(p.name for p in machine.bare_assembly().probes if p.quantity in ("displacement", "acceleration"))
    conditions, count = tuple(Condition(speed, tied=tied) for speed in SPEEDS_RPM), len(SPEEDS_RPM)
    kinds = (LineKind(),) * len(ORDERS)
    return Predictor(conditions, probes, ORDERS, (10_000.0,) * count, (20_000,) * count, kinds, (0,) * len(ORDERS))


def _healthy(predictor: Predictor, machine: Machine, share: float = 0.0) -> OrderLines:
    """Return its lines in noise of `NOISE_M`, or of a share of the largest line."""
    lines, generator = predictor.amplitudes(machine), np.random.default_rng(7)
    size = share * np.abs(lines).max() or NOISE_M
    noise = size * (generator.normal(size=lines.shape) + 1j * generator.normal(size=lines.shape))
    return OrderLines(predictor.conditions, predictor.probes, ORDERS, lines + noise, np.full(lines.shape, size))


@pytest.mark.parametrize("angle_rad", [0.4, -2.0])
def test_what_an_unbalance_makes_adds_up_from_its_components(angle_rad: float) -> None:
    predictor = _predictor(amb_rotor)
    own = own_unbalance(amb_rotor, predictor)
    assert own is not None
    assert own.angle.name == "unbalance_angle_rad"
    change = predictor.amplitudes(own.turned_in(amb_rotor, angle_rad)) - predictor.amplitudes(amb_rotor)
    wanted = (math.cos(angle_rad) - 1) * own.lines + math.sin(angle_rad) * own.across
    # Beyond first order there are the bearings' own curves.
    assert np.linalg.norm(change - wanted) < 0.02 * np.linalg.norm(change)


def test_machines_without_an_unbalance_of_their_own_have_none() -> None:
    assert own_unbalance(rigid_coupling, _predictor(rigid_coupling)) is None
    assert own_unbalance(gearbox, _predictor(gearbox)) is None
    rig = own_unbalance(test_rig, _predictor(test_rig))
    assert rig is not None
    assert rig.angle.name == "residual_angle_rad"


@pytest.mark.parametrize(("own_rad", "pulse_rad"), [pytest.param(1.2, -1.5, marks=pytest.mark.slow), (0.0, 2.0)])
def test_the_pulse_and_the_unbalance_s_direction_are_told_apart(own_rad: float, pulse_rad: float) -> None:
    # The coupling's stiffness turns with the shaft and makes 2X of its own: 1X alone would not tell.
    factors = {name: factor * amb_rotor.values[name] for name, factor in OFF.items()}
    real, predictor = amb_rotor.with_parameters(unbalance_angle_rad=own_rad, **factors), _predictor(amb_rotor)
    healthy = _healthy(predictor, real)
    found = healthy_machine(amb_rotor, turned(healthy, -pulse_rad), predictor, reference_rpm=SPEEDS_RPM[-1])
    assert found.pulse_rad == pytest.approx(pulse_rad, abs=0.03)
    assert found.at_healthy.machine.values["unbalance_angle_rad"] == pytest.approx(own_rad, abs=0.03)
    # Only what has been turned is uncertain from then on, and nothing has been added to make up for it.
    uncertain = [one.parameter.name for one in found.at_healthy.coordinates]
    assert ("unbalance_angle_rad" in uncertain) == (own_rad != 0.0)
    assert found.form is not None
    assert not found.form.added


@pytest.mark.slow
def test_without_a_tacho_it_is_told_by_an_unbalance_that_is_added() -> None:
    real, predictor = amb_rotor.with_parameters(unbalance_angle_rad=1.2), _predictor(amb_rotor, tied=False)
    found = healthy_machine(amb_rotor, _healthy(predictor, real), predictor, reference_rpm=SPEEDS_RPM[-1])
    assert found.pulse_rad == 0.0
    (added,) = found.at_healthy.machine.effects
    own, size = added.values(), amb_rotor.values["unbalance_kg_m"]
    assert own["moment_x_kg_m"] + size == pytest.approx(size * math.cos(1.2), abs=0.02 * size)
    assert own["moment_y_kg_m"] == pytest.approx(size * math.sin(1.2), abs=0.02 * size)


def test_where_1x_of_an_unbalance_is_all_there_is_the_pulse_stays_at_the_zero() -> None:
    real, predictor = test_rig.with_parameters(residual_angle_rad=2.0), _predictor(test_rig)
    found = healthy_machine(test_rig, _healthy(predictor, real, 1e-3), predictor, reference_rpm=SPEEDS_RPM[-1])
    away = found.at_healthy.machine.values["residual_angle_rad"] + found.pulse_rad - 2.0
    assert abs(math.remainder(away, 2 * math.pi)) < 0.05
    assert found.pulse_rad == 0.0

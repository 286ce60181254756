"""What the supports lack is found in healthy lines where it is hidden, and not where nothing is, or something else."""

import json

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap import model_form as module
from rotorwise.diagnose.gap.calibration import calibrated
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.extended_file import OF_HEALTHY, extended_text
from rotorwise.diagnose.gap.healthy_evidence import evidence
from rotorwise.diagnose.gap.json_form import as_json
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.model_form import SIGMAS_OF_90, Extended, extended, form_of
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.pulse_place import Placed
from rotorwise.diagnose.gap.trials.ranges import find_range
from rotorwise.diagnose.gap.trials.wrong_form import with_wrong_form
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.effects.empirical_stiffness import EmpiricalStiffness
from rotorwise.simulators.effects.residual_unbalance import ResidualUnbalance
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import Machine, machine_from_toml

from .made_campaigns import altered, recorded

SPEEDS_RPM = (1200.0, 1700.0, 2300.0, 2900.0, 3500.0, 4100.0)
ORDERS, NOISE_M, TOP_RPM = (1.0, 2.0, 3.0), 2e-8, 4100.0
NONE = {"stiffness_n_m": 0.0, "difference_n_m": 0.0, "cross_n_m": 0.0, "damping_n_s_m": 0.0}
HIDDEN = {
    ("bearing_1", "cross_n_m", 0.0): 4e4,
    ("bearing_2", "stiffness_n_m", 2.0): -4e4,
    ("bearing_2", "difference_n_m", 0.0): 3e4,
}


def _lines(machine: Machine, *, seed: int) -> tuple[OrderLines, Predictor]:
    probes = tuple(one.name for one in machine.bare_assembly().probes)
    conditions, count = tuple(Condition(speed) for speed in SPEEDS_RPM), len(SPEEDS_RPM)
    kinds = (LineKind(),) * len(ORDERS)
    predictor = Predictor(conditions, probes, ORDERS, (1e4,) * count, (20_000,) * count, kinds, (0,) * len(ORDERS))
    lines = predictor.amplitudes(machine)
    generator = np.random.default_rng(seed)
    noise = NOISE_M * (generator.normal(size=lines.shape) + 1j * generator.normal(size=lines.shape))
    deviations = np.hypot(NOISE_M, 0.005 / np.sqrt(2) * np.abs(lines))
    return OrderLines(conditions, probes, ORDERS, lines + noise, deviations), predictor


def _extended(healthy: OrderLines, predictor: Predictor) -> Extended:
    found = calibrated(amb_rotor, healthy, predictor)
    placed = Placed(amb_rotor, (), found, 0.0, evidence(found, healthy))
    return extended(placed, healthy, predictor, reference_rpm=TOP_RPM)


def _hidden(power_law: dict[tuple[str, str, float], float]) -> list[EmpiricalStiffness]:
    return [
        EmpiricalStiffness(at=at, speed_exponent=power, reference_speed_rpm=TOP_RPM, **{**NONE, strength: value})
        for (at, strength, power), value in power_law.items()
    ]


def test_hidden_springs_are_found_with_their_size() -> None:
    real = altered(amb_rotor, share=0.03, seed=3).with_effects(*_hidden(HIDDEN))
    found = _extended(*_lines(real, seed=1))
    form = form_of(found)
    assert {(one.at, one.strength, one.speed_exponent) for one in form.terms} == set(HIDDEN)
    for one in form.terms:
        half = (one.value.high - one.value.low) / 2
        assert abs(one.value.value - HIDDEN[one.at, one.strength, one.speed_exponent]) < 3.5 / SIGMAS_OF_90 * half
        assert half < 0.2 * abs(one.value.value)
    assert form.missed < 0.02 < 0.1 < form.missed_before


@pytest.mark.slow
def test_residual_unbalance_in_another_plane_is_found() -> None:
    real = altered(amb_rotor, share=0.03, seed=4)
    real = real.with_effects(ResidualUnbalance(at="coupling_hub", moment_x_kg_m=-2e-5, moment_y_kg_m=3e-5))
    found = _extended(*_lines(real, seed=5))
    form = form_of(found)
    assert form.missed < 0.02 < 0.1 < form.missed_before
    own = {one.strength: one.value for one in form.terms if one.at == "coupling_hub"}
    for name, value in (("moment_x_kg_m", -2e-5), ("moment_y_kg_m", 3e-5)):
        assert abs(own[name].value - value) < 3.5 / SIGMAS_OF_90 * (own[name].high - own[name].low) / 2
        assert abs(own[name].value - value) < 3e-6


@pytest.mark.parametrize("seed", range(6))
def test_a_model_that_is_right_gets_nothing(seed: int) -> None:
    found = _extended(*_lines(altered(amb_rotor, share=0.05, seed=seed), seed=seed + 50))
    assert not found.added
    assert found.machine.effects == ()


@pytest.mark.slow
def test_what_no_spring_makes_is_no_reason_to_add_springs() -> None:
    healthy, predictor = _lines(amb_rotor, seed=2)
    generator = np.random.default_rng(8)
    # Smooth in speed, another at each probe and order, a fifth of each line.
    speeds = np.log(np.array(SPEEDS_RPM) / SPEEDS_RPM[0])
    waves = generator.normal(size=(2, 4, len(ORDERS), 2)) @ np.array([1, 1j])
    wrong = 1 + 0.15 * (waves[0] * np.cos(3 * speeds)[:, None, None] + waves[1] * np.sin(3 * speeds)[:, None, None])
    spoilt = OrderLines(healthy.conditions, healthy.probes, ORDERS, healthy.amplitudes * wrong, healthy.deviations)
    assert len(_extended(spoilt, predictor).added) <= 1


@pytest.mark.slow
def test_where_lines_stay_unexplained_terms_are_looked_for_beside_the_machine_as_given_too(monkeypatch) -> None:
    """Parameters that have made up for what is lacking hide it: what is found from both is compared."""
    healthy, predictor = _lines(amb_rotor.with_effects(*_hidden({("bearing_1", "stiffness_n_m", 0.0): -6e4})), seed=1)
    found = calibrated(amb_rotor, healthy, predictor)
    begun, search = [], module._grown

    def grown(state, *args, **options):
        begun.append(state.current)
        # From the calibrated machine nothing is found here.
        return state if state.current is found else search(state, *args, **options)

    monkeypatch.setattr(module, "_grown", grown)
    placed = Placed(amb_rotor, (), found, 0.0, evidence(found, healthy))
    form = extended(placed, healthy, predictor, reference_rpm=TOP_RPM)
    assert begun[0] is found
    np.testing.assert_array_equal(begun[1].position, found.given)
    assert [(one.at, one.strength) for one in form_of(form).terms] == [("bearing_1", "stiffness_n_m")]
    # Not where the lines are explained, nor where another place of the pulse is far ahead.
    begun.clear()
    extended(placed, healthy, predictor, reference_rpm=TOP_RPM, known=placed.evidence + 1e4)
    monkeypatch.setattr(module, "is_explained", lambda *_: True)
    extended(placed, healthy, predictor, reference_rpm=TOP_RPM)
    assert len(begun) == 2


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    how = {"rate_hz": 2048.0, "duration_s": 3.0}
    real = altered(amb_rotor, share=0.03, seed=3)
    real = with_wrong_form(real, 0.15, find_range("amb_rotor"), np.random.default_rng(4))
    faulty = recorded(real.with_effects(Unbalance(at="coupling_hub", moment_kg_m=1e-4)), SPEEDS_RPM, seed=41, **how)
    return Campaign(faulty, recorded(real, SPEEDS_RPM, seed=1, **how))


COMPETING = frozenset(("unbalance", "shaft_bow", "remounted_sensor"))


@pytest.mark.slow
def test_a_cause_is_found_beside_supports_that_follow_another_law(campaign: Campaign) -> None:
    answer = explain_gap(campaign, amb_rotor, only=COMPETING)
    assert answer.form is not None
    assert answer.form.missed < 0.2 * answer.form.missed_before
    (cause,) = answer.causes
    assert (cause.effect, cause.at) == ("unbalance", "coupling_hub")
    moment = cause.parameters["moment_kg_m"]
    assert moment.low < 1e-4 < moment.high
    # The machine that is written has them, simulates, and the answer says so.
    assert "what the model lacks" in answer.remarks[0]
    terms = json.loads(json.dumps(as_json(answer)))["model_form"]["terms"]
    assert [one["at"] for one in terms] == [one.at for one in answer.form.terms]
    written = machine_from_toml(extended_text(answer))
    *added, last = (type(one).NAME for one in written.effects)
    assert set(added) <= set(OF_HEALTHY)
    assert last == "unbalance"
    assert np.isfinite(written.simulate(speed_rpm=2000.0, duration_s=0.5, rate_hz=2000.0).signals).all()

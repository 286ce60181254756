"""Cases of blind trials: lines and d2 in closed form, records against harmonic balance, draws within what is said."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.gap.trials.cases import (
    FAMILIES,
    LAW_ERROR,
    Scene,
    TrialCase,
    kind_of,
    make_case,
    with_wrong_law,
)
from rotorwise.diagnose.gap.trials.draws import applicable, drawn, drifted, likely, perturbed, weakened
from rotorwise.diagnose.gap.trials.lines import Lines, detectability, lines_of, orders_of, with_stated
from rotorwise.diagnose.gap.trials.ranges import RANGES, find_range
from rotorwise.diagnose.gap.trials.recorder import Setting, TrialChain, motions, noise_of, recording
from rotorwise.diagnose.gap.trials.wrong_form import supports_of, with_wrong_form
from rotorwise.simulators.effect import SensorEffect, effect_catalogue
from rotorwise.simulators.effects.empirical_stiffness import EmpiricalStiffness
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.parameter import Normal
from rotorwise.simulators.sensor_record import SensorRecord
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from rotorwise.simulators.solvers.simulate import Simulation

ORDERS = np.arange(1, 13) / 2
SEEDS = st.integers(0, 2**31)


@pytest.fixture(scope="module")
def case() -> TrialCase:
    return make_case("amb_rotor", number=0, seed=1, snr_db=30.0, family="tune")


def run_of(signals: np.ndarray, phase: np.ndarray, rate_hz: float = 1000.0) -> Simulation:
    probes = tuple(find_machine("amb_rotor").bare_assembly().probes[: len(signals)])
    return Simulation(signals, rate_hz, probes, phase, np.gradient(phase) * rate_hz, 1e-4)


# ---- theory ----


def test_lines_of_a_known_sum_of_lines() -> None:
    generator = np.random.default_rng(0)
    wanted = generator.normal(size=(3, 12)) + 1j * generator.normal(size=(3, 12))
    phase = np.linspace(0.3, 2 * math.pi * 50.37, 6000)
    signals = 7.0 + (wanted @ np.exp(1j * ORDERS[:, None] * phase)).real
    found = lines_of(signals, phase, ORDERS, rate_hz=1000.0)
    assert np.abs(found.amplitudes - wanted).max() < 1e-9
    assert found.samples == 6000


def test_lines_beyond_the_flat_band_do_not_count() -> None:
    phase = 2 * math.pi * 100.0 * np.arange(4000) / 1000.0  # 100 Hz at 1000 Hz: flat up to the fourth order
    found = lines_of(np.cos(3 * phase)[None], phase, ORDERS, rate_hz=1000.0)
    assert abs(found.amplitudes[0, 5] - 1) < 1e-9
    assert not found.amplitudes[0, ORDERS >= 4].any()


def test_noise_of_a_line_is_what_d2_assumes() -> None:
    generator, rms = np.random.default_rng(1), 0.2
    phase = 2 * math.pi * np.arange(3000) / 40
    found = lines_of(rms * generator.normal(size=(400, 3000)), phase, ORDERS, rate_hz=1000.0).amplitudes
    parts = np.concatenate([found.real.ravel(), found.imag.ravel()])
    # 9600 numbers, hence 0.7 % of spread in their deviation.
    assert parts.std() == pytest.approx(math.sqrt(3 * rms**2 / 3000), rel=0.03)


def test_lines_beside_the_orders_count_where_an_effect_states_them() -> None:
    machine = find_machine("test_rig")
    effects = [effect_catalogue()[name]() for name in ("twice_line_force", "unbalance")]
    found = with_stated(ORDERS, effects, machine.with_effects(*effects), speed_rpm=1800.0, turns=60.0)
    # 100 Hz at 30 Hz, and sidebands of the slip if any; order 1 is there already.
    assert found[: ORDERS.size].tolist() == ORDERS.tolist()
    assert np.abs(found - 100 / 30).min() < 1e-9
    assert (np.diff(np.sort(found)) >= 2 / 60 - 1e-9).all()
    # Where a record is so short that 100 Hz at 1798 rpm and the third order and a third fall together, one counts.
    hum = with_stated(np.array([3.33]), effects[:1], machine.with_effects(effects[0]), speed_rpm=1800.0, turns=60.0)
    assert hum.tolist() == [3.33]


def test_an_imperfection_beside_the_orders_is_below_detectability_too() -> None:
    # Trial 51 of this seed had a fluctuation of the load at 2.05 Hz, a hundred times the noise, with a d2 of 0.001.
    machine, how = find_machine("amb_rotor"), find_range("amb_rotor")
    effect = effect_catalogue()["load_fluctuation"](radial_n=1.25, torque_n_m=0.9, frequency_hz=2.05)
    settings_ = (Setting(1595.0, None, 0.1), Setting(2208.0, None, 0.3))
    scene = Scene(how, settings_, orders_of(machine), 70.0, 30.0, 3)
    loud = machine.with_effects(effect)
    quiet_runs, runs = scene.run(machine, loud)
    assert scene.d2(runs, loud, quiet_runs, machine) < 1.0
    assert scene.d2(runs, loud, quiet_runs, machine, [effect]) > 1000.0


def test_with_angles_anywhere_the_own_unbalance_is_another() -> None:
    # A trial in which nothing is hidden.
    plain, turned = (make_case("amb_rotor", number=7, seed=5, snr_db=30, anywhere=any_) for any_ in (False, True))
    assert plain.campaign.baseline[0].condition == turned.campaign.baseline[0].condition
    assert not np.allclose(plain.campaign.baseline[0].signals[:-1], turned.campaign.baseline[0].signals[:-1], rtol=0.1)


def test_detectability_in_closed_form() -> None:
    now, before = np.zeros((2, 12), complex), np.zeros((2, 12), complex)
    now[0, 1], before[0, 1], now[1, 3] = 5.0, 3.0, 4j
    found = detectability([Lines(now, 300)], [Lines(before, 300)], [np.array([2.0, 1.0])], [0, 1])
    expected = 4 / (3 * 4 / 300 + 0.05**2) + 16 / (3 / 300 + 0.04**2)
    assert found == pytest.approx(expected, rel=1e-12)
    assert detectability([Lines(now, 300)], [Lines(before, 300)], [np.ones(2)], [1]) == pytest.approx(
        16 / (3 / 300 + 0.04**2)
    )


def test_gain_error_bounds_what_a_long_record_can_show() -> None:
    now, before = np.full((1, 12), 1.01 + 0j), np.ones((1, 12), complex)
    found = detectability([Lines(now, 10**12)], [Lines(before, 10**12)], [np.ones(1)], [0])
    assert found == pytest.approx(12 * 0.01**2 / 0.0101**2, rel=1e-6)


def test_wrong_law_multiplies_every_order_alike_at_all_probes_and_conditions() -> None:
    generator = np.random.default_rng(2)
    runs, without, before = [], [], []
    for speed in (15.0, 21.0):
        phase = 2 * math.pi * speed * np.arange(4000) / 1000.0
        base, change = (generator.normal(size=(2, 12)) + 1j * generator.normal(size=(2, 12)) for _ in range(2))
        turning = np.exp(1j * ORDERS[:, None] * phase)
        runs.append(run_of(((base + change) @ turning).real, phase))
        without.append(run_of((base @ turning).real, phase))
        before.append((base, change))
    effect = Unbalance()
    found = with_wrong_law(ORDERS, runs, [without], [effect], np.random.default_rng(3))
    factors = []
    for run, (base, change) in zip(found, before, strict=True):
        lines = lines_of(run.signals, run.phase_rad, ORDERS, rate_hz=1000.0).amplitudes
        factors.append((lines - base) / change)
    factors = np.array(factors)
    assert np.abs(factors - factors[0, 0]).max() < 1e-9
    assert 0.3 * LAW_ERROR < np.sqrt(np.mean(np.abs(factors[0, 0] - 1) ** 2)) < 2 * LAW_ERROR


def test_effects_on_the_measuring_chain_keep_their_law() -> None:
    phase = 2 * math.pi * np.arange(2000) / 40
    runs, without = [run_of(np.cos(phase)[None], phase)], [run_of(0 * phase[None], phase)]
    sensor = effect_catalogue()["remounted_sensor"]()
    found = with_wrong_law(ORDERS, runs, [without], [sensor], np.random.default_rng(0))
    assert np.array_equal(found[0].signals, runs[0].signals)


def test_chain_noise_and_gain_are_those_stated() -> None:
    machine, phase = find_machine("amb_rotor"), 2 * math.pi * 30 * np.arange(42000) / 1800.0
    signals = 1e-5 * np.stack([np.cos(phase + k) for k in range(4)])
    run = run_of(signals, phase, 1800.0)
    assert noise_of(run, 20.0) == pytest.approx(np.full(4, 1e-6 / math.sqrt(2)), rel=1e-4)
    chain = TrialChain(gains=(1.0, 1.02, 0.97, 1.0), noise_rms=(0.0, 1e-6, 2e-6, 0.0))
    record = SensorRecord(
        signals, 1800.0, 1800.0, phase, np.ones(42000), run.probes, (1.0,) * 4, np.ones(4), np.zeros(4), np.zeros(4)
    )
    left = chain.healthy("transducer", record, np.random.default_rng(0)).signals - signals * np.array(
        [[1.0], [1.02], [0.97], [1.0]]
    )
    assert left.std(axis=1) == pytest.approx([0.0, 1e-6, 2e-6, 0.0], rel=0.02)
    assert machine.bare_assembly().probes[0].unit == "m"


def test_a_channel_that_stands_still_has_the_noise_of_its_sensor() -> None:
    run = run_of(np.zeros((1, 100)), np.linspace(0, 60, 100))
    assert noise_of(run, 30.0) == pytest.approx([1e-9])


# A turn is 36 samples, and the tacho's level is known to a sixteenth of one: the edge falls on such a part.
@pytest.mark.parametrize("pulse_rad", [0.0, -2 * math.pi / 3])
def test_record_agrees_with_harmonic_balance(pulse_rad: float) -> None:
    """Time stepping, chain and tacho against the frequency domain, which knows nothing of them.

    Angles count from the pulse, which comes when the machine has turned by so much.
    """
    machine, how = (
        find_machine("amb_rotor").with_effects(Unbalance(moment_kg_m=2e-4, angle_rad=0.7)),
        RANGES["amb_rotor"],
    )
    setting = Setting(3000.0, None, 0.4)
    run = motions([machine], [setting], how)[0][0]
    gains = np.array([1.0, 1.02, 1.0, 0.99])
    chain = {"gains": gains, "snr_db": 60.0, "turns": 60.0, "pulse_rad": pulse_rad}
    found = recording(run, machine, setting, how, **chain, seed=1, stream=0)
    tacho = found.signals[-1]
    rises = np.flatnonzero((tacho[1:] >= 0.5) & (tacho[:-1] < 0.5))
    # Each sample is the mean over its length: what two of them hold of the high level says where in them it begins.
    edges = rises + 1.5 - tacho[rises] - tacho[rises + 1]
    turns = np.polyval(np.polyfit(edges, np.arange(edges.size), 1), np.arange(tacho.size))
    lines = lines_of(found.signals[:-1], 2 * math.pi * turns, ORDERS, rate_hz=found.rate_hz).amplitudes
    motion = harmonic_balance(machine, speed_rpm=3000.0, harmonics=6)
    for order in (1, 2, 3):
        expected = gains * motion.amplitudes[:4, order] * np.exp(1j * order * pulse_rad)
        assert np.abs(lines[:, 2 * order - 1] - expected).max() < 0.005 * np.abs(motion.amplitudes[:4, 1]).max()


# ---- properties ----


@pytest.mark.parametrize("name", RANGES)
@given(seed=SEEDS)
@settings(max_examples=10, deadline=None)
def test_speeds_and_loads_lie_in_their_ranges(name: str, seed: int) -> None:
    how, generator = find_range(name), np.random.default_rng(seed)
    count = int(generator.integers(how.conditions[0], how.conditions[1] + 1))
    speeds = how.draw_speeds(count, generator)
    assert speeds == sorted(speeds)
    assert len(speeds) == count
    assert all(any(low <= speed <= high for low, high in how.speeds_rpm) for speed in speeds)
    for load in how.draw_loads(count, generator):
        allowed = how.load_levels or how.loads
        assert load is None if allowed is None else min(allowed) <= load <= max(allowed)


CATALOGUES = {name: applicable(find_machine(name), probes=RANGES[name].recorded(find_machine(name))) for name in RANGES}


@pytest.mark.parametrize("name", RANGES)
@given(seed=SEEDS)
@settings(max_examples=40, deadline=None)
def test_strengths_lie_within_three_quarters_of_a_decade_of_the_prior(name: str, seed: int) -> None:
    effect = drawn(CATALOGUES[name], np.random.default_rng(seed))
    for declared in effect.parameters():
        value = effect.values()[declared.name]
        assert declared.bounds[0] <= value <= declared.bounds[1]
        if declared.prior is None:
            assert value == declared.default
        elif declared.zero is not None:
            low, high = likely(declared)
            assert min(low, declared.zero) - 1e-12 <= value <= high + 1e-12
            size, usual = abs(value - declared.zero), abs(declared.prior.median - declared.zero)
            assert size <= usual * 10**0.75 * (1 + 1e-9)


@pytest.mark.parametrize("name", RANGES)
def test_every_effect_that_fits_is_drawn_and_none_twice(name: str) -> None:
    catalogue, generator = CATALOGUES[name], np.random.default_rng(0)
    assert len(catalogue) > 15
    found = {drawn(catalogue, generator).NAME for _ in range(40 * len(catalogue))}
    assert found == set(catalogue)
    besides = frozenset(list(catalogue)[1:])
    assert next(iter(catalogue)) == drawn(catalogue, generator, besides=besides).NAME


@pytest.mark.parametrize("name", RANGES)
def test_what_acts_on_every_machine_does_not_begin_to_act(name: str) -> None:
    assert "gravity" not in CATALOGUES[name]


@pytest.mark.parametrize("name", RANGES)
def test_a_recorder_has_one_clock_and_only_recorded_probes_have_flaws(name: str) -> None:
    locations = {probe.location for probe in RANGES[name].recorded(find_machine(name))}
    for effects in CATALOGUES[name].values():
        if isinstance(effects[0], SensorEffect):
            whole = effects[0].LINK in ("clock", "recorder")
            assert {effect.at for effect in effects} <= ({""} if whole else locations)


def test_weakened_keeps_everything_but_the_strength() -> None:
    effect = Unbalance(moment_kg_m=2e-4, angle_rad=1.0, axial_offset_m=0.01)
    weak = weakened(effect, 0.1)
    assert weak.values() == {"moment_kg_m": pytest.approx(2e-5), "angle_rad": 1.0, "axial_offset_m": 0.01}
    assert weakened(effect, 0.0) == effect.at_zero()


@pytest.mark.parametrize("name", RANGES)
@given(seed=SEEDS)
@settings(max_examples=10, deadline=None)
def test_machines_are_off_by_as_much_as_said(name: str, seed: int) -> None:
    machine, generator = find_machine(name), np.random.default_rng(seed)
    real = perturbed(machine, generator)
    later = drifted(real, generator)
    for p in machine.definition.parameters:
        before, now, then = (one.values[p.name] for one in (machine, real, later))
        limit = (0.1 if p.prior is not None else 0.01) * (1.0 if p.unit == "rad" else abs(before))
        if p.name == machine.definition.load_parameter or (p.prior is None and not p.unit.startswith(("m", "kg"))):
            limit = 0.0
        if before == 0.0 and isinstance(p.prior, Normal) and p.unit != "rad":
            # Supports and bolts that are alike in the model only.
            limit = p.prior.deviation
            assert now != 0.0
        assert abs(now - before) <= limit * (1 + 1e-9)
        assert abs(then - now) <= 0.005 * (1.0 if p.unit == "rad" else abs(now)) * (1 + 1e-9)
    assert real.changed


def test_gear_lines_and_usual_lines() -> None:
    assert orders_of(find_machine("amb_rotor")) == pytest.approx(ORDERS)
    found = orders_of(find_machine("gearbox"))
    for order in (0.5, 6.0, 23.0, 22.0, 24.0, 23 - 23 / 81, 46.0, 69.0, 23 / 81):
        assert np.abs(found - order).min() < 1e-12


@pytest.mark.parametrize("family", FAMILIES)
def test_of_twenty_trials_every_kind_has_its_share(family: str) -> None:
    for first in (0, 20, 40):
        kinds = Counter(
            kind_of("test_rig", number=number, seed=3, family=family) for number in range(first, first + 20)
        )
        assert kinds == {
            ("none", False): 2,
            ("none", True): 2,
            ("one", False): 10,
            ("two", False): 3,
            ("unknown", False): 3,
        }


# ---- whole cases ----


def test_the_same_arguments_give_the_same_case_and_other_families_another(case: TrialCase) -> None:
    again = make_case("amb_rotor", number=0, seed=1, snr_db=30.0, family="tune")
    assert [one.effect for one in again.hidden] == [one.effect for one in case.hidden]
    assert again.d2 == case.d2
    for one, other in zip(again.campaign.recordings, case.campaign.recordings, strict=True):
        assert np.array_equal(one.signals, other.signals)
    other = make_case("amb_rotor", number=0, seed=1, snr_db=30.0, family="score")
    speeds = [[one.condition.speed_rpm for one in c.campaign.recordings] for c in (case, other)]
    assert speeds[0] != speeds[1]


def test_a_case_is_what_the_engine_expects(case: TrialCase) -> None:
    assert case.machine == find_machine("amb_rotor")
    for one in (*case.campaign.recordings, *case.campaign.baseline):
        assert one.channels[-1].quantity == "tacho"
        assert [c.name for c in one.channels[:-1]] == [p.name for p in case.machine.bare_assembly().probes]
        turns = one.duration_s * (one.condition.speed_rpm or 0.0) / 60
        assert 59 < turns < 101
        pulses = np.count_nonzero(np.diff((one.signals[-1] > 0.5).astype(int)) == 1)
        assert abs(pulses - turns) < 1.5
        assert np.isfinite(one.signals).all()
    assert case.kind == "one"
    assert not case.left_out
    assert case.d2 > 0
    assert case.imperfection is None or case.imperfection.d2 <= 4.0


def test_a_hidden_unknown_is_left_out_and_nothing_hides_nothing() -> None:
    numbers = {
        kind: next(n for n in range(20) if kind_of("amb_rotor", number=n, seed=1, family="tune")[0] == kind)
        for kind in ("unknown", "none")
    }
    unknown = make_case("amb_rotor", number=numbers["unknown"], seed=1, snr_db=30.0, family="tune")
    assert unknown.left_out == {unknown.hidden[0].effect.NAME}
    nothing = make_case("amb_rotor", number=numbers["none"], seed=1, snr_db=30.0, family="tune")
    assert nothing.hidden == ()
    assert nothing.d2 == 0.0


@pytest.mark.parametrize(
    ("change", "named"),
    [({"machine": "toaster"}, "toaster"), ({"seed": -1}, "-1"), ({"snr_db": math.nan}, "nan"), ({"family": "x"}, "x")],
)
def test_bad_values_are_refused_with_what_is_allowed(change: dict, named: str) -> None:
    options = {"machine": "amb_rotor", "seed": 1, "snr_db": 30.0, "family": "tune", **change}
    with pytest.raises(InvalidValueError, match=named) as caught:
        make_case(options.pop("machine"), number=0, **options)
    assert "allowed" in str(caught.value)


# ---- supports that are not the model's ----


def test_a_wrong_form_is_the_stated_share_and_changes_nothing_else_of_a_trial() -> None:
    right, wrong = (
        make_case("amb_rotor", number=4, seed=1, snr_db=30.0, family="tune", wrong_form=share) for share in (0.0, 0.15)
    )
    assert wrong.machine.to_toml() == right.machine.to_toml()
    assert (wrong.kind, wrong.number) == (right.kind, right.number)
    speeds = [[one.condition.speed_rpm for one in case.campaign.recordings] for case in (right, wrong)]
    assert speeds[0] == speeds[1]
    how, machine = find_range("amb_rotor"), find_machine("amb_rotor")
    top = how.speeds_rpm[-1][1]
    made = with_wrong_form(machine, 0.15, how, np.random.default_rng(2))
    stiffness = supports_of(machine)["bearing_1"].stiffness_n_m
    # At the highest speed the supports' own law is that of springs of these shares.
    forces = [one for one in made.assembly(speed_rpm=top).forces if one.name.startswith("wrong support")]
    assert [abs(one.parameters[0]) for one in forces] == pytest.approx([0.15 * stiffness] * 2)
    assert [abs(one.parameters[3]) for one in forces] == pytest.approx([0.15 * stiffness] * 2)
    springs = [
        EmpiricalStiffness(
            at=one.name.removeprefix("wrong support "),
            stiffness_n_m=one.parameters[0],
            difference_n_m=0.0,
            cross_n_m=one.parameters[3],
            damping_n_s_m=0.0,
        )
        for one in forces
    ]
    motions_of = [harmonic_balance(m, speed_rpm=top).amplitudes for m in (made, machine.with_effects(*springs))]
    assert motions_of[0] == pytest.approx(motions_of[1], rel=1e-9, abs=1e-9 * np.abs(motions_of[1]).max())


def test_a_lightly_damped_support_is_crossed_no_more_than_it_holds() -> None:
    support = supports_of(find_machine("rigid_coupling"))["bearing_2"]
    held = support.damping_n_s_m * math.sqrt(support.stiffness_n_m / support.mass_kg)
    assert support.across_n_m(-0.15) == pytest.approx(-0.5 * held)
    assert support.across_n_m(0.001) == pytest.approx(0.001 * support.stiffness_n_m)


def test_a_machine_without_known_supports_is_refused() -> None:
    with pytest.raises(InvalidValueError, match=r"gearbox.*amb_rotor"):
        make_case("gearbox", number=0, seed=1, snr_db=30.0, wrong_form=0.1)
    with pytest.raises(InvalidValueError, match="wrong_form"):
        make_case("amb_rotor", number=0, seed=1, snr_db=30.0, wrong_form=0.9)

"""Each rule on a signal whose truth is known, and what must not be said."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import GearPair, MountedBearing, Nameplate
from rotorwise.diagnose import Analysis, analyse_recording
from rotorwise.diagnose.evidence import LEAST_PROBABILITY, merged, rules
from rotorwise.diagnose.result import FAULTS, Finding
from rotorwise.simulators.rotor_dynamics.rolling_bearing import BearingGeometry, find_bearing
from rotorwise.simulators.synthetic_vibration import ImpactTrain

from .conftest import HEALTHY, RATE_HZ, SPEED_HZ, Make

ORDERS = find_bearing("6205").defect_orders()


def top(analysis: Analysis) -> tuple[str, float]:
    """Return name and probability of the first finding."""
    return (analysis.findings[0].fault, analysis.findings[0].probability) if analysis.findings else ("", 0.0)


def stated(analysis: Analysis, fault: str) -> float:
    """Return the stated probability of a fault."""
    return next((one.probability for one in analysis.findings if one.fault == fault), 0.0)


# --- bearings ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fault", "train"),
    [
        ("bearing_outer_race", ImpactTrain(ORDERS.outer_race, 5.0, 3000.0)),
        (
            "bearing_inner_race",
            ImpactTrain(ORDERS.inner_race, 6.0, 3000.0, modulation_order=1.0, modulation_depth=0.8),
        ),
        (
            "bearing_ball",
            ImpactTrain(2 * ORDERS.ball_spin, 6.0, 3000.0, modulation_order=ORDERS.cage, modulation_depth=0.8),
        ),
    ],
)
@pytest.mark.parametrize("slip", [0.988, 1.0, 1.012])
def test_bearing_defects_are_named(make: Make, fault: str, train: ImpactTrain, slip: float) -> None:
    analysis = analyse_recording(make(impacts=(replace(train, order=train.order * slip),)))
    name, probability = top(analysis)
    assert name == fault
    assert probability > 0.8
    line = next(line for line in analysis.findings[0].lines if line.expected_order)
    assert line.order == pytest.approx(train.order * slip, rel=3e-3)


@pytest.mark.parametrize("seed", range(12))
def test_healthy_noise_names_no_bearing(make: Make, seed: int) -> None:
    assert not analyse_recording(make(seed=seed)).findings


def test_faint_ball_pass_modulation_of_a_healthy_bearing_is_no_defect(make: Make) -> None:
    """Significant but shallow: noise modulated by 15 % at BPFO is what a healthy loaded bearing does."""
    recording = make(noise_rms=0.0)
    time = np.arange(recording.samples) / RATE_HZ
    noise = np.random.default_rng(3).normal(size=recording.signals.shape)
    modulation = 1 + 0.15 * np.cos(2 * np.pi * ORDERS.outer_race * SPEED_HZ * time)
    analysis = analyse_recording(replace(recording, signals=recording.signals + noise * modulation))
    assert stated(analysis, "bearing_outer_race") < 0.5


def test_impacts_once_a_turn_are_no_bearing_defect(make: Make) -> None:
    analysis = analyse_recording(make(impacts=(ImpactTrain(1.0, 20.0, 3000.0, slip=0.0),)))
    assert all(not one.fault.startswith("bearing") or one.probability < 0.5 for one in analysis.findings)


def test_unknown_bearing_rhythm_is_told_not_named(make: Make) -> None:
    analysis = analyse_recording(make(impacts=(ImpactTrain(4.37, 6.0, 3000.0),), nameplate=Nameplate()))
    assert not any(one.fault.startswith("bearing") for one in analysis.findings)
    told = next(text for text in analysis.warnings if "--bearing" in text)
    assert float(re.search(r"at ([\d.]+)X", told).group(1)) == pytest.approx(4.37, rel=5e-3)
    assert "Not explained" in analysis.verdict


def test_unknown_rhythm_of_the_baseline_is_not_told(make: Make) -> None:
    impacts = (ImpactTrain(4.37, 6.0, 3000.0),)
    now, same, quiet = (
        make(impacts=one, seed=s, nameplate=Nameplate()) for one, s in ((impacts, 0), (impacts, 5), ((), 5))
    )
    assert not any("--bearing" in text for text in analyse_recording(now, baseline=same).warnings)
    assert any("--bearing" in text for text in analyse_recording(now, baseline=quiet).warnings)


def test_baseline_that_shows_the_same_rhythm_takes_the_evidence_away(make: Make) -> None:
    impacts = (ImpactTrain(ORDERS.outer_race, 2.0, 3000.0),)
    alone = analyse_recording(make(impacts=impacts))
    against = analyse_recording(make(impacts=impacts), baseline=make(impacts=impacts, seed=5))
    assert stated(alone, "bearing_outer_race") > 0.5
    assert stated(against, "bearing_outer_race") < 0.3


# --- shaft ------------------------------------------------------------------------------------------------------


def test_risen_1x_is_unbalance_against_a_baseline(make: Make) -> None:
    analysis = analyse_recording(make(lines={**HEALTHY, 1: 2.4}), baseline=make(seed=7))
    assert top(analysis)[0] == "unbalance"
    assert top(analysis)[1] > 0.5
    # One record at one speed cannot exclude what else turns with the shaft: it has its share, and the remark its test.
    assert stated(analysis, "misalignment") > LEAST_PROBABILITY
    assert stated(analysis, "bent_shaft") > LEAST_PROBABILITY
    assert {"misalignment", "bent_shaft"} <= set(analysis.findings[0].rivals)
    assert "two other speeds" in analysis.findings[0].check
    line = next(line for line in analysis.findings[0].lines if line.channel == "horizontal")
    assert line.amplitude == pytest.approx(2.4, rel=0.02)
    assert line.baseline_amplitude == pytest.approx(0.3, rel=0.1)


#: A real rig's bearing: BPFO at 2.998X, so that BPFO and its sidebands lie beside 2X, 3X and 4X.
NEAR_3X = Nameplate(bearings=(MountedBearing(BearingGeometry(8, 7.145e-3, 28.519e-3)),))


def test_a_bearing_beside_2x_and_3x_leaves_them_to_the_shaft(make: Make) -> None:
    """A shaft's line stands at n X exactly; knowing the bearing must not take the evidence away."""
    assert NEAR_3X.bearings[0].geometry.defect_orders().outer_race == pytest.approx(2.998, abs=1e-3)
    misaligned = {**HEALTHY, 2: 2.0, 3: 1.0}
    unknown, known = (
        analyse_recording(make(lines=misaligned, nameplate=plate), baseline=make(seed=7, nameplate=plate))
        for plate in (Nameplate(), NEAR_3X)
    )
    assert top(known)[0] == "misalignment"
    assert top(known)[1] == pytest.approx(top(unknown)[1], abs=0.02)


def test_a_slipping_line_beside_3x_stays_the_bearings(make: Make) -> None:
    """0.8 % of slip puts BPFO at 2.973X: three bins of a record of 5 s away from 3X."""
    worn = make(lines={**HEALTHY, 2.973: 1.0}, nameplate=NEAR_3X)
    analysis = analyse_recording(worn, baseline=make(seed=7, nameplate=NEAR_3X))
    assert stated(analysis, "misalignment") < LEAST_PROBABILITY


def test_a_record_too_short_to_part_shaft_and_bearing_says_so(make: Make) -> None:
    short = {"seconds": 0.6, "noise_rms": 0.1, "nameplate": NEAR_3X}
    analysis = analyse_recording(make(lines={**HEALTHY, 2: 2.0}, **short), baseline=make(seed=7, **short))
    assert any("2X rose by" in text and "turns cannot tell" in text for text in analysis.warnings)


def test_change_within_repeatability_is_nothing(make: Make) -> None:
    assert not analyse_recording(make(lines={**HEALTHY, 1: 0.4}), baseline=make(seed=7)).findings


def test_risen_2x_alone_is_not_unbalance(make: Make) -> None:
    analysis = analyse_recording(make(lines={**HEALTHY, 2: 2.0}), baseline=make(seed=7))
    assert stated(analysis, "unbalance") < LEAST_PROBABILITY
    assert top(analysis)[0] == "misalignment"


def test_high_2x_without_level_or_baseline_names_nothing_surely(make: Make) -> None:
    """2X above 1X is not misalignment: on measured rigs that rule fails."""
    analysis = analyse_recording(make(lines={1: 0.2, 2: 0.6, 3: 0.1}, quantity=None))
    assert all(one.probability <= 0.5 for one in analysis.findings)


def test_baseline_at_another_speed_is_not_compared(make: Make) -> None:
    baseline = make(speed_hz=20.0, hint_rpm=1200.0)
    analysis = analyse_recording(make(lines={**HEALTHY, 1: 2.4}), baseline=baseline)
    assert any("another speed" in text for text in analysis.warnings)


def test_half_orders_are_looseness(make: Make) -> None:
    lines = {**HEALTHY, 0.5: 0.3, 1.5: 0.4, 2.5: 0.3, 3.5: 0.2}
    assert top(analyse_recording(make(lines=lines)))[0] == "looseness"


def test_thirds_are_a_rub(make: Make) -> None:
    lines = {**HEALTHY, 1 / 3: 0.3, 2 / 3: 0.3, 4 / 3: 0.3, 5 / 3: 0.2}
    assert top(analyse_recording(make(lines=lines)))[0] == "rub"


@pytest.mark.parametrize(("bearings", "expected"), [(False, True), (True, False)])
def test_oil_whirl_needs_a_machine_without_rolling_bearings(make: Make, bearings: bool, expected: bool) -> None:
    machine = {} if bearings else {"nameplate": Nameplate()}
    recording = make(lines={1: 20e-6, 0.44: 30e-6}, noise_rms=1e-6, quantity="displacement", **machine)
    analysis = analyse_recording(recording)
    assert (stated(analysis, "oil_whirl") > 0.5) is expected


def test_twice_line_frequency_is_electrical_when_it_carries_the_velocity(make: Make) -> None:
    recording = make(lines={**HEALTHY, 100.0 / SPEED_HZ: 8.0})
    assert stated(analyse_recording(recording), "electrical") > 0.4
    unknown = replace(recording, nameplate=Nameplate())
    assert stated(analyse_recording(unknown), "electrical") == 0.0


# --- gears ------------------------------------------------------------------------------------------------------

GEARS = Nameplate(gears=(GearPair(23, 46),))


def mesh(sidebands: dict[float, float], amplitude: float = 1.0) -> dict[float, float]:
    """Return mesh lines with sidebands at these orders from the mesh."""
    lines = {**HEALTHY, 23.0: amplitude, 46.0: 0.4 * amplitude}
    return lines | {23.0 + side: value for side, value in sidebands.items()}


def test_sidebands_are_attributed_to_their_gear(make: Make) -> None:
    recording = make(lines=mesh({-0.5: 0.2, 0.5: 0.2}), nameplate=GEARS)
    analysis = analyse_recording(recording)
    assert any("46-tooth" in text and f"{SPEED_HZ / 2:.2f} Hz" in text for text in analysis.remarks)
    assert not any("23-tooth" in text for text in analysis.remarks)
    assert all(one.probability < 0.5 for one in analysis.findings)


def test_many_grown_sidebands_are_a_tooth_fault(make: Make) -> None:
    healthy = mesh({side: 0.02 for side in (-3, -2, -1, 1, 2, 3)})
    broken = mesh({side: 0.25 for side in range(-6, 7) if side})
    analysis = analyse_recording(
        make(lines=broken, nameplate=GEARS), baseline=make(lines=healthy, nameplate=GEARS, seed=9)
    )
    assert top(analysis)[0] == "gear_tooth_fault"
    assert top(analysis)[1] > 0.5


def test_grown_mesh_without_sidebands_is_wear(make: Make) -> None:
    analysis = analyse_recording(
        make(lines=mesh({}, amplitude=5.0), nameplate=GEARS), baseline=make(lines=mesh({}), nameplate=GEARS, seed=9)
    )
    assert top(analysis)[0] == "gear_wear"


def test_a_mesh_that_takes_its_sidebands_along_is_wear(make: Make) -> None:
    """Modulation of an unchanged depth: the mesh got stronger, the gear did not get rounder or less round."""
    sides = (-2, -1, 1, 2)
    healthy = make(lines=mesh({side: 0.1 for side in sides}), nameplate=GEARS, seed=9)
    worn = make(lines=mesh({side: 0.5 for side in sides}, amplitude=5.0), nameplate=GEARS)
    assert top(analyse_recording(worn, baseline=healthy))[0] == "gear_wear"


def test_one_grown_pair_is_eccentricity(make: Make) -> None:
    lines = mesh({-1: 0.6, 1: 0.6})
    analysis = analyse_recording(
        make(lines=lines, nameplate=GEARS), baseline=make(lines=mesh({}), nameplate=GEARS, seed=9)
    )
    assert top(analysis)[0] == "gear_eccentricity"
    # An unbalance of the gear's shaft changes the centre distance once a turn just as well.
    assert "unbalance" in analysis.findings[0].rivals


def test_mesh_that_rose_in_one_direction_only_may_be_a_loose_joint(make: Make) -> None:
    healthy = make(lines=mesh({}), nameplate=GEARS, seed=9)
    loud, same = make(lines=mesh({}, amplitude=6.0), nameplate=GEARS), make(lines=mesh({}), nameplate=GEARS)
    one_way = replace(loud, signals=np.stack([loud.signals[0], same.signals[1]]))
    assert stated(analyse_recording(loud, baseline=healthy), "looseness") < LEAST_PROBABILITY
    shared = analyse_recording(one_way, baseline=healthy)
    assert stated(shared, "looseness") > 0.3
    assert stated(shared, "gear_wear") > 0.2


def test_2x_in_one_direction_only_may_be_a_contact(make: Make) -> None:
    loud, same = make(lines={**HEALTHY, 2: 2.0}), make()
    one_way = replace(loud, signals=np.stack([loud.signals[0], same.signals[1]]))
    analysis = analyse_recording(one_way, baseline=make(seed=7))
    assert {one.fault for one in analysis.findings} >= {"misalignment", "rub", "looseness"}
    assert {"rub", "looseness"} <= set(analysis.findings[0].rivals)


def test_bearing_that_modulates_the_mesh_is_no_defect(make: Make) -> None:
    """Sidebands at BPFO beside the mesh lines, as strong as they may be, are no impacts; a comb of its own is."""
    plate = Nameplate(gears=(GearPair(23, 46),), bearings=(MountedBearing(find_bearing("6205")),))
    beside = {
        mesh_order + sign * times * ORDERS.outer_race: 1.0 / times
        for mesh_order in (69.0, 92.0, 115.0)
        for times in (1, 2, 3)
        for sign in (-1, 1)
    }
    modulated = make(lines={**HEALTHY, **beside}, nameplate=plate, noise_rms=0.1)
    assert stated(analyse_recording(modulated), "bearing_outer_race") < 0.5
    struck = make(impacts=(ImpactTrain(ORDERS.outer_race, 5.0, 3000.0),), nameplate=plate)
    assert stated(analyse_recording(struck), "bearing_outer_race") > 0.9


# --- the machine at rest, sensors ---------------------------------------------------------------------------------


def test_machine_at_rest_is_not_diagnosed(make: Make) -> None:
    analysis = analyse_recording(make(lines={}, noise_rms=0.05))
    assert not analysis.findings
    assert "not turning" in analysis.verdict


def test_clipped_signal_is_a_sensor_fault(make: Make) -> None:
    recording = make(lines={1: 3.0})
    clipped = replace(recording, signals=np.clip(recording.signals, -2.0, 2.0))
    analysis = analyse_recording(clipped)
    assert stated(analysis, "sensor_fault") > 0.5
    assert any("clipped" in text for text in analysis.warnings)


def test_one_dead_channel_does_not_stop_the_other(make: Make) -> None:
    recording = make(impacts=(ImpactTrain(ORDERS.outer_race, 5.0, 3000.0),))
    signals = recording.signals.copy()
    signals[1] = 0.0
    analysis = analyse_recording(replace(recording, signals=signals))
    assert stated(analysis, "bearing_outer_race") > 0.8
    assert any("constant signal" in text for text in analysis.warnings)


# --- the frame ----------------------------------------------------------------------------------------------------


def test_every_rule_names_faults_of_the_vocabulary() -> None:
    assert len(rules()) >= 8
    assert len(FAULTS) == len(set(FAULTS)) == 16


def test_merging_joins_independent_evidence() -> None:
    joined = merged([Finding("unbalance", 0.5, "a."), Finding("unbalance", 0.4, "b."), Finding("rub", 0.2, "c.")])
    assert [one.fault for one in joined] == ["unbalance", "rub"]
    assert joined[0].probability == pytest.approx(0.7)
    assert joined[0].summary == "a. b."

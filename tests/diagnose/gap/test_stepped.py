"""Lines simulated in time against those balanced in the frequency domain."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.gap.line_noise import BLACKMAN_HARRIS, carriers_of, weighted_amplitudes
from rotorwise.diagnose.gap.lines import Condition, LineKind
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.stepped import lines_of_record
from rotorwise.simulators.effect import make_effect
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.sensor_record import SensorRecord
from rotorwise.simulators.sensor_run import (
    lines_of_chain,
    probe_ratios,
    record_of_signals,
    run_chain,
    sensor_effects,
)
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

ORDERS = (1.0, 2.0, 3.0)


def _predictor(name: str, speeds_rpm: tuple[float, ...], rate_hz: float) -> Predictor:
    probes = [
        p.name for p in find_machine(name).bare_assembly().probes if p.quantity in ("displacement", "acceleration")
    ]
    count = len(speeds_rpm)
    kinds = (*(LineKind(),) * 3, LineKind(phase=False, frequency_hz=100.0))
    return Predictor(
        tuple(Condition(speed) for speed in speeds_rpm),
        tuple(probes),
        (*ORDERS, 0.0),
        (rate_hz,) * count,
        (40_000,) * count,
        kinds,
        (0,) * 4,
    )


@pytest.mark.parametrize(("name", "rate_hz"), [("test_rig", 4000.0), ("amb_rotor", 2000.0)])
def test_what_is_simulated_in_time_agrees_with_the_balance(name, rate_hz):
    predictor = _predictor(name, (1300.0, 1900.0), rate_hz)
    machine = find_machine(name)
    faulty = machine.with_effects(make_effect("unbalance", {"moment_kg_m": 1e-3}))
    balanced = predictor.amplitudes(faulty) - predictor.amplitudes(machine)
    in_time = _predictor(name, (1300.0, 1900.0), rate_hz)
    # As if the unbalance spoilt the repetition.
    in_time._spoiling[f"unbalance at {faulty.effects[0].at}"] = True
    in_time._simulate([("faulty", faulty, machine)], smooth=True)
    found = in_time._known["faulty"] - predictor.amplitudes(machine)
    assert np.abs(found - balanced).max() < 0.01 * np.abs(balanced).max()


def test_what_is_added_up_agrees_with_what_is_simulated_in_time():
    machine = find_machine("test_rig")
    faulty = machine.with_effects(make_effect("twice_line_force", {"force_n": 5.0, "torque_n_m": 0.3}))
    predictor, in_time = (_predictor("test_rig", (1300.0, 1900.0), 4000.0) for _ in range(2))
    found = predictor.amplitudes(faulty)
    assert not predictor._stepped
    in_time._simulate([("faulty", faulty, machine)], smooth=True)
    wanted = in_time._known["faulty"]
    assert np.abs(found - wanted)[:, :, 3].max() < 1e-3 * np.abs(wanted)[:, :, 3].max()
    assert np.abs(found - wanted)[:, :, :3].max() < 1e-3 * np.abs(wanted)[:, :, :3].max()


@pytest.mark.parametrize(
    ("name", "rate_hz", "chain"),
    [
        (
            "test_rig",
            4000.0,
            [("remounted_sensor", {"gain_change": 0.2, "rotation_rad": 0.4, "tilt_rad": -0.3}, "housing_a")],
        ),
        (
            "amb_rotor",
            2000.0,
            [
                ("run_out", {"harmonic_2_m": 2e-4, "angle_2_rad": 0.6, "harmonic_8_m": 1e-4}, "bearing_1"),
                ("remounted_sensor", {"gain_change": -0.1, "rotation_rad": 0.3, "tilt_rad": 0.0}, "bearing_1"),
            ],
        ),
    ],
)
def test_a_chain_that_only_mixes_and_adds_is_seen_as_a_record_of_it_is(name, rate_hz, chain):
    predictor = _predictor(name, (1300.0, 1900.0), rate_hz)
    moving = find_machine(name).with_effects(make_effect("unbalance", {"moment_kg_m": 1e-3}))
    machine = moving.with_effects(*(make_effect(one, values, at=at) for one, values, at in chain))
    found = predictor.amplitudes(machine)
    (motions,) = predictor._all_moving([moving])
    assert not isinstance(motions, Exception)
    for index, motion in enumerate(motions):
        phase = motion.speed_rad_s * np.arange(40_000) / rate_hz
        recorded = predictor._recorded(machine, motion.probes, motion.waveform(phase), phase, index)
        assert np.abs(recorded - found[index])[:, :3].max() < 1e-4 * np.abs(found[index]).max()
        # Nothing lies beside the orders.
        assert not found[index][:, 3].any()
    assert np.abs(found - predictor.amplitudes(moving)).max() > 0.05 * np.abs(found).max()


def test_a_force_of_the_supply_leaves_the_shaft_s_orders_alone():
    predictor = _predictor("test_rig", (1300.0, 1900.0), 4000.0)
    machine = find_machine("test_rig")
    faulty = machine.with_effects(make_effect("twice_line_force", {"force_n": 5.0, "torque_n_m": 0.0}))
    change = predictor.amplitudes(faulty) - predictor.amplitudes(machine)
    assert np.abs(change[:, :, 3]).max() > 20 * np.abs(change[:, :, :3]).max()


@pytest.mark.parametrize("speed_rpm", [1052.0, 2059.0, 3849.0])
def test_a_line_close_to_an_order_is_predicted_as_far_as_the_recording_shows_it(speed_rpm):
    # At 2059 and 3849 rpm 100 Hz lies 2.9 and 3.8 Hz from a half order: sixteen turns do not tell them apart.
    predictor = _predictor("amb_rotor", (speed_rpm,), 10_000.0)
    hum = make_effect("mains_hum", {"amplitude": 0.05, "second": 0.4, "third": 0.0}, at="bearing_1")
    change = predictor.amplitudes(find_machine("amb_rotor").with_effects(hum))[0, :, 3]
    motion = harmonic_balance(find_machine("amb_rotor"), speed_rpm=speed_rpm)
    swing = np.abs(motion.waveform(np.linspace(0, 32 * np.pi, 20_000))).max(axis=1)
    names = [probe.name for probe in motion.probes]
    expected = [0.05 * 0.4 * swing[names.index(name)] for name in predictor.probes[:2]]
    assert change[:2].real == pytest.approx(expected, rel=0.05)


def test_a_chain_that_leaves_a_channel_alone_leaves_its_lines_alone():
    predictor, machine = _predictor("amb_rotor", (1300.0, 1900.0), 10_000.0), find_machine("amb_rotor")
    hum = make_effect("mains_hum", {"amplitude": 0.05}, at="path_2")
    change = predictor.amplitudes(machine.with_effects(hum)) - predictor.amplitudes(machine)
    own = predictor.probes.index("path_2")
    assert np.abs(change[:, own]).max() > 0
    assert not np.delete(change, own, axis=1).any()


def test_only_so_many_are_simulated_in_time():
    predictor, machine = _predictor("amb_rotor", (1300.0,), 2000.0), find_machine("amb_rotor")
    shaken = [machine.with_effects(make_effect("load_fluctuation", {"torque_n_m": 0.1 * k})) for k in range(1, 6)]
    bent = machine.with_effects(make_effect("unbalance", {"moment_kg_m": 1e-3}))
    assert predictor.prepare([*shaken, bent], most_in_time=2) == [True, False, False, False, True, True]


def test_carriers_of_half_orders_are_products_of_one():
    turns, orders = np.linspace(0.3, 40.0, 5000), np.array([3.0, 0.5, 1.0, 1 / 3, 0.0, 6.5, 21.37, 2.0])
    wanted = np.exp(-2j * np.pi * np.outer(orders, turns))
    np.testing.assert_allclose(carriers_of(orders, turns), wanted, rtol=0, atol=1e-12)


def test_what_lies_beside_an_order_does_not_leak_into_it():
    # 4.5 lines of the spectrum of 24 turns beside 3X: the nearest that `least_seconds` lets any line be.
    turns = np.arange(0.0, 24.0, 1 / 64)
    beside = np.cos(2 * np.pi * (3 + 4.5 / 24) * turns + 0.3)
    order = np.array([3.0])
    hann = weighted_amplitudes(beside[None], turns=turns, orders=order)
    assert abs(hann[0, 0]) > 1e-3
    assert abs(weighted_amplitudes(beside[None], turns=turns, orders=order, window=BLACKMAN_HARRIS)[0, 0]) < 1e-4
    own = np.cos(2 * np.pi * 3 * turns + 0.3)
    found = weighted_amplitudes(own[None], turns=turns, orders=order, window=BLACKMAN_HARRIS)[0, 0]
    assert found == pytest.approx(np.exp(0.3j), rel=1e-6)


def test_run_out_of_a_slower_shaft_is_at_its_own_order():
    gearbox = find_machine("gearbox")
    probes = {p.name: p for p in gearbox.bare_assembly().probes}
    channels = (probes["wheel x"], probes["pinion y"])
    ratios = probe_ratios(gearbox, channels)
    assert ratios[0] < 0.5
    assert ratios[1] == 1
    first_alone = make_effect("run_out", {}).at_zero().with_values(harmonic_1_m=1e-4)
    on_wheel, on_pinion = (gearbox.with_effects(replace(first_alone, at=one.location)) for one in channels)
    still, orders = np.zeros((2, 3), dtype=complex), (1, 2, 3)
    assert lines_of_chain(on_wheel, channels, still, orders) is None
    found = lines_of_chain(on_pinion, channels, still, orders)
    assert found is not None
    np.testing.assert_allclose(np.abs(found), [[0, 0, 0], [1e-4, 0, 0]], atol=1e-18)
    phase = 2 * np.pi * np.arange(4000) / 100
    how = {"phase_rad": phase, "speed_rad_s": np.full(phase.size, 63.0), "rate_hz": 1000.0, "output_rate_hz": 1000.0}
    record = record_of_signals(np.zeros((2, phase.size)), gearbox, channels, **how)
    shown = run_chain(record, sensor_effects(on_wheel), samples=phase.size, seed=0).signals
    np.testing.assert_allclose(shown, 1e-4 * np.stack([np.cos(ratios[0] * phase), 0 * phase]), atol=1e-12)


def test_motions_that_are_kept_hold_no_memory_but_their_own():
    # As parts of all lanes that were simulated beside them they would hold all of these: gigabytes in a search.
    predictor = _predictor("rigid_coupling", (900.0, 1300.0), 2000.0)
    machine = find_machine("rigid_coupling")
    chain = make_effect("mains_hum", {})
    unheard = [
        machine.with_effects(make_effect("twice_line_force", {"force_n": force}), chain) for force in (20.0, 40.0)
    ]
    predictor._simulate([(one.to_toml(), one, None) for one in unheard], smooth=False)
    kept = [run for runs in predictor._stepped.values() for run in runs if run is not None]
    assert len(kept) == 4
    assert all(run.signals.base is None for run in kept)


@pytest.mark.parametrize("turns", [24.0, 26.3, 40.0])
def test_a_mesh_does_not_leak_into_its_sidebands_in_a_short_record(turns):
    """The wheel's sidebands of a mesh two hundred times as large, seven lines of the spectrum away."""
    order, own, rate_hz, speed_hz = 23.0, 23 / 81, 20480.0, 36.0
    phase = 2 * np.pi * speed_hz * np.arange(round(turns / speed_hz * rate_hz)) / rate_hz
    probe = next(p for p in find_machine("gearbox").bare_assembly().probes if p.quantity == "acceleration")
    plain = LineKind(phase=False)
    orders, kinds = (1.0, order - own, order, order + own, 22.0), (LineKind(), plain, plain, plain, plain)

    def sizes(sideband):
        signal = 0.2 * np.cos(phase) + 20 * np.cos(order * phase + 0.4)
        signal += sideband * (np.cos((order - own) * phase + 1.0) + np.cos((order + own) * phase))
        ones = np.ones(1)
        record = SensorRecord(
            signal[None],
            rate_hz,
            rate_hz,
            phase,
            np.full(phase.size, 2 * np.pi * speed_hz),
            (probe,),
            (1.0,),
            ones,
            0 * ones,
            0 * ones,
        )
        return np.abs(lines_of_record(record, probes=[probe.name], orders=orders, kinds=kinds)[0])

    assert sizes(0.1) == pytest.approx([0.2, 0.1, 20.0, 0.1, 0.0], rel=0.05, abs=0.02)
    assert sizes(0.0)[[1, 3]] == pytest.approx([0.0, 0.0], abs=1e-3)

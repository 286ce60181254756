"""The simulated rig beside the measured healthy bench: what calibration reaches, and what is known to be missing."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "01_adi_limerick_mfs"

pytestmark = [
    pytest.mark.measured,
    pytest.mark.skipif(not DATA.is_dir(), reason=f"measured recordings are not at {DATA}"),
]


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"measured_{name}", Path(__file__).with_name(f"{name}.py"))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


rig = load("rig_calibration")


@cache
def calibrated():
    found = rig.calibrate()
    return found, rig.bench().with_parameters(**found.values)


def test_response_is_that_of_harmonic_balance() -> None:
    machine, where = rig.bench(), rig.Arrangement()
    motion = harmonic_balance(machine, speed_rpm=1800.0, harmonics=1)
    expected = [abs(motion.amplitude(probe, 1.0)) / machine.values[rig.UNBALANCE] for probe in where.probes]
    assert rig.unbalance_response(machine, [30.0], where)[0] == pytest.approx(expected, rel=1e-6)


def test_known_values_are_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    # Records replaced by the model's own answer: a fit that works must come back to the values within its interval.
    truth = {"base_width_m": 0.45, "base_centre_m": 0.05, rig.UNBALANCE: 1e-4}
    values = {name: value for name, value in truth.items() if name != rig.UNBALANCE}
    machine, where = rig.bench().with_parameters(**values), rig.Arrangement()

    def own(speed: str, load: str = rig.HEALTHY):
        hz = float(speed) / 60
        lines = rig.unbalance_response(machine, [hz], where)[0] * (
            truth[rig.UNBALANCE] if load == rig.HEALTHY else 7e-4
        )
        nothing = np.ones((3, 1))
        return rig.Measured(hz, lines[:, None], nothing, nothing, nothing)

    monkeypatch.setattr(rig, "measured", own)
    found = rig.calibrate()
    for name, value in truth.items():
        low, high = found.interval(name)
        assert low < value < high, (name, low, value, high)
    assert found.seeded_kg_m["VHIL"] == pytest.approx(7e-4, rel=0.05)


def test_preset_holds_what_is_found() -> None:
    found, _ = calibrated()
    preset = find_machine("test_rig").preset("adi").values
    for name, value in found.values.items():
        low, high = found.interval(name)
        # Rounded to two digits; a search that ends elsewhere would differ by a share of the interval.
        assert abs(preset[name] - value) < 0.05 * (high - low), (name, preset[name], value)


def test_calibration_lowers_the_held_out_error_of_the_healthy_bench() -> None:
    found, after = calibrated()
    errors = [
        rig.errors_db(machine, rig.HELD_OUT_SPEED, found.arrangement, found.seeded_kg_m)[0][list(rig.RADIAL)]
        for machine in (rig.bench(), after)
    ]
    assert rig.rms(errors[1]) < 0.5 * rig.rms(errors[0])
    assert np.abs(errors[1]).max() < 4.0


@pytest.mark.parametrize("speed", ["1200", "1800", "2400"])
def test_radial_1x_of_seeded_unbalance_is_right(speed: str) -> None:
    found, after = calibrated()
    _, seeded = rig.errors_db(after, speed, found.arrangement, found.seeded_kg_m)
    assert np.abs(seeded[:, list(rig.RADIAL)]).max() < rig.RIGHT_DB


def test_calibration_lowers_the_radial_error_of_seeded_unbalance_over_all_speeds() -> None:
    found, after = calibrated()
    first = rig.seeded_unbalance_kg_m(rig.bench(), found.arrangement)
    errors = [
        rig.rms(
            [
                rig.errors_db(machine, speed, found.arrangement, amounts)[1][:, list(rig.RADIAL)]
                for speed in (*rig.FITTED_SPEEDS, rig.HELD_OUT_SPEED)
            ]
        )
        for machine, amounts in ((rig.bench(), first), (after, found.seeded_kg_m))
    ]
    assert errors[1] < errors[0]


def test_what_the_model_lacks_is_in_the_records() -> None:
    # Gaps, not virtues: a change of the model that closes one of them must come with new words in tests/README.md.
    found, after = calibrated()
    healthy = {speed: rig.measured(speed) for speed in (*rig.FITTED_SPEEDS, rig.HELD_OUT_SPEED)}
    for speed in healthy:
        axial = rig.errors_db(after, speed, found.arrangement, found.seeded_kg_m)[0][2]
        assert axial < -10.0
    # Along the shaft 2X is larger than 1X at every speed, and stands clear of its own spread; the linear rig has none.
    motion = harmonic_balance(after, speed_rpm=2400.0, harmonics=2)
    for record in healthy.values():
        assert record.lines[2, 1] > record.lines[2, 0]
        assert record.lines_spread_db[2, 1] < 2.0
    assert abs(motion.amplitude(found.arrangement.probes[2], 2.0)) < 1e-6
    growth = np.log2(healthy["2400"].lines[0, 0] / healthy["1200"].lines[0, 0])
    assert growth < 1.2
    simulated = rig.unbalance_response(after, [20.0, 40.0], found.arrangement)[:, 0]
    assert np.log2(simulated[1] / simulated[0]) == pytest.approx(2.0, abs=0.2)


def test_line_at_4170_hz_does_not_depend_on_speed() -> None:
    table = load("rig_table")
    from rotorwise.diagnose.signal.spectrum import amplitude_spectrum

    sizes = []
    for speed in ("1200", "1800", "2400"):
        volts, rate_hz = rig.recorded(speed)
        frequency, amplitude = amplitude_spectrum(volts, rate_hz=rate_hz)
        inside = (frequency > table.PICKUP_HZ[0]) & (frequency < table.PICKUP_HZ[1])
        assert amplitude[0, inside].max() > 10 * np.median(amplitude[0, inside])
        sizes.append(amplitude[0, inside].max())
    # The noise round it grows by 5 dB from 1200 to 2400 rpm.
    assert 20 * np.log10(max(sizes) / min(sizes)) < 2.0

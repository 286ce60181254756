"""Severity of recordings: known sines, the choice of the table, refusals, baseline."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.datasets.recording import Channel, Nameplate, OperatingCondition, Recording
from rotorwise.diagnose.severity import assess, baseline_limits, zone_of
from rotorwise.simulators.errors import InvalidValueError

RATE = 5120.0


def sine(rms, *, frequency=50.3, seconds=4.0, rate=RATE, phase=0.0):
    """Sine of this rms, in whatever unit."""
    time = np.arange(round(seconds * rate)) / rate
    return math.sqrt(2) * rms * np.sin(2 * np.pi * frequency * time + phase)


def recording(*signals, quantity="velocity", rate=RATE, plate=None, speed=None, **channel):
    channels = tuple(Channel(name=f"ch{index}", quantity=quantity, **channel) for index in range(len(signals)))
    return Recording(
        signals=np.array(signals),
        rate_hz=rate,
        channels=channels,
        nameplate=plate or Nameplate(),
        condition=OperatingCondition(speed_rpm=speed),
    )


@pytest.mark.parametrize("frequency", [25.0, 49.37, 120.1, 400.2])
@pytest.mark.parametrize("quantity", ["acceleration", "velocity"])
def test_known_velocity_is_found_within_half_a_percent(frequency, quantity):
    derivative = 2 * np.pi * frequency if quantity == "acceleration" else 1.0
    signal = sine(3e-3 * derivative, frequency=frequency)
    (result,), refusal = assess(recording(signal, quantity=quantity), speed_rpm=1500, table="iso10816-1-class2")
    assert refusal == ""
    assert result.value == pytest.approx(3.0, rel=5e-3)
    assert (result.unit, result.zone, result.quantity) == ("mm/s", "C", "velocity, rms, 10-1000 Hz")
    assert result.boundaries == (1.12, 2.8, 7.1)
    assert (result.channel, result.standard, result.confidence) == ("ch0", "ISO 10816-1", "H")


def test_value_on_a_boundary_is_in_the_better_zone():
    limits = (1.4, 2.8, 4.5)
    assert [zone_of(value, limits) for value in (0.0, 1.4, 2.8, 4.5)] == ["A", "A", "B", "C"]
    assert [zone_of(np.nextafter(value, 9), limits) for value in limits] == ["B", "C", "D"]


def test_worse_of_velocity_and_displacement_counts():
    # A slow machine: 2 mm/s at 5 Hz is zone B by velocity, 64 um less the band edge is zone C by
    # displacement.
    signal = sine(2e-3, frequency=5.0, seconds=40.0)
    (result,), _ = assess(recording(signal), speed_rpm=300, table="iso20816-3-group2-rigid")
    assert result.unit == "um"
    assert result.value == pytest.approx(2e3 / (2 * np.pi * 5.0) / math.sqrt(1 + 0.4**6), rel=5e-3)
    assert result.zone == "C"
    assert "velocity 2 mm/s: zone B" in result.note
    assert result.quantity == "displacement, rms, 2-1000 Hz"


def test_lower_band_edge_follows_the_speed():
    signal = sine(2e-3, frequency=5.0, seconds=40.0)
    for speed, expected in ((599.0, 2 / math.sqrt(1 + 0.4**6)), (600.0, 2 * 0.5**3 / math.sqrt(1 + 0.5**6))):
        (result,), _ = assess(recording(signal), speed_rpm=speed, table="iso10816-1-class1")
        assert result.value == pytest.approx(expected, rel=0.01)


def test_unknown_machine_gets_a_marked_assumption():
    (result,), _ = assess(recording(sine(3e-3)))
    assert (result.standard, result.zone) == ("ISO 20816-3", "C")
    assert "machine group not given: group 2, rigid assumed; pass --severity-table" in result.note
    assert "speed not given" in result.note


@pytest.mark.parametrize(
    ("plate", "table", "assumed"),
    [
        (Nameplate(power_kw=11.0), "class I ", ""),
        (Nameplate(power_kw=15.0, mounting="rigid"), "group 2 ", ""),
        (Nameplate(power_kw=300.0, mounting="rigid"), "group 2 ", ""),
        (Nameplate(power_kw=301.0, mounting="rigid"), "group 1 ", ""),
        (Nameplate(shaft_height_mm=315.0, mounting="rigid"), "group 1 ", ""),
        (Nameplate(shaft_height_mm=314.0, mounting="rigid"), "group 2 ", ""),
        (Nameplate(shaft_height_mm=160.0), "group 2 ", "mounting not given: rigid assumed"),
        (Nameplate(shaft_height_mm=132.0), "class I ", "class I assumed"),
        (Nameplate(mounting="flexible"), "group 2 ", "group 2 assumed"),
        (Nameplate(severity_table="iso10816-1-class4", power_kw=11.0), "class IV", ""),
    ],
)
def test_table_follows_the_nameplate(plate, table, assumed):
    (result,), _ = assess(recording(sine(1e-3), plate=plate), speed_rpm=1500)
    assert table in result.table
    assert (assumed in result.note) if assumed else ("assumed" not in result.note)
    if plate.mounting and not plate.severity_table:
        assert plate.mounting in result.table


def test_argument_beats_the_nameplate_and_worst_comes_first():
    plate = Nameplate(severity_table="iso10816-1-class4")
    results, _ = assess(recording(sine(1e-3), sine(6e-3), sine(2e-3), plate=plate), table="iso10816-1-class1")
    assert [result.channel for result in results] == ["ch1", "ch2", "ch0"]
    assert [result.zone for result in results] == ["D", "C", "B"]


def test_unknown_table_names_the_known_ones():
    with pytest.raises(InvalidValueError, match="iso20816-3-group1-rigid"):
        assess(recording(sine(1e-3)), table="iso1940")


@pytest.mark.parametrize("speed", [-1.0, math.nan, math.inf])
def test_impossible_speed_is_refused(speed):
    with pytest.raises(InvalidValueError, match="Speed"):
        assess(recording(sine(1e-3)), speed_rpm=speed)


@pytest.mark.parametrize(
    ("quantity", "said"),
    [
        (None, "Unit of ch0 unknown: no severity. Pass --unit or --sensitivity."),
        ("voltage", "--sensitivity"),
        ("sound_pressure", "sound pressure"),
        ("tacho", "No vibration channel"),
        ("force", "No vibration channel"),
    ],
)
def test_refusals(quantity, said):
    for table in (None, "iso10816-1-class1"):
        results, refusal = assess(recording(sine(1e-3), quantity=quantity), table=table)
        assert results == ()
        assert said in refusal
        assert "which this recording lacks" not in refusal


def test_unknown_unit_never_gives_a_zone_beside_a_known_one():
    both = recording(sine(1e-3), sine(1.0))
    both = replace(both, channels=(both.channels[0], Channel(name="mystery")))
    results, refusal = assess(both)
    assert [result.channel for result in results] == ["ch0"]
    assert refusal == ""


def test_table_for_another_sensor_is_refused_by_name():
    results, refusal = assess(recording(sine(1e-3)), speed_rpm=3000, table="api617-shaft")
    assert results == ()
    assert "api617-shaft needs a displacement probe" in refusal
    results, refusal = assess(recording(sine(1e-5), quantity="displacement"), speed_rpm=3000, table="iso10816-1-class1")
    assert results == ()
    assert "needs acceleration or velocity" in refusal


def test_dead_and_gapped_channels_are_refused_not_called_good():
    results, refusal = assess(recording(np.full(20480, 0.3)))
    assert results == ()
    assert "never changes" in refusal
    half = sine(1e-3)
    half[::7] = np.nan
    half[1::7] = np.inf
    results, refusal = assess(recording(half))
    assert results == ()
    assert "gaps" in refusal


def test_few_gaps_are_left_out_and_said():
    signal = sine(3e-3, seconds=60.0)
    signal[10:13] = np.nan, np.inf, -np.inf
    (result,), _ = assess(recording(signal), table="iso10816-1-class2")
    assert result.value == pytest.approx(3.0, rel=5e-3)
    assert "missing" in result.note


def test_short_records_are_marked_then_refused():
    (result,), _ = assess(recording(sine(3e-3, seconds=0.5)), speed_rpm=3000)
    assert "only 5 periods" in result.note
    results, refusal = assess(recording(sine(3e-3, seconds=0.1)), speed_rpm=3000)
    assert results == ()
    assert "Record 0.8 s or more" in refusal


def test_low_sampling_rate_is_marked():
    (result,), _ = assess(recording(sine(3e-3, rate=1000.0), rate=1000.0), speed_rpm=3000)
    assert "nothing above about 391 Hz" in result.note
    results, refusal = assess(recording(sine(3e-3, frequency=3.0, rate=16.0), rate=16.0), speed_rpm=3000)
    assert results == ()
    assert "at 16 Hz is too little" in refusal


def test_unverified_rows_are_marked():
    (result,), _ = assess(recording(sine(3e-3)), speed_rpm=1500, table="iso20816-2-housing")
    assert not result.verified
    assert "not verified" in result.note
    (result,), _ = assess(recording(sine(3e-3)), speed_rpm=3000, table="iso20816-2-housing")
    assert result.verified


def test_speed_outside_a_table_is_refused():
    for table in ("iso20816-2-housing",):
        results, refusal = assess(recording(sine(3e-3)), speed_rpm=1000, table=table)
        assert results == ()
        assert "no limits at 1000 r/min" in refusal
        assert "2850-3150" in refusal
        results, refusal = assess(recording(sine(3e-3)), table=table)
        assert results == ()
        assert "Pass --speed" in refusal


def test_shaft_probe_peak_to_peak_and_formula():
    signal = sine(40e-6 / math.sqrt(2)) - 1.2e-3
    (result,), _ = assess(recording(signal, quantity="displacement"), speed_rpm=3600)
    assert result.value == pytest.approx(80.0, rel=5e-3)
    assert result.boundaries == pytest.approx((80.0, 150.0, 220.0))
    assert (result.unit, result.quantity) == ("um", "shaft displacement, peak-to-peak")
    assert result.note == ""


def test_shaft_probe_without_speed_is_refused_and_nominal_speed_is_said():
    probe = recording(sine(20e-6), quantity="displacement")
    results, refusal = assess(probe)
    assert results == ()
    assert "Pass --speed" in refusal
    (result,), _ = assess(replace(probe, condition=OperatingCondition(speed_rpm=3600)))
    assert "nominal speed 3600 r/min used" in result.note
    results, refusal = assess(probe, speed_rpm=500)
    assert results == ()
    assert "1000-30000" in refusal


def test_burst_on_a_probe_counts_and_is_said():
    signal = sine(10e-6, seconds=10.0)
    signal[30000:35000] *= 5
    (result,), _ = assess(recording(signal, quantity="displacement"), speed_rpm=3600)
    assert result.value == pytest.approx(2 * 5 * 10 * math.sqrt(2), rel=0.01)
    assert "unsteady" in result.note


def test_housing_and_shaft_channels_each_get_their_table():
    both = recording(sine(3e-3), sine(60e-6))
    both = replace(both, channels=(both.channels[0], Channel(name="probe", quantity="displacement")))
    results, _ = assess(both, speed_rpm=3600, table="iso20816-3-group1-rigid")
    tables = {result.channel: result.table for result in results}
    assert "group 1" in tables["ch0"]
    assert "shaft" in tables["probe"]


def test_api_limit_is_one_boundary():
    probe = recording(sine(8e-6), quantity="displacement")
    (result,), _ = assess(probe, speed_rpm=48000, table="api617-shaft", baseline=probe)
    assert result.boundaries == (12.7,)
    assert result.zone == "B"
    assert "no zones" in result.note
    assert (result.alarm, result.trip) == (None, None)
    (result,), _ = assess(probe, speed_rpm=12000, table="api617-shaft")
    assert (result.boundaries, result.zone) == ((25.4,), "A")


def magnetic(x, y, *, clearance=250e-6, places=("drive end", "drive end")):
    return Recording(
        signals=np.array([x, y]),
        rate_hz=RATE,
        channels=tuple(
            Channel(name=name, quantity="displacement", direction=name, location=place)
            for name, place in zip("xy", places, strict=True)
        ),
        nameplate=Nameplate(magnetic_bearing_clearance_m=clearance),
    )


def test_magnetic_bearing_radius_counts_the_offset():
    orbit = (sine(20e-6 / math.sqrt(2)), sine(20e-6 / math.sqrt(2), phase=math.pi / 2))
    (result,), _ = assess(magnetic(*orbit))
    assert result.value == pytest.approx(20.0, rel=1e-3)
    assert (result.standard, result.zone, result.channel) == ("ISO 14839-2", "A", "x + y")
    (result,), _ = assess(magnetic(orbit[0] + 60e-6, orbit[1] + 80e-6))
    assert result.value == pytest.approx(120.0, rel=1e-3)
    assert result.zone == "C"
    assert result.boundaries == pytest.approx((75.0, 100.0, 125.0))


def test_magnetic_bearing_needs_a_pair_and_a_clearance():
    orbit = (sine(20e-6), sine(20e-6, phase=1.0))
    results, refusal = assess(magnetic(*orbit, places=("drive end", "other end")))
    assert results == ()
    assert "an x and a y displacement probe" in refusal
    results, refusal = assess(magnetic(*orbit, clearance=None), table="iso14839-2")
    assert results == ()
    assert "clearance" in refusal


def test_horizontal_and_vertical_magnetic_probes_are_a_pair():
    there = magnetic(sine(20e-6 / math.sqrt(2)), sine(20e-6 / math.sqrt(2), phase=math.pi / 2))
    turned = [replace(one, direction=way) for one, way in zip(there.channels, ("horizontal", "vertical"), strict=True)]
    results, refusal = assess(replace(there, channels=tuple(turned)))
    assert (refusal, len(results)) == ("", 1)
    assert (results[0].channel, results[0].zone) == ("x + y", "A")


def test_gear_unit_table():
    (result,), _ = assess(recording(sine(6e-3)), speed_rpm=1500, table="iso20816-9-subclass-a2")
    assert (result.zone, result.boundaries) == ("C", (3.15, 5.0, 8.0))
    signal = sine(60.0, frequency=800.0)
    (result,), _ = assess(recording(signal, quantity="acceleration"), table="iso20816-9-subclass-a2-acceleration")
    assert result.value == pytest.approx(60.0, rel=5e-3)
    assert not result.verified
    assert "assumption" in result.note


@pytest.mark.parametrize(
    ("baseline", "alarm"), [(1.0, 1.0 + 0.25 * 2.8), (2.8, 1.25 * 2.8), (2.9, 1.25 * 2.8), (0.0, 0.7)]
)
def test_baseline_limits(baseline, alarm):
    assert baseline_limits(baseline, (1.4, 2.8, 4.5)) == pytest.approx((alarm, 1.25 * 4.5))


def test_baseline_gives_alarm_trip_and_significant_change():
    options = {"speed_rpm": 1500.0, "table": "iso10816-1-class2"}
    (result,), _ = assess(recording(sine(2e-3)), baseline=recording(sine(1e-3)), **options)
    assert result.alarm == pytest.approx(1.7, rel=5e-3)
    assert result.trip == pytest.approx(1.25 * 7.1)
    assert "significant change since the baseline: 1 to 2 mm/s" in result.note
    # 25 % of B/C is 0.7 mm/s: 0.6 is not significant, a fall by 0.8 is.
    (result,), _ = assess(recording(sine(1.6e-3)), baseline=recording(sine(1e-3)), **options)
    assert "significant" not in result.note
    (result,), _ = assess(recording(sine(1.0e-3)), baseline=recording(sine(1.8e-3)), **options)
    assert "significant" in result.note
    (result,), _ = assess(recording(sine(1e-3)), **options)
    assert (result.alarm, result.trip) == (None, None)


def test_baseline_in_another_unit_serves_and_a_missing_one_is_said():
    now = recording(sine(2e-3))
    before = recording(sine(1e-3 * 2 * np.pi * 50.3), quantity="acceleration")
    (result,), _ = assess(now, baseline=before, speed_rpm=1500, table="iso10816-1-class2")
    assert result.alarm == pytest.approx(1.7, rel=5e-3)
    for useless in (recording(sine(1e-3), quantity=None), recording(sine(1e-3, seconds=0.05))):
        (result,), _ = assess(now, baseline=useless, speed_rpm=1500, table="iso10816-1-class2")
        assert result.alarm is None
        assert "no alarm limits" in result.note


def test_memory_map_of_integers_or_single_floats_works(tmp_path):
    path = tmp_path / "signal.dat"
    stored = np.memmap(path, dtype=np.float32, mode="w+", shape=(1, 20480))
    stored[0] = sine(3e-3)
    (result,), _ = assess(replace(recording(sine(3e-3)), signals=stored), table="iso10816-1-class2")
    assert result.value == pytest.approx(3.0, rel=5e-3)


def test_extra_memory_does_not_grow_with_the_record():
    import tracemalloc

    peaks = []
    for seconds in (60.0, 600.0):
        long = recording(sine(3e-3, seconds=seconds))
        tracemalloc.start()
        assess(long, table="iso20816-3-group2-rigid")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.5 * peaks[0] + 8e6


@settings(max_examples=30, deadline=None)
@given(
    small=st.floats(1e-5, 2e-2),
    factor=st.floats(1.0, 10.0),
    frequency=st.floats(15.0, 900.0),
    table=st.sampled_from(["iso10816-1-class1", "iso20816-3-group1-flexible", "iso20816-9-subclass-a4"]),
)
def test_zone_never_falls_when_the_amplitude_grows(small, factor, frequency, table):
    signal = sine(small, frequency=frequency, seconds=1.0)
    (quiet,), _ = assess(recording(signal), speed_rpm=1500, table=table)
    (loud,), _ = assess(recording(factor * signal), speed_rpm=1500, table=table)
    assert loud.zone >= quiet.zone

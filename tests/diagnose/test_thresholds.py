"""`rotorwise thresholds`: levels against solutions of their own, closed forms, words, the page in a browser."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.misalignment_levels import Levels, fitting, misalignment_levels
from rotorwise.diagnose.misalignment_thresholds import largest
from rotorwise.diagnose.signal.integrate import averaged_power, rms_from_power
from rotorwise.diagnose.zones.table import find_table
from rotorwise.simulators.effects.coupling_misalignment import CouplingMisalignment
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import Machine, find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from rotorwise.simulators.threshold_map import threshold_map

from .command import Done, run

OFFSETS, ANGLES = np.array([0.0, 3e-4, 1e-3]), np.array([0.0, 0.004, 0.02])


def rotorwise(*arguments: object) -> Done:
    done = run("thresholds", *arguments)
    assert "Traceback" not in done.stderr + done.stdout, done.stderr
    return done


def levels(machine: Machine, table: str, speed_rpm: float, clearance_m: float | None = None) -> Levels:
    probes, rows = fitting(find_table(table).rows, machine.bare_assembly().probes, speed_rpm=speed_rpm)
    return misalignment_levels(
        machine,
        speed_rpm=speed_rpm,
        offsets_m=OFFSETS,
        angles_rad=ANGLES,
        probes=probes,
        rows=rows,
        clearance_m=clearance_m,
    )


def misaligned(machine: Machine, offset_m: float, angle_rad: float) -> Machine:
    return machine.with_effects(
        CouplingMisalignment(offset_m=offset_m, angle_rad=angle_rad, offset_phase_rad=0.0, angle_phase_rad=0.0)
    )


# ---- theory ----


def test_velocity_levels_are_the_rms_of_a_solution_of_its_own() -> None:
    """sqrt(sum |A_n|^2 / 2) / (n w) inside 10 to 1000 Hz, at the corner of the grid and without misalignment."""
    machine = find_machine("test_rig")
    made = levels(machine, "iso10816-1-class1", 1800.0)
    assert made.limits == pytest.approx((0.71e-3, 1.8e-3, 4.5e-3))
    omega = 1800 * math.pi / 30
    for i, j in ((0, 0), (2, 2), (1, 2)):
        motion = harmonic_balance(misaligned(machine, OFFSETS[i], ANGLES[j]), speed_rpm=1800.0, harmonics=16)
        orders = np.arange(1, 17)
        for k, name in enumerate(made.map.probes):
            lines = np.array([abs(motion.amplitude(name, n)) for n in orders]) / (orders * omega)
            assert made.map.peaks[k, i, j] == pytest.approx(math.sqrt(float(np.sum(lines**2)) / 2), rel=1e-6)


def test_velocity_levels_are_those_that_analyse_measures_on_a_simulated_record() -> None:
    machine = find_machine("test_rig")
    made = levels(machine, "iso10816-1-class1", 1800.0)
    run = misaligned(machine, OFFSETS[2], ANGLES[1]).simulate(speed_rpm=1800.0, duration_s=1.0, rate_hz=3200.0)
    for k, name in enumerate(made.map.probes):
        frequency, power = averaged_power(run.probe(name), rate_hz=3200.0, low_hz=10.0)
        measured = rms_from_power(
            frequency, power, quantity="acceleration", target="velocity", low_hz=10.0, high_hz=1000.0
        )
        # A window spreads 1X over neighbouring bins, which the division by w weighs unevenly.
        assert made.map.peaks[k, 2, 1] == pytest.approx(float(np.ravel(measured[0])[0]), rel=0.02)


def test_slow_machines_are_judged_from_2_hz() -> None:
    machine = find_machine("test_rig")
    slow = levels(machine, "iso20816-3-group2-rigid", 500.0)
    motion = harmonic_balance(misaligned(machine, 1e-3, 0.0), speed_rpm=500.0, harmonics=16)
    omega = 500 * math.pi / 30
    first = abs(motion.amplitude("housing_a_x", 1)) / omega / math.sqrt(2)
    assert first > 0
    assert slow.map.peaks[0, 2, 0] >= first * (1 - 1e-9)


def test_shaft_levels_are_the_largest_radius_and_peak_to_peak() -> None:
    machine = find_machine("amb_rotor")
    made = levels(machine, "iso14839-2", 4000.0, clearance_m=125e-6)
    assert made.limits == pytest.approx((37.5e-6, 50e-6, 62.5e-6))
    # As analyse judges a record: the distance from the centre, not one of its two components.
    assert made.map.probes == ("bearing_1", "bearing_2")
    one = threshold_map(machine, 4000.0, OFFSETS, ANGLES, harmonics=16).peaks.reshape(2, 2, 3, 3)
    assert np.all(made.map.peaks >= one.max(axis=1) * (1 - 1e-9))
    assert np.all(made.map.peaks <= np.hypot(one[:, 0], one[:, 1]) * (1 + 1e-9))
    for offset, angle in ((0, 0), (2, 1), (1, 2)):
        turned = harmonic_balance(misaligned(machine, OFFSETS[offset], ANGLES[angle]), speed_rpm=4000.0, harmonics=16)
        x, y = turned.waveform(np.linspace(0, 2 * math.pi, 4000)).reshape(2, 2, -1).transpose(1, 0, 2)
        assert made.map.peaks[:, offset, angle] == pytest.approx(np.hypot(x, y).max(axis=1), rel=1e-3)
    swing = levels(machine, "iso20816-3-shaft", 4000.0)
    motion = harmonic_balance(misaligned(machine, 1e-3, 0.02), speed_rpm=4000.0, harmonics=16)
    waves = motion.waveform(np.linspace(0, 2 * math.pi, 4000))
    assert swing.map.peaks[:, 2, 2] == pytest.approx(np.ptp(waves, axis=1), rel=1e-3)


def test_of_two_rows_the_worse_counts() -> None:
    """At low frequency displacement is worse than velocity: v = w x, limits 29/1.4e-3 give a corner near 7.7 Hz."""
    rows = find_table("iso20816-3-group2-rigid").rows
    machine = find_machine("test_rig")
    both = levels(machine, "iso20816-3-group2-rigid", 1800.0)
    alone = [
        misalignment_levels(
            machine,
            speed_rpm=1800.0,
            offsets_m=OFFSETS,
            angles_rad=ANGLES,
            probes=machine.bare_assembly().probes[:6],
            rows=[row],
            clearance_m=None,
        )
        for row in rows
    ]
    zones = [np.searchsorted(one.limits, one.map.peaks, side="left") for one in (both, *alone)]
    np.testing.assert_array_equal(zones[0], np.maximum(zones[1], zones[2]))
    assert set(np.unique(zones[0])) >= {0, 1}


def test_largest_value_within_a_limit() -> None:
    values = np.linspace(0.0, 2.0, 2001)
    assert largest(1 + values**2, values, 2.0)[0] == pytest.approx(1.0, abs=1e-6)
    assert largest(1 + values, values, 0.5) == (None, False)
    assert largest(1 + values, values, 9.0) == (2.0, True)
    # Beyond once is beyond: what comes after does not count.
    assert largest(np.array([0.0, 3.0, 0.0]), np.array([0.0, 1.0, 2.0]), 1.5) == (0.5, False)


def test_a_radius_needs_both_directions_at_one_place() -> None:
    machine = find_machine("amb_rotor")
    rows = find_table("iso14839-2").rows
    with pytest.raises(InvalidValueError, match="an x and a y probe at one place"):
        misalignment_levels(
            machine,
            speed_rpm=4000.0,
            offsets_m=OFFSETS,
            angles_rad=ANGLES,
            probes=machine.bare_assembly().probes[1:3],
            rows=rows,
            clearance_m=1e-4,
        )


def test_a_table_that_does_not_fit_is_refused() -> None:
    probes = find_machine("amb_rotor").bare_assembly().probes
    with pytest.raises(InvalidValueError, match=r"judges housing .*; the probes measure displacement in m"):
        fitting(find_table("iso20816-3-group2-rigid").rows, probes, speed_rpm=3000.0)


# ---- the command ----


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path]:
    page = tmp_path_factory.mktemp("thresholds") / "map.html"
    asked = ("--json", "-o", page, "--offset-max", 5e-4, "--angle-max", 2, "--set", "unbalance_kg_m=1e-4")
    done = rotorwise("amb_rotor", "--speed", 4000, *asked)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), page


def test_json_states_what_each_path_bears(made: tuple[dict[str, Any], Path]) -> None:
    """The stated offset is on the boundary of zone B, and the picture's clearance is the machine's."""
    found, _ = made
    assert found["zones"] == "iso14839-2"
    assert found["boundaries"] == pytest.approx([37.5, 50.0, 62.5])
    assert [one["path"] for one in found["paths"]] == ["bearing_1", "bearing_2"]
    for k, one in enumerate(found["paths"]):
        for offset, angle in ((one["largest_offset_m"], 0.0), (0.0, math.radians(one["largest_angle_deg"]))):
            machine = find_machine("amb_rotor").with_parameters(unbalance_kg_m=1e-4)
            motion = harmonic_balance(misaligned(machine, offset, angle), speed_rpm=4000.0)
            x, y = motion.waveform(np.linspace(0, 2 * math.pi, 4000))[2 * k : 2 * k + 2]
            peak = np.hypot(x, y).max()
            assert peak == pytest.approx(50e-6, rel=1e-3)


def test_terminal_table_fits_80_columns_and_names_the_assumption() -> None:
    done = rotorwise("test_rig", "--preset", "adi", "--speed", 1800)
    assert done.returncode == 0, done.stderr
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert "pass --zones" in done.stdout.replace("\n", " ")
    assert re.search(r"housing_b_x +\d\.\d+ +A +[\d.]+ +over [\d.]+", done.stdout)


def test_wrong_requests_get_one_message_and_write_nothing(tmp_path: Path) -> None:
    page = tmp_path / "mine.html"
    page.write_text("<!DOCTYPE html>mine")
    for arguments, words in (
        (("nothing", "--speed", 1800), "Machine 'nothing' is unknown; allowed: amb_rotor"),
        (("gearbox", "--speed", 1800), "not linear in the motion"),
        (("amb_rotor", "--speed", 0), "more than 0"),
        (("amb_rotor", "--speed", 1800, "--zones", "group9"), "Pass one of them with --zones"),
        (("amb_rotor", "--speed", 1800, "--angle-max", 90), "up to 4.011 degrees"),
        (("amb_rotor", "--speed", 1800, "--clearance", -1), "more than 0"),
        (("test_rig", "--speed", 1800, "--zones", "14839-2"), "the probes measure acceleration"),
        (
            ("amb_rotor", "--speed", 4000, "--preset", "as_printed"),
            "is unstable at 4000 rpm: a disturbance grows",
        ),
        (("amb_rotor", "--speed", "1,5"), "'1,5'; allowed: a number with a decimal point and without unit. Write 1.5."),
        (("amb_rotor", "--speed", 1800, "-o", page), "exists already"),
        (("amb_rotor", "--speed", 1800, "-o", tmp_path / "map.png"), "ends in .html"),
        (("amb_rotor", "--speed", 1800, "-o", tmp_path / "no" / "map.html"), "does not exist"),
    ):
        done = rotorwise(*arguments)
        assert done.returncode == 2, (arguments, done.stderr)
        assert words in done.stderr
        assert done.stdout == ""
    assert "Missing option" in rotorwise("amb_rotor").stderr
    assert [path.name for path in tmp_path.iterdir()] == ["mine.html"]
    assert page.read_text() == "<!DOCTYPE html>mine"


def test_page_is_whole_and_needs_no_network(made: tuple[dict[str, Any], Path]) -> None:
    text = made[1].read_text(encoding="utf-8")
    assert text.count("plotly.js v") == 1
    bare = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)
    assert not re.search(r'(src|href)="(https?:)?//', bare)
    assert "amb_rotor (plausible) at 4000 rpm" in bare
    assert "37.5, 50, 62.5 um" in bare
    assert "parts touch" in bare


@pytest.mark.browser
def test_page_draws_each_zone_where_its_limit_says(made: tuple[dict[str, Any], Path], browser: Any) -> None:
    from selenium.webdriver.support.ui import WebDriverWait

    browser.get(made[1].as_uri())
    WebDriverWait(browser, 30).until(lambda page: page.execute_script("return document.body.dataset.ready"))
    maps = browser.execute_script(
        "return document.querySelector('.canvas').data.filter((t) => t.type === 'heatmap')"
        ".map((t) => [t.zmin, t.zmax, t.colorscale.map((pair) => pair[0])])"
    )
    assert len(maps) == 2
    for low, high, edges in maps:
        assert [low + (high - low) * edge for edge in edges[1:-1:2]] == pytest.approx([37.5, 50.0, 62.5])
    assert browser.get_log("browser") == []

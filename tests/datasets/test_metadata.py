"""Metadata: bearings and gears as text, merging, sidecar files."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.datasets import sidecar as sidecar_file
from rotorwise.datasets.errors import InvalidValueError, UnreadableFileError
from rotorwise.datasets.metadata import ChannelMetadata, Metadata, parse_bearing, parse_gears
from rotorwise.datasets.sidecar import find_sidecar, read_sidecar
from rotorwise.simulators.rotor_dynamics.rolling_bearing import BearingGeometry, bearing_catalogue

SIDECARS = sorted((Path(__file__).parents[1] / "measured").glob("*.toml"))


@given(
    balls=st.integers(6, 30),
    ratio=st.floats(0.05, 0.45),
    angle=st.floats(0.0, 0.7),
)
def test_orders_give_back_the_geometry_they_come_from(balls: int, ratio: float, angle: float) -> None:
    geometry = BearingGeometry(balls, ratio, 1.0, angle)
    orders = geometry.defect_orders()
    text = f"BPFO={orders.outer_race!r},BPFI={orders.inner_race!r},BSF={orders.ball_spin!r},FTF={orders.cage!r}"
    found = parse_bearing(text).geometry
    assert found.balls == balls
    assert found.ball_diameter_m / found.pitch_diameter_m == pytest.approx(ratio, rel=1e-9)
    again = found.defect_orders()
    assert (again.outer_race, again.inner_race) == pytest.approx((orders.outer_race, orders.inner_race), rel=1e-9)
    assert (again.ball_spin, again.cage) == pytest.approx((orders.ball_spin, orders.cage), rel=1e-9)


def test_published_orders_of_the_6205() -> None:
    # SKF 6205-2RS JEM, Case Western Reserve University Bearing Data Center.
    orders = parse_bearing("DE=BPFO=3.5848,BPFI=5.4152,FTF=0.39828,BSF=2.3567@2").geometry.defect_orders()
    assert orders.outer_race == pytest.approx(3.5848, abs=1e-4)
    assert orders.ball_spin == pytest.approx(4.7135 / 2, rel=5e-3)
    bearing = parse_bearing("DE=BPFO=3.5848,BPFI=5.4152@2")
    assert (bearing.location, bearing.shaft_ratio, bearing.geometry.balls) == ("DE", 2.0, 9)


def test_bearing_by_name_and_dimensions() -> None:
    assert parse_bearing("6205").geometry == bearing_catalogue()["6205"]
    assert parse_bearing("FE=6203@1.5").location == "FE"
    geometry = parse_bearing("9, 7.94, 39.04, 15").geometry
    assert (geometry.ball_diameter_m, geometry.pitch_diameter_m) == pytest.approx((7.94e-3, 39.04e-3))
    assert math.degrees(geometry.contact_angle_rad) == pytest.approx(15)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "9999",
        "9,7.94",
        "9,39.04,7.94",
        "9.5,7,39",
        "a,b,c",
        "BPFO=5,BPFI=3",
        "BPFO=3.0,BPFI=4.6",
        "BPFO=3.05",
        "BPFO=x,BPFI=4",
        "BPFO=3.05,BPFI=4.95,FTF=0.45",
        "BPFO=3.05,BPFI=4.95,BSF=4.0",
        "6205@0",
        "6205@-1",
        "6205@x",
        "BPFO=85,BPFI=113,DF=1",
    ],
)
def test_bearing_texts_that_are_refused(text: str) -> None:
    with pytest.raises(InvalidValueError, match=r"[Bb]earing|[Rr]atio|diameter"):
        parse_bearing(text)


def test_gears() -> None:
    (pair,) = parse_gears("23")
    assert (pair.driver_teeth, pair.driven_teeth, pair.driver_ratio) == (23, None, 1.0)
    first, second = parse_gears("23/46@1.0, 31/62@0.5")
    assert first.driven_ratio == 0.5
    assert second.mesh_order == 15.5
    for text in ("", "23/", "a", "23/46/7", "23@0", "2/46"):
        with pytest.raises(InvalidValueError, match=r"[Gg]ear|ratio"):
            parse_gears(text)


def test_merging_fills_gaps_and_lets_the_upper_win() -> None:
    upper = Metadata(rate_hz=1000, units=("g",), skip=("b",))
    lower = Metadata(
        rate_hz=500,
        speed_rpm=1480,
        units=("V", "V"),
        skip=("a", "b"),
        channels=(ChannelMetadata(number=1, unit="V", name="DE"),),
    )
    merged = upper.merged_over(lower)
    assert (merged.rate_hz, merged.speed_rpm, merged.units, merged.skip) == (1000, 1480, ("g",), ("a", "b"))
    assert merged.channels == (ChannelMetadata(number=1, unit=None, name="DE"),)
    assert Metadata().merged_over(lower) == lower
    assert lower.merged_over(Metadata()) == lower


@pytest.mark.parametrize("field", ["rate_hz", "pulses_per_revolution", "line_frequency_hz", "power_kw"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_values_that_must_be_positive(field: str, value: float) -> None:
    with pytest.raises(InvalidValueError, match=field):
        Metadata(**{field: value})


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_sidecar_with_everything(tmp_path: Path) -> None:
    sidecar = write(
        tmp_path / "recording.toml",
        """
        [recording]
        rate_hz = 25600
        unit = "V"
        sensitivity = "100 mV/g"
        skip = [3]
        tacho = 4
        pulses_per_revolution = 2
        speed_rpm = 1480.0
        label = "healthy"
        [[channel]]
        match = "*_DE"
        direction = "vertical"
        [machine]
        name = "pump 3"
        mounting = "rigid"
        power_kw = 75
        [[machine.bearing]]
        designation = "6205"
        location = "DE"
        shaft_ratio = 0.5
        [[machine.bearing]]
        balls = 8
        ball_diameter_mm = 7.9375
        pitch_diameter_mm = 33.4772
        [[machine.gear]]
        driver_teeth = 23
        driven_teeth = 46
        [[file]]
        match = "18*.csv"
        speed_rpm = 1800
        """,
    )
    found = read_sidecar(sidecar, tmp_path / "1800_a.csv")
    assert (found.rate_hz, found.speed_rpm, found.label, found.units) == (25600, 1800, "healthy", ("V",))
    assert (found.skip, found.tacho, found.pulses_per_revolution) == (("3",), "4", 2)
    assert found.channels[0].direction == "vertical"
    assert found.nameplate.name == "pump 3"
    assert [(one.geometry.balls, one.shaft_ratio) for one in found.bearings] == [(9, 0.5), (8, 1.0)]
    assert found.gears[0].driven_ratio == 0.5
    assert read_sidecar(sidecar, tmp_path / "600.csv").speed_rpm == 1480
    assert read_sidecar(sidecar).speed_rpm == 1480


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("[recording]\nrate = 5", "'rate'.*rate_hz"),
        ("rate_hz = 5", "'rate_hz'.*recording"),
        ("[machine]\nteeth = 5", "'teeth'"),
        ("[[machine.bearing]]\nname = '6205'", "'name'.*designation"),
        ("[[machine.gear]]\ndriven_teeth = 5", "driver_teeth"),
        ("[[file]]\nspeed_rpm = 5", "match"),
        ("[file]\nspeed_rpm = 5", r"\[\[\.\.\.\]\]"),
        ("[recording]\nrate_hz = '5'", "a number"),
        ("[recording]\nrate_hz = true", "a number"),
        ("[recording]\nunits = 'g'", "list of texts"),
        ("[[channel]]\ndirection = 'up'", "vertical"),
        ("[recording]\nrate_hz = 0", "above 0"),
        ("recording = 5", r"\[recording\]"),
        ("machine = 5", r"\[machine\]"),
    ],
)
def test_sidecar_mistakes_are_named(tmp_path: Path, text: str, word: str) -> None:
    sidecar = write(tmp_path / "recording.toml", text)
    with pytest.raises(InvalidValueError, match=word):
        read_sidecar(sidecar, tmp_path / "a.csv")


def test_sidecar_that_is_no_toml(tmp_path: Path) -> None:
    with pytest.raises(UnreadableFileError, match="TOML"):
        read_sidecar(write(tmp_path / "recording.toml", "rate = = 5"))


def test_where_a_sidecar_is_looked_for(tmp_path: Path) -> None:
    data = tmp_path / "a.csv.gz"
    assert find_sidecar(data) is None
    folder = write(tmp_path / "recording.toml", "")
    assert find_sidecar(data) == folder
    own = write(tmp_path / "a.toml", "")
    assert find_sidecar(data) == own
    other = write(tmp_path / "other.toml", "")
    assert find_sidecar(data, other) == other
    with pytest.raises(UnreadableFileError, match="no such file"):
        find_sidecar(data, tmp_path / "none.toml")


def test_the_documented_sidecar_reads_and_has_every_key() -> None:
    path = Path(__file__).parents[2] / "docs" / "recording.toml"
    assert read_sidecar(path, Path("1800_a.csv")).speed_rpm == 1800
    words = set(re.findall(r"\w+", path.read_text()))
    for table in (sidecar_file._RECORDING, sidecar_file._CHANNEL, sidecar_file._MACHINE, sidecar_file._BEARING):
        assert set(table) <= words
    assert set(sidecar_file._GEAR) <= words


@pytest.mark.parametrize("sidecar", SIDECARS, ids=lambda path: path.stem)
def test_shipped_sidecars_read(sidecar: Path) -> None:
    assert read_sidecar(sidecar).name


def test_there_are_sidecars() -> None:
    assert len(SIDECARS) == 7

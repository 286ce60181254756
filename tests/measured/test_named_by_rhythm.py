"""Measured race defects are named by their rhythm against healthy records; other faults of the same rigs are not."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from rotorwise.diagnose.gap.campaign import find_sources, read_campaign
from rotorwise.diagnose.gap.envelope_lines import envelopes_of
from rotorwise.diagnose.gap.heard_rhythm import Heard, heard_rhythm
from rotorwise.diagnose.gap.observe import shaft_speed_rpm
from rotorwise.simulators.effects import BallDefect, CageDefect, InnerRaceDefect, OuterRaceDefect
from rotorwise.simulators.machine import Machine, find_machine

HERE = Path(__file__).resolve().parent
DATA = HERE.parents[2] / "shared" / "data"
BENCH, CWRU = DATA / "01_adi_limerick_mfs" / "data", DATA / "05_cwru_bearing" / "data"
EVERY = tuple(kind(at="bearing_a") for kind in (OuterRaceDefect, InnerRaceDefect, BallDefect, CageDefect))

pytestmark = [
    pytest.mark.measured,
    pytest.mark.skipif(not DATA.is_dir(), reason=f"measured recordings are not at {DATA}"),
]


def heard(machine: Machine, files: Sequence[Path], healthy: Sequence[Path], sidecar: Path, probes: Sequence[str]):
    """Return what the envelopes of recordings beat in, and did not in those of the healthy machine."""
    read = read_campaign(find_sources(files, baseline=healthy), machine, sidecar=sidecar, probes=probes).campaign
    speeds = [[shaft_speed_rpm(one) for one in each] for each in (read.recordings, read.baseline)]
    return heard_rhythm(EVERY, machine, envelopes_of(read.recordings, speeds[0], read.baseline, speeds[1]))


def name_of(found: Heard | None) -> str | None:
    return found.effect.NAME if found and found.is_sure else None


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("HOR_GS_BaLo_WA", "outer_race_defect"),
        ("HIR_GS_BaLo_WA", "inner_race_defect"),
        ("GoB_BS_BaLo_WA", None),
        ("GoB_GS_BaLo_MA", None),
        ("GoB_GS_VHIL_WA", None),
    ],
)
def test_races_of_the_bench(kind: str, name: str | None, tmp_path: Path) -> None:
    # Its sensitivity is not stated; a rhythm needs none.
    text = (HERE / "adi_limerick.toml").read_text(encoding="utf-8")
    sidecar = tmp_path / "recording.toml"
    sidecar.write_text(text.replace('unit = "V"', 'unit = "V"\nsensitivity = "20 mV/g"'), encoding="utf-8")
    files = [BENCH / f"1800_{one}_00lb.Wfm.csv" for one in (kind, "GoB_GS_BaLo_WA")]
    probes = ("X=housing_b_x", "Y=housing_b_y", "Z=housing_b_axial")
    machine = find_machine("test_rig").preset("adi")
    assert name_of(heard(machine, files[:1], files[1:], sidecar, probes)) == name


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("12k_Drive_End_IR007_0_105.mat", "inner_race_defect"),
        ("12k_Drive_End_OR007@6_0_130.mat", "outer_race_defect"),
        # Neither the ball's rhythm nor this outer race's is to be seen (the data set's CARD): no other is named for it.
        ("12k_Drive_End_B007_0_118.mat", None),
        ("12k_Drive_End_OR014@6_0_197.mat", None),
    ],
)
def test_races_of_cwru(file: str, name: str | None) -> None:
    values = {"bearing_balls": 9.0, "bearing_ball_diameter_m": 7.94e-3, "bearing_pitch_diameter_m": 39.04e-3}
    machine = find_machine("test_rig").preset("adi").with_parameters(**values)
    probes, healthy = ("DE=housing_a_y", "FE=housing_b_y"), [CWRU / "normal_0_97.mat"]
    assert name_of(heard(machine, [CWRU / file], healthy, HERE / "cwru.toml", probes)) == name

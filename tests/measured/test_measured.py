"""What must be seen on the measured recordings; the same cases make the table of tests/README.md."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest
from rotorwise.datasets.errors import MissingMetadataError
from rotorwise.diagnose import Analysis, analyse

_SPEC = importlib.util.spec_from_file_location("measured_cases", Path(__file__).with_name("cases.py"))
assert _SPEC is not None
assert _SPEC.loader is not None
measured = importlib.util.module_from_spec(_SPEC)
sys.modules["measured_cases"] = measured
_SPEC.loader.exec_module(measured)

pytestmark = [
    pytest.mark.measured,
    pytest.mark.skipif(not measured.DATA.is_dir(), reason=f"measured recordings are not at {measured.DATA}"),
]


@cache
def answer(file: str, sidecar: str, baseline: str | None, metadata) -> Analysis:
    return analyse(
        measured.DATA / file,
        metadata=metadata,
        sidecar=measured.HERE / f"{sidecar}.toml",
        baseline=[] if baseline is None else [measured.DATA / baseline],
    )


@pytest.mark.parametrize("case", measured.cases(), ids=lambda case: case.name)
def test_expected_is_seen(case) -> None:
    analysis = answer(case.file, case.sidecar, case.baseline, case.metadata)
    assert case.check(analysis), [(one.fault, round(one.probability, 3)) for one in analysis.findings]


@pytest.mark.parametrize("speed", measured.ADI_SPEEDS)
def test_1x_rises_with_the_imbalance_class(speed: str) -> None:
    healthy = measured.adi(speed)
    values = [answer(healthy, "adi_limerick", None, None).features["1x_amplitude"]]
    for load in measured.IMBALANCE:
        file = measured.adi(speed, load=load)
        values.append(answer(file, "adi_limerick", healthy, None).features["1x_amplitude"])
    assert all(low < high for low, high in pairwise(values)), values


def test_gearbox_without_a_rate_asks_for_it() -> None:
    path = measured.DATA / "08_gfs_gearbox_broken_tooth/data/b30hz0.csv.gz"
    with pytest.raises(MissingMetadataError, match="--rate"):
        analyse(path, sidecar=measured.HERE / "gfs_gearbox.toml")


def test_volts_without_sensitivity_give_no_severity() -> None:
    analysis = answer(measured.adi("1800"), "adi_limerick", None, None)
    assert not analysis.severity
    assert "--sensitivity" in analysis.severity_refusal


def test_re_mounted_sensor_is_told() -> None:
    healthy = measured.adi("1800")
    for file in (measured.adi("1800", alignment="MA"), measured.adi("1800", shaft="BS")):
        assert any("Re-mounted" in text for text in answer(file, "adi_limerick", healthy, None).warnings)
    same_assembly = answer(measured.adi("1800", load="HImL"), "adi_limerick", healthy, None)
    assert not any("Re-mounted" in text for text in same_assembly.warnings)


@pytest.mark.parametrize("kind", ["Inner", "Outer"])
@pytest.mark.parametrize("number", [1, 7])
def test_mfpt_envelope_lines_within_slip_of_theory(kind: str, number: int) -> None:
    analysis = answer(f"06_mfpt_bearing/data/{kind}RaceFault_vload_{number}.mat", "mfpt", None, None)
    label = "BPFI" if kind == "Inner" else "BPFO"
    line = next(line for line in analysis.findings[0].lines if line.name == f"1 x {label}")
    assert abs(line.order / line.expected_order - 1) < 0.015

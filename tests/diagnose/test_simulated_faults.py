"""Does `rotorwise analyse` find what `rotorwise simulate` put in? One row a fault, what it cannot tell included.

Every record is written, read and judged against the healthy record of the same machine, with the noise of a usual
accelerometer. A row passes when the fault is named first, or when it is one of a set that the first finding declares
indistinguishable, has its share of the probability, and the finding says which measurement tells them apart. A row with
``why`` is a known miss: it fails strictly, so that it is corrected when the rules get better, and names nothing wrong.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from rotorwise.datasets.simulated import record_machine
from rotorwise.datasets.write import write_recording
from rotorwise.diagnose.pipeline import analyse
from rotorwise.diagnose.result import Analysis
from rotorwise.diagnose.simulate_options import parse_chain, parse_effect, parse_machine

_HOUSINGS = tuple(f"housing_{name}_{axis}" for name in "ab" for axis in ("x", "y", "axial"))
_EVIDENT = 0.15
#: Rows with quicker ones of the kind beside them.
_SLOW = ("gearbox eccentricity", "gearbox wear", "gearbox pitting", "gearbox looseness")


@dataclass(frozen=True)
class Bench:
    machine: str
    preset: str
    speed_rpm: float
    seconds: float
    rate_hz: float
    settle_s: float
    probes: tuple[str, ...] = ()


RIG = Bench("test_rig", "adi", 1780.0, 4.0, 12_800.0, 2.0, _HOUSINGS)
SHORT_RIG = replace(RIG, seconds=3.0)
GEARBOX = Bench("gearbox", "plausible", 1800.0, 3.0, 12_800.0, 0.5, ("accelerometer", "bearing 1 x", "bearing 1 y"))
MAGNETIC = Bench("amb_rotor", "plausible", 3600.0, 6.0, 2048.0, 2.0)
HEAVY = Bench("rigid_coupling", "plausible", 1500.0, 6.0, 2048.0, 4.0)

FAST_HEAVY = replace(HEAVY, speed_rpm=3000.0)


@dataclass(frozen=True)
class Row:
    name: str
    bench: Bench
    effects: tuple[str, ...]
    truth: str | None
    why: str = ""


ROWS = (
    Row("rig healthy", RIG, (), None),
    Row("rig unbalance", RIG, ("unbalance@disc:moment_kg_m=1e-3",), "unbalance"),
    Row("rig outer race", RIG, ("outer_race_defect@bearing_a",), "bearing_outer_race"),
    Row("rig inner race", RIG, ("inner_race_defect@bearing_a",), "bearing_inner_race"),
    Row(
        "rig inner race, 3 s",
        SHORT_RIG,
        ("inner_race_defect@bearing_a",),
        "bearing_inner_race",
        "slip puts BPFI of an ER-12K on 5X, and 3 s do not part the two",
    ),
    Row("rig ball", RIG, ("ball_defect@bearing_a",), "bearing_ball"),
    Row("rig cage", RIG, ("cage_defect@bearing_a",), "bearing_cage", "its lines are below the noise of the sensor"),
    Row("rig misalignment", RIG, ("coupling_misalignment:offset_m=2e-3,angle_rad=0.04",), "misalignment"),
    Row("rig bow", RIG, ("shaft_bow:bow_m=3e-4",), "bent_shaft"),
    Row("rig looseness", RIG, ("looseness",), "looseness", "at 1780 rpm the foot does not lift off"),
    Row(
        "rig crack",
        RIG,
        ("breathing_crack",),
        "bent_shaft",
        "no rule names a crack; far from half the critical speed a shallow one makes no 2X either",
    ),
    Row("rig twice line", RIG, ("twice_line_force:force_n=500",), "electrical"),
    Row("rig faint twice line", RIG, ("twice_line_force",), "electrical", "its line is below the noise of the sensor"),
    Row("rig dropped samples", RIG, ("dropped_samples",), "sensor_fault"),
    Row("gearbox healthy", GEARBOX, (), None),
    Row("gearbox eccentricity", GEARBOX, ("gear_eccentricity@pinion",), "gear_eccentricity"),
    Row("gearbox wear", GEARBOX, ("wear",), "gear_wear"),
    Row("gearbox outer race", GEARBOX, ("outer_race_defect",), "bearing_outer_race"),
    Row("gearbox inner race", GEARBOX, ("inner_race_defect",), "bearing_inner_race"),
    Row("gearbox tooth crack", GEARBOX, ("tooth_crack",), "gear_tooth_fault"),
    Row("gearbox pitting", GEARBOX, ("pitting",), "gear_tooth_fault"),
    Row("gearbox looseness", GEARBOX, ("looseness:loss=0.95",), "looseness"),
    Row("magnetic healthy", MAGNETIC, (), None),
    Row("magnetic unbalance", MAGNETIC, ("unbalance@disc:moment_kg_m=2e-4",), "unbalance"),
    Row("magnetic misalignment", MAGNETIC, ("coupling_misalignment:offset_m=2e-4,angle_rad=0.01",), "misalignment"),
    Row("heavy healthy", HEAVY, (), None),
    Row("heavy looseness", HEAVY, ("looseness",), "looseness"),
    Row("heavy rub", HEAVY, ("rub",), "rub"),
    Row("heavy bolt loss", HEAVY, ("bolt_loss",), "misalignment"),
    Row("heavy oil whirl", FAST_HEAVY, ("oil_whirl:damping_n_s_m=900,mass_kg=50",), "oil_whirl"),
    Row("heavy slow oil film", HEAVY, ("oil_whirl",), "oil_whirl", "1500 rpm is below the onset: no line is there"),
)


Record = Callable[[Bench, tuple[str, ...], int], Path]


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Record:
    folder = tmp_path_factory.mktemp("records")
    made: dict[tuple[str, tuple[str, ...]], Path] = {}
    chain = parse_chain("accelerometer:noise.m/s2=2e-3,noise.m=1e-9", pulses_per_revolution=1)

    def recorded(bench: Bench, effects: tuple[str, ...], seed: int) -> Path:
        key = f"{bench.machine}-{bench.speed_rpm}-{bench.seconds}-{seed}", effects
        if key not in made:
            machine = parse_machine(bench.machine, preset=bench.preset, settings=(), load=None)
            result = record_machine(
                machine.with_effects(*(parse_effect(text) for text in effects)),
                speed_rpm=bench.speed_rpm,
                duration_s=bench.seconds,
                rate_hz=bench.rate_hz,
                settle_s=bench.settle_s,
                chain=chain,
                seed=seed,
                probes=bench.probes,
            )
            made[key] = write_recording(result.recording, folder / f"{len(made)}.npz").path
        return made[key]

    return recorded


def _marked(row: Row) -> object:
    marks = [pytest.mark.xfail(strict=True, raises=AssertionError, reason=row.why)] if row.why else []
    marks += [pytest.mark.slow] if row.name in _SLOW else []
    return pytest.param(row, id=row.name, marks=marks)


def _judged(row: Row, record: Record) -> Analysis:
    analysis = analyse(record(row.bench, row.effects, 1), baseline=[record(row.bench, (), 2)])
    assert analysis.speed is not None
    if analysis.speed.speed_hz != pytest.approx(row.bench.speed_rpm / 60, rel=2e-3):
        raise ValueError(f"{row.name}: speed {analysis.speed.speed_hz} Hz")  # never a known miss
    return analysis


@pytest.mark.parametrize("row", [_marked(row) for row in ROWS])
def test_analyse_against_the_healthy_record(row: Row, record: Record) -> None:
    findings = _judged(row, record).findings
    said = [(one.fault, round(one.probability, 2)) for one in findings]
    if row.truth is None:
        assert all(one.probability < _EVIDENT for one in findings), said
        return
    assert findings, "nothing evident"
    first = findings[0]
    assert first.probability >= _EVIDENT, said
    if first.fault != row.truth:
        mine = next((one for one in findings if one.fault == row.truth), None)
        assert mine is not None, said
        assert row.truth in first.rivals
        assert first.fault in mine.rivals
        alike = [one.probability for one in findings if one.fault in (first.fault, *first.rivals)]
        assert sum(alike) <= 1.0, said  # they share one probability: the record says that one of them is there
        assert any(word in first.check for word in ("two other speeds", "in speed")), first.check


@pytest.mark.parametrize("row", [row for row in ROWS if row.why], ids=[row.name for row in ROWS if row.why])
def test_what_is_missed_is_not_called_something_else(row: Row, record: Record) -> None:
    findings = _judged(row, record).findings
    assert all(one.probability < 0.5 for one in findings if one.fault != row.truth)


def test_a_bearing_fault_of_the_rig_needs_no_baseline(record: Record) -> None:
    found = analyse(record(RIG, ("outer_race_defect@bearing_a",), 1)).findings
    assert found[0].fault == "bearing_outer_race"
    assert found[0].probability > 0.9
    assert analyse(record(RIG, (), 1)).findings == ()


def test_a_sound_bearing_that_modulates_the_mesh_is_no_defect(record: Record) -> None:
    """The mesh passes through bearings whose stiffness changes from ball to ball; a pit of its race still is one."""
    healthy = analyse(record(GEARBOX, (), 1)).findings
    assert all(one.probability < 0.5 for one in healthy)
    damaged = analyse(record(GEARBOX, ("outer_race_defect",), 1)).findings
    assert damaged[0].fault == "bearing_outer_race"
    assert damaged[0].probability > 0.9


@pytest.mark.parametrize(
    ("speed_rpm", "load"),
    [
        (1200.0, 45.0),
        pytest.param(1500.0, 45.0, marks=pytest.mark.slow),
        pytest.param(1800.0, 80.0, marks=pytest.mark.slow),
        (2400.0, 80.0),
    ],
)
def test_sound_bearings_of_a_gearbox_are_no_defect_at_any_probe(speed_rpm: float, load: float, tmp_path: Path) -> None:
    """All probes, no baseline: displacement and the direction across the tooth force are modulated by sound balls."""
    result = record_machine(
        parse_machine("gearbox", preset="plausible", settings=(), load=load),
        speed_rpm=speed_rpm,
        duration_s=3.0,
        rate_hz=12_800.0,
        settle_s=0.5,
        chain=parse_chain("accelerometer:noise.m/s2=3e-3", pulses_per_revolution=1),
        seed=4,
    )
    findings = analyse(write_recording(result.recording, tmp_path / "sound.npz").path).findings
    assert all(one.probability < 0.5 for one in findings), [(one.fault, one.probability) for one in findings]

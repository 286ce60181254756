"""Does `rotorwise analyse` find what `rotorwise simulate` put in? One row a fault, what it cannot tell included.

Every record is written, read and judged against the healthy record of the same machine, with the noise of a usual
accelerometer. ``answer`` is the first finding above 15 %, None for "nothing evident". Where it differs from ``truth``,
``why`` says so; such a row is a known limit, and fails when the rules get better, so that it is then corrected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from rotorwise.datasets.simulated import record_machine
from rotorwise.datasets.write import write_recording
from rotorwise.diagnose.pipeline import analyse
from rotorwise.diagnose.simulate_options import parse_chain, parse_effect, parse_machine

_HOUSINGS = tuple(f"housing_{name}_{axis}" for name in "ab" for axis in ("x", "y", "axial"))
_EVIDENT = 0.15


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


@dataclass(frozen=True)
class Row:
    name: str
    bench: Bench
    effects: tuple[str, ...]
    truth: str | None
    answer: str | None
    why: str = ""


ROWS = (
    Row("rig healthy", RIG, (), None, None),
    Row("rig unbalance", RIG, ("unbalance@disc:moment_kg_m=1e-3",), "unbalance", "unbalance"),
    Row("rig outer race", RIG, ("outer_race_defect@bearing_a",), "bearing_outer_race", "bearing_outer_race"),
    Row("rig inner race", RIG, ("inner_race_defect@bearing_a",), "bearing_inner_race", "bearing_inner_race"),
    Row(
        "rig inner race, 3 s",
        SHORT_RIG,
        ("inner_race_defect@bearing_a",),
        "bearing_inner_race",
        "bearing_ball",
        "BPFI - 1X of an ER-12K lies 0.01 X from 2 BSF, and slip moves both",
    ),
    Row("rig ball", RIG, ("ball_defect@bearing_a",), "bearing_ball", "bearing_ball"),
    Row("rig cage", RIG, ("cage_defect@bearing_a",), "bearing_cage", None, "a cage wobbles, it does not strike"),
    Row(
        "rig misalignment",
        RIG,
        ("coupling_misalignment:offset_m=1e-3,angle_rad=0.02",),
        "misalignment",
        "unbalance",
        "a linear coupling makes 1X only, which rises as of an unbalance",
    ),
    Row(
        "rig bow",
        RIG,
        ("shaft_bow",),
        "bent_shaft",
        "unbalance",
        "1X only, at one speed; bent_shaft is named as a rival",
    ),
    Row("rig looseness", RIG, ("looseness",), "looseness", None, "at 1780 rpm the foot does not lift off"),
    Row("rig crack", RIG, ("breathing_crack",), "bent_shaft", None, "2X of a shallow crack far from half critical"),
    Row("rig twice line", RIG, ("twice_line_force",), "electrical", None, "a small share of the velocity"),
    Row("rig dropped samples", RIG, ("dropped_samples",), "sensor_fault", "sensor_fault"),
    Row("gearbox healthy", GEARBOX, (), None, None),
    Row("gearbox eccentricity", GEARBOX, ("gear_eccentricity@pinion",), "gear_eccentricity", "gear_eccentricity"),
    Row("gearbox wear", GEARBOX, ("wear",), "gear_wear", "gear_wear"),
    Row("gearbox outer race", GEARBOX, ("outer_race_defect",), "bearing_outer_race", "bearing_outer_race"),
    Row("gearbox inner race", GEARBOX, ("inner_race_defect",), "bearing_inner_race", "bearing_inner_race"),
    Row(
        "gearbox tooth crack",
        GEARBOX,
        ("tooth_crack",),
        "gear_tooth_fault",
        "gear_eccentricity",
        "first sidebands rise more than the wide ones; the tooth fault comes second",
    ),
    Row("gearbox pitting", GEARBOX, ("pitting",), "gear_tooth_fault", "gear_eccentricity", "as for the crack"),
    Row("gearbox looseness", GEARBOX, ("looseness",), "looseness", "gear_wear", "it raises the mesh lines most"),
    Row("magnetic healthy", MAGNETIC, (), None, None),
    Row("magnetic unbalance", MAGNETIC, ("unbalance@disc:moment_kg_m=2e-4",), "unbalance", "unbalance"),
    Row(
        "magnetic misalignment",
        MAGNETIC,
        ("coupling_misalignment:offset_m=2e-4,angle_rad=0.01",),
        "misalignment",
        "unbalance",
        "1X rises more than 2X and 3X",
    ),
    Row("heavy healthy", HEAVY, (), None, None),
    Row("heavy looseness", HEAVY, ("looseness",), "looseness", "looseness"),
    Row("heavy rub", HEAVY, ("rub",), "rub", "misalignment", "a light rub makes 2X and 3X before any fraction"),
    Row("heavy bolt loss", HEAVY, ("bolt_loss",), "misalignment", "misalignment"),
    Row("heavy oil whirl", HEAVY, ("oil_whirl",), "oil_whirl", None, "1500 rpm is below the onset"),
)


Record = Callable[[Bench, tuple[str, ...], int], Path]


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Record:
    folder = tmp_path_factory.mktemp("records")
    made: dict[tuple[str, tuple[str, ...]], Path] = {}
    chain = parse_chain("accelerometer:noise.m/s2=2e-3,noise.m=1e-9", pulses_per_revolution=1)

    def recorded(bench: Bench, effects: tuple[str, ...], seed: int) -> Path:
        key = f"{bench.machine}-{bench.seconds}-{seed}", effects
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


@pytest.mark.parametrize("row", ROWS, ids=[row.name for row in ROWS])
def test_analyse_against_the_healthy_record(row: Row, record: Record) -> None:
    analysis = analyse(record(row.bench, row.effects, 1), baseline=[record(row.bench, (), 2)])
    assert analysis.speed is not None
    assert analysis.speed.speed_hz == pytest.approx(row.bench.speed_rpm / 60, rel=2e-3)
    evident = [one for one in analysis.findings if one.probability >= _EVIDENT]
    said = [(one.fault, round(one.probability, 2)) for one in analysis.findings]
    assert (evident[0].fault if evident else None) == row.answer, said
    if "rival" in row.why:
        assert row.truth in evident[0].rivals


@pytest.mark.parametrize("row", ROWS, ids=[row.name for row in ROWS])
def test_every_row_that_misses_says_why(row: Row) -> None:
    assert (row.answer == row.truth) == (row.why == "")


def test_a_bearing_fault_of_the_rig_needs_no_baseline(record: Record) -> None:
    found = analyse(record(RIG, ("outer_race_defect@bearing_a",), 1)).findings
    assert found[0].fault == "bearing_outer_race"
    assert found[0].probability > 0.9
    assert analyse(record(RIG, (), 1)).findings == ()

"""What a sound gearbox has and its model lacks, told by its healthy lines: run-out of a gear, an error of its teeth."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.model_form import Extended, extended
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.pulse_place import placed_at
from rotorwise.simulators import gearbox
from rotorwise.simulators.effects.empirical_mesh import EmpiricalMesh
from rotorwise.simulators.effects.residual_gear_run_out import ResidualGearRunOut

ORDERS = (1.0, 23.0, 46.0)
KINDS = (LineKind(), LineKind(phase=False), LineKind(phase=False))
PROBES = ("pinion torsional velocity", "accelerometer")
CONDITIONS = (Condition(1700.0, 30.0), Condition(2100.0, 30.0))
RUN_OUT_M = (-1e-6, 3e-6)
#: Gauge and accelerometer: next to nothing, and a size of a line as it repeats.
NOISE, REPEATED = np.array([2e-5, 2e-3])[:, None], 0.1


@pytest.fixture(scope="module")
def found() -> Extended:
    teeth = dict.fromkeys(("first_sine_m", "first_cosine_m", "second_sine_m", "third_sine_m", "third_cosine_m"), 0.0)
    real = gearbox.with_effects(
        ResidualGearRunOut(at="pinion", sine_m=RUN_OUT_M[0], cosine_m=RUN_OUT_M[1]),
        EmpiricalMesh(at="pinion", **teeth, second_cosine_m=6e-7),
    )
    predictor = Predictor(CONDITIONS, PROBES, ORDERS, (12_800.0,) * 2, (3200,) * 2, KINDS, (0,) * 3)
    lines = predictor.amplitudes(real)
    generator = np.random.default_rng(3)
    noise = NOISE * (generator.normal(size=lines.shape) + 1j * generator.normal(size=lines.shape))
    phase = np.array([kind.phase for kind in KINDS])
    seen = np.where(phase, lines + noise, np.abs(lines) + noise.real)
    deviations = np.hypot(NOISE, np.where(phase, 0.0, REPEATED * np.abs(lines)))
    healthy = OrderLines(CONDITIONS, PROBES, ORDERS, seen, deviations, KINDS)
    placed = placed_at(0.0, gearbox, (), healthy, predictor)
    return extended(placed, healthy, predictor, reference_rpm=2200.0)


@pytest.mark.slow
def test_run_out_of_the_pinion_is_found_by_its_twist(found: Extended) -> None:
    own = {(e.NAME, e.at): e.values() for e in found.at_healthy.machine.effects}["residual_gear_run_out", "pinion"]
    assert (own["sine_m"], own["cosine_m"]) == pytest.approx(RUN_OUT_M, abs=3e-7)


@pytest.mark.slow
def test_the_machine_s_own_parameters_are_not_bent_for_it(found: Extended) -> None:
    own = len(found.at_healthy.coordinates) - len(found.added)
    moved = (found.at_healthy.position - found.at_healthy.given)[:own]
    assert np.abs(moved).max() < 1.0
    assert found.missed < 0.5 * found.missed_before

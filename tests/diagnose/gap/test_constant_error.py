"""What a model misses alike in all conditions: told from an error that changes, and no cover for a fault."""

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.constant_error import SHARES, with_constant_parts
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.lines import Condition
from rotorwise.diagnose.gap.model_error import REFERENCE_RPM, ModelError, error_blocks, similarity
from rotorwise.simulators.effect import make_effect
from rotorwise.simulators.machine import find_machine

from .made_campaigns import altered, recorded

SPEEDS = (1100.0, 1500.0, 2100.0, 2900.0, 3900.0)
CONDITIONS = tuple(Condition(speed) for speed in SPEEDS)
NOISE = 0.01


def _chosen(left: np.ndarray, parts: int = 2, conditions: tuple[Condition, ...] = CONDITIONS) -> ModelError:
    """What is chosen of one line at one probe."""
    shape = (len(conditions), 1, 1)
    speeds = np.array([one.speed_rpm for one in conditions]) / REFERENCE_RPM
    sizes = [np.sqrt(np.mean(np.abs(left / speeds**power) ** 2) / 2) for power in range(3)]
    grown = [ModelError(np.full((1, 1), size), np.full((1, 1), float(power))) for power, size in enumerate(sizes)]
    noise = np.full(shape, NOISE**2)
    return with_constant_parts(grown[1], grown, conditions, left.reshape(shape), noise, np.array([parts]))


def _noise(seed: int, count: int = len(SPEEDS)) -> np.ndarray:
    random = np.random.default_rng(seed)
    return NOISE * (random.normal(size=count) + 1j * random.normal(size=count))


@pytest.mark.parametrize("power", [0, 2])
def test_what_keeps_size_and_direction_is_constant_by_its_own_law(power: int) -> None:
    left = 3.0 * np.exp(0.7j) * (np.array(SPEEDS) / REFERENCE_RPM) ** power
    found = _chosen(left + _noise(1))
    assert found.common == pytest.approx(np.full((1, 1), SHARES[-1]))
    assert found.growth.item() == power
    assert found.deviation.item() == pytest.approx(3.0 / np.sqrt(2), rel=0.05)


@pytest.mark.parametrize("seed", range(6))
def test_an_error_that_changes_smoothly_is_not_constant(seed: int) -> None:
    random = np.random.default_rng(seed)
    root = np.linalg.cholesky(similarity(CONDITIONS) + 1e-9 * np.eye(len(SPEEDS)))
    left = root @ (random.normal(size=len(SPEEDS)) + 1j * random.normal(size=len(SPEEDS)))
    found = _chosen(left + _noise(seed))
    assert found.common == pytest.approx(np.zeros((1, 1)))
    assert found.growth.item() == 1


def test_sizes_two_conditions_and_what_noise_hides_tell_no_constant_part() -> None:
    constant = np.full(len(SPEEDS), 3.0 + 1j)
    assert not np.any(_chosen(np.abs(constant) + _noise(2), parts=1).common)
    assert not np.any(_chosen(constant[:2] + _noise(2, 2), conditions=CONDITIONS[:2]).common)
    assert not np.any(_chosen(_noise(3)).common)


def test_the_constant_part_is_known_in_a_condition_far_from_all_healthy_ones() -> None:
    error = ModelError(np.ones((1, 2)), np.zeros((1, 2)), common=np.array([[0.0, 0.999]]))
    far = Condition(20.0 * SPEEDS[-1])
    changing, constant = error_blocks((*CONDITIONS, far), error)[0]
    for blocks, left_open in ((changing, 1.0), (constant, 0.001)):
        known, across = blocks[:-1, :-1] + 1e-9 * np.eye(len(SPEEDS)), blocks[-1, :-1]
        assert blocks[-1, -1] - across @ np.linalg.solve(known, across) == pytest.approx(left_open, rel=0.5)


def test_an_unbalance_as_small_as_the_run_out_is_named() -> None:
    """The probes' tracks are off by 6 um, the unbalance moves the shaft by 2 to 4."""
    rotor = find_machine("amb_rotor")
    tracks = [make_effect("run_out", {"harmonic_1_m": 6e-6, "angle_1_rad": 0.4 * n}, at=f"bearing_{n}") for n in (1, 2)]
    healthy = altered(rotor, share=0.5, seed=1).with_effects(*tracks)
    faulty = healthy.with_effects(make_effect("unbalance", {"moment_kg_m": 5e-5, "angle_rad": 1.0}, at="disc"))
    options = {"rate_hz": 3000.0, "duration_s": 2.0}
    campaign = Campaign(
        recorded(faulty, (1300.0, 1600.0, 2100.0, 2800.0, 3600.0), seed=60, **options),
        recorded(healthy, (1150.0, 1750.0, 2500.0, 3300.0), seed=10, **options),
    )
    others = {"unbalance", "shaft_bow", "coupling_misalignment", "rotating_coupling_force", "run_out"}
    answer = explain_gap(campaign, rotor, only=frozenset(others))
    assert [(one.effect, one.at) for one in answer.causes] == [("unbalance", "disc")]
    assert answer.causes[0].probability > 0.9
    assert answer.causes[0].parameters["moment_kg_m"].value == pytest.approx(5e-5, rel=0.15)

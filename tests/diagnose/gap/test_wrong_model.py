"""A model that is wrong is no cause, a cause must be named beside something unknown, and not invented.

That wrong supports hide no cause: `test_model_form.py`.

What nobody can model is put into the recordings: supports that are softer, cross-coupled and change with speed; lines
of random size and phase.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign, Recording
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.lines import Condition
from rotorwise.diagnose.gap.transfer_error import TransferError
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.assembly import Assembly
from rotorwise.simulators.effect import Effect, Line
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import Machine
from rotorwise.simulators.parameter import parameter

from .made_campaigns import altered, recorded

SPEEDS_RPM = (1300.0, 1900.0, 2600.0, 3300.0, 3900.0)
HOW = {"rate_hz": 2048.0, "duration_s": 3.0}
HIDDEN = Unbalance(at="disc", moment_kg_m=2e-4, angle_rad=0.5)
COMPETING = frozenset(("unbalance", "shaft_bow", "coupling_misalignment", "run_out", "remounted_sensor"))


# ---- theory ----


def test_directions_have_the_covariance_that_is_meant() -> None:
    generator = np.random.default_rng(2)
    response = generator.normal(size=(3, 2, 1)) + 1j * generator.normal(size=(3, 2, 1))
    response[:, 1] *= 1e-3
    conditions = tuple(Condition(speed) for speed in (1000.0, 1100.0, 3000.0))
    share = np.array([[0.3], [0.2]])
    alone, places = TransferError(share, np.eye(2, dtype=bool)).directions(response, conditions)
    assert places.tolist() == [[0, 0], [1, 0]]
    distance = np.log([1.0, 1.1, 3.0])[:, None] - np.log([1.0, 1.1, 3.0])[None, :]
    alike = np.exp(-0.5 * (distance / 0.2) ** 2)
    for probe in (0, 1):
        own = alone[probe]
        wanted = share[probe, 0] ** 2 * alike * np.outer(response[:, probe, 0], response[:, probe, 0].conj())
        np.testing.assert_allclose(own.T @ own.conj(), wanted, rtol=5e-3, atol=5e-3 * np.abs(wanted).max())
    # Two probes at one place: what hardly moves may be as wrong as what moves.
    both, _ = TransferError(share, np.ones((2, 2), dtype=bool)).directions(response, conditions)
    own = both[1]
    np.testing.assert_allclose(np.diag(own.T @ own.conj()).real, 0.2**2 * np.abs(response[:, 0, 0]) ** 2, rtol=5e-3)


def test_a_small_share_adds_nothing() -> None:
    error = TransferError(np.full((1, 1), 0.005), np.eye(1, dtype=bool))
    found, places = error.directions(np.ones((2, 1, 1), dtype=complex), (Condition(600.0), Condition(900.0)))
    assert found.size == places.size == 0


# ---- a machine that is not the model ----


@dataclass(frozen=True, kw_only=True)
class OtherSupports(Effect):
    """Springs at the bearings that are unlike in x and y and coupled, which no effect of the catalogue is."""

    NAME = "other_supports"
    STAGE = "structure"
    ROLE = "rotor"
    MEANING = "supports that are not those of the model"
    CHECK = "none"
    RIVALS: ClassVar = {}
    REFERENCES = ("made up",)

    stiffness_n_m: float = parameter(
        unit="N/m", bounds=(-1e6, 1e6), default=0.0, zero=0.0, meaning="added stiffness", source="made up"
    )

    def contribute(self, assembly: Assembly) -> None:
        for name in ("bearing_1", "bearing_2"):
            x, y = (assembly.places[name].directions[way] for way in ("x", "y"))
            assembly.add_spring(x, stiffness=self.stiffness_n_m)
            assembly.add_spring(y, stiffness=-0.5 * self.stiffness_n_m)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        return ()


def _other(machine: Machine, rpm: float) -> Machine:
    middle = float(np.mean(SPEEDS_RPM))
    return machine.with_effects(OtherSupports(stiffness_n_m=6e4 * (1 + 0.5 * (rpm - middle) / middle)))


def _measured(real: Machine, *, seed: int) -> tuple[Recording, ...]:
    return tuple(recorded(_other(real, rpm), (rpm,), seed=seed + i, **HOW)[0] for i, rpm in enumerate(SPEEDS_RPM))


@pytest.fixture(scope="module")
def real() -> Machine:
    return altered(amb_rotor, share=0.03, seed=3)


@pytest.fixture(scope="module")
def healthy(real: Machine) -> tuple[Recording, ...]:
    return _measured(real, seed=1)


@pytest.mark.slow
def test_supports_that_are_wrong_are_not_a_cause(real: Machine, healthy: tuple[Recording, ...]) -> None:
    assert explain_gap(Campaign(_measured(real, seed=61), healthy), amb_rotor, only=COMPETING).kind == "none"


# ---- something unknown beside a cause ----


def _with_random_lines(recordings: tuple[Recording, ...], *, seed: int) -> tuple[Recording, ...]:
    """2X and 3X of random phase in every recording, which no effect makes."""
    generator = np.random.default_rng(seed)
    found = []
    for one in recordings:
        signals = one.signals.copy()
        turn = 2 * np.pi * one.condition.speed_rpm / 60 * np.arange(one.samples) / one.rate_hz
        for row, channel in enumerate(one.channels):
            if channel.quantity == "tacho":
                continue
            for order in (2, 3):
                phase, size = generator.uniform(0, 2 * np.pi), 2e-5 * generator.uniform(0.5, 1.5)
                signals[row] += size * np.cos(order * turn + phase)
        found.append(replace(one, signals=signals))
    return tuple(found)


@pytest.fixture(scope="module")
def sound(real: Machine) -> tuple[Recording, ...]:
    return recorded(real, SPEEDS_RPM, seed=81, **HOW)


@pytest.mark.slow
def test_a_cause_is_named_beside_something_unknown(real: Machine, sound: tuple[Recording, ...]) -> None:
    faulty = _with_random_lines(recorded(real.with_effects(HIDDEN), SPEEDS_RPM, seed=91, **HOW), seed=5)
    answer = explain_gap(Campaign(faulty, sound), amb_rotor, only=COMPETING)
    assert answer.kind == "unknown"
    (cause,) = answer.causes
    assert (cause.effect, cause.at) == ("unbalance", "disc")
    assert cause.probability > 0.9
    moment = cause.parameters["moment_kg_m"]
    assert moment.low < HIDDEN.moment_kg_m < moment.high


@pytest.mark.slow
def test_no_cause_is_invented_for_what_is_unknown(real: Machine, sound: tuple[Recording, ...]) -> None:
    faulty = _with_random_lines(recorded(real, SPEEDS_RPM, seed=101, **HOW), seed=6)
    answer = explain_gap(Campaign(faulty, sound), amb_rotor, only=COMPETING)
    assert answer.kind == "unknown"
    assert not answer.causes
    # Nothing is added: the machine that is written is the calibrated one, and so is its gain.
    assert not answer.empirical
    assert answer.gain.held_out_db == pytest.approx(answer.gain.calibration_only_db)

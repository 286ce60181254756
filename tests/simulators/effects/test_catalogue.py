"""What the declarations of the whole catalogue have in common: rivals that exist, growth with speed and load said."""

import re
from pathlib import Path

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import machine_catalogue

EFFECTS, MACHINES = effect_catalogue(), machine_catalogue()
effects = pytest.mark.parametrize("name", EFFECTS)


@effects
def test_rivals_are_other_effects_of_the_catalogue(name):
    rivals = EFFECTS[name].RIVALS
    assert rivals
    assert set(rivals) <= set(EFFECTS) - {name}
    # A measurement, not a word.
    assert all(len(separates.split()) >= 2 for separates in rivals.values())


def lines_of(effect):
    for machine in MACHINES.values():
        try:
            effect().contribute(machine.bare_assembly())
        except MissingPartError:
            continue
        yield from effect().signature(machine)


@effects
@pytest.mark.parametrize(
    ("exponent", "words"), [("speed_exponent", r"\bspeed"), ("load_exponent", r"\b(load|loads|loaded|weight)\b")]
)
def test_growth_with_speed_and_load_is_a_law_or_said_in_words(name, exponent, words):
    effect = EFFECTS[name]
    lines = list(lines_of(effect))
    by_law = bool(lines) and all(getattr(line, exponent) is not None for line in lines)
    assert by_law or re.search(words, effect.__doc__ or "", re.IGNORECASE), (
        f"{name} does not say how it goes with {words}"
    )


def added_forces(effect, machine):
    """Return what the effect pushes with, if nothing that it adds depends on the motion; else nothing."""
    before = {force.name for force in machine.assembly(speed_rpm=1800).forces}
    added = [f for f in machine.with_effects(effect).assembly(speed_rpm=1800).forces if f.name not in before]
    free = all(f.law.is_linear and not (f.displacements or f.velocities) for f in added)
    return added if free else []


def size_at(force, speed_rad_s):
    phase = np.linspace(0, 200 * np.pi, 20_001)[:, None]
    timeline = Timeline(phase / 97.0, phase, np.full_like(phase, speed_rad_s), np.zeros_like(phase))
    return np.sqrt(np.mean(force.law.signals(timeline, np.array(force.parameters)[:, None]) ** 2))


@pytest.mark.parametrize(
    ("name", "machine"),
    [
        ("unbalance", "test_rig"),
        ("unbalance", "gearbox"),
        ("rotating_coupling_force", "amb_rotor"),
        ("shaft_bow", "test_rig"),
        ("torque_ripple", "rigid_coupling"),
        ("load_fluctuation", "gearbox"),
        ("twice_line_force", "gearbox"),
        ("pole_pass", "test_rig"),
        ("gravity", "amb_rotor"),
    ],
)
def test_declared_growth_with_speed_is_that_of_the_force(name, machine):
    made = EFFECTS[name]()
    forces = added_forces(made, MACHINES[machine])
    assert forces
    exponents = {line.speed_exponent for line in made.signature(MACHINES[machine])} - {None}
    expected = exponents.pop() if exponents else 0.0
    assert not exponents
    for force in forces:
        assert size_at(force, 200.0) / size_at(force, 100.0) == pytest.approx(2.0**expected, rel=1e-12)


@effects
def test_every_effect_has_a_test_of_its_own(name):
    assert (Path(__file__).parent / f"test_{name}.py").exists()


@effects
def test_priors_say_where_they_come_from(name):
    for p in EFFECTS[name].parameters():
        assert p.unit or "rad" not in p.name, p.name
        assert len(p.source.split()) >= 2, p.name
        assert p.bounds[0] < p.bounds[1], p.name

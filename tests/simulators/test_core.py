"""Parameters, speed profiles, assembly and machines as text."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise import simulators
from rotorwise.simulators.assembly import Assembly, MissingPartError, Place, Probe, combination, difference
from rotorwise.simulators.effect import effect_catalogue, make_effect
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine, machine_catalogue, machine_from_toml
from rotorwise.simulators.parameter import LogNormal, Normal, Parameter, Uniform, parameter
from rotorwise.simulators.speed_profile import SpeedProfile, ramp, steady
from rotorwise.simulators.system import build_system
from scipy.integrate import quad

MACHINES = machine_catalogue()


@pytest.mark.parametrize("prior", [Uniform(-1.0, 3.0), Normal(2.0, 0.5), LogNormal(1e-3, 3.0)])
def test_priors_are_densities_with_the_median_that_they_state(prior):
    low, high = (prior.low, prior.high) if isinstance(prior, Uniform) else (-50.0, 50.0)
    if isinstance(prior, LogNormal):
        mass = quad(lambda z: math.exp(prior.log_density(math.exp(z)) + z), -25, 10)[0]
    else:
        mass = quad(lambda x: math.exp(prior.log_density(x)), low, high, points=[2.0], limit=200)[0]
    assert mass == pytest.approx(1.0, abs=1e-6)
    draws = [prior.sample(np.random.default_rng(seed)) for seed in range(4000)]
    assert np.mean(np.array(draws) < prior.median) == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("value", ["much", None, float("nan"), 11.0, -0.1, True])
def test_a_value_that_is_not_allowed_is_refused_with_the_range(value):
    declared = Parameter("gap_m", "m", 1.0, (0.0, 10.0), "a gap", "test")
    with pytest.raises(InvalidValueError, match=r"gap_m = .*allowed: 0 to 10 m"):
        declared.checked(value)


def test_declarations_are_checked_themselves():
    with pytest.raises(InvalidValueError, match="default"):
        Parameter("x", "", 2.0, (0.0, 1.0), "", "")
    with pytest.raises(InvalidValueError, match="neither a default nor a prior"):
        parameter(unit="", bounds=(0, 1), meaning="", source="")


@given(
    st.lists(st.floats(0.1, 10.0), min_size=2, max_size=6),
    st.lists(st.floats(1.0, 500.0), min_size=6, max_size=6),
    st.floats(-2.0, 40.0),
)
def test_phase_is_the_integral_of_speed(gaps, speeds, time):
    times = np.cumsum(gaps)
    profile = SpeedProfile(tuple(times), tuple(speeds[: times.size]))
    step = 1e-5
    slope = (profile.phase_rad(np.array(time + step)) - profile.phase_rad(np.array(time - step))) / (2 * step)
    assert slope == pytest.approx(profile.speed_rad_s(np.array(time)), abs=step * 5000)
    assert profile.phase_rad(np.array(times[0])) == 0.0


def test_ramp_has_its_speeds_and_turns():
    profile = ramp(start_rpm=600, stop_rpm=1200, duration_s=10)
    assert profile.phase_rad(np.array(10.0)) == pytest.approx(2 * np.pi * 150)
    assert profile.acceleration_rad_s2(np.array(5.0)) == pytest.approx(2 * np.pi)
    assert profile.acceleration_rad_s2(np.array([-1.0, 11.0])) == pytest.approx([0, 0])
    assert not profile.is_steady
    assert steady(speed_rpm=60.0).speeds_rad_s == pytest.approx((2 * np.pi,))


@pytest.mark.parametrize(
    ("times", "speeds"), [((), ()), ((0.0, 0.0), (1.0, 2.0)), ((0.0,), (1.0, 2.0)), ((0.0, 1.0), (1.0, math.inf))]
)
def test_bad_profiles_are_refused(times, speeds):
    with pytest.raises(InvalidValueError, match="allowed"):
        SpeedProfile(times, speeds)


def two_masses():
    assembly = Assembly(speed_rad_s=0.0)
    for name in ("a", "b"):
        assembly.add_coordinate(name, mass=2.0)
    assembly.add_spring({"a": 1.0}, stiffness=8.0)
    assembly.add_spring({"a": 1.0, "b": -1.0}, stiffness=3.0, damping=0.5)
    return assembly


def test_springs_are_where_they_were_put():
    core = build_system(two_masses()).core
    assert core[2:, :2] == pytest.approx(np.array([[-5.5, 1.5], [1.5, -1.5]]))
    assert core[2:, 2:] == pytest.approx(np.array([[-0.25, 0.25], [0.25, -0.25]]))
    assert core[:2, 2:] == pytest.approx(np.eye(2))


def test_directions_combine():
    assert difference({"a": 1.0}, {"a": 0.5, "b": 2.0}) == {"a": 0.5, "b": -2.0}
    assert combination((2.0, {"a": 1.0}), (1.0, {"b": 1.0})) == {"a": 2.0, "b": 1.0}


def test_parts_are_found_by_name_and_role_or_the_message_lists_them():
    assembly = two_masses()
    assembly.add_place(Place("left", frozenset({"rotor"}), {}))
    assembly.add_place(Place("right", frozenset({"rotor"}), {}))
    assert assembly.place("rotor").name == "left"
    assert assembly.place("rotor", "right").name == "right"
    with pytest.raises(MissingPartError, match="rotor"):
        assembly.place("gear")
    with pytest.raises(MissingPartError, match="left, right"):
        assembly.place("rotor", "middle")


def test_mistakes_of_an_assembly_are_named():
    assembly = two_masses()
    with pytest.raises(InvalidValueError, match="exists already"):
        assembly.add_coordinate("a")
    assembly.probes.append(Probe("p", "force", "N", "a", "x", {"a": 1.0}))
    with pytest.raises(InvalidValueError, match="displacement, velocity, acceleration"):
        build_system(assembly)
    assembly.probes[0] = Probe("p", "displacement", "m", "a", "x", {"c": 1.0})
    with pytest.raises(InvalidValueError, match="no degree of freedom"):
        build_system(assembly)
    assembly.add_coordinate("c")
    with pytest.raises(InvalidValueError, match="no mass at c"):
        build_system(assembly)


@pytest.mark.parametrize("name", MACHINES)
def test_machine_is_declared_in_full(name):
    machine = MACHINES[name]
    definition = machine.definition
    assert definition.name == name
    assert "plausible" in definition.presets
    assert definition.meaning
    assert all(preset.meaning for preset in definition.presets.values())
    assert definition.load_parameter in ("", *(p.name for p in definition.parameters))
    for declared in definition.parameters:
        assert declared.meaning
        assert declared.source
    probes = machine.assembly(speed_rpm=1800.0).probes
    assert len({probe.name for probe in probes}) == len(probes)
    assert all(probe.unit for probe in probes)
    assert getattr(simulators, name) == machine


@pytest.mark.parametrize("name", MACHINES)
def test_every_preset_makes_matrices_and_text(name):
    for preset in MACHINES[name].definition.presets:
        machine = MACHINES[name].preset(preset)
        system = machine.system(speed_rpm=1800.0)
        assert np.all(np.isfinite(system.core))
        assert machine_from_toml(machine.to_toml()) == machine
        first = machine.definition.parameters[0]
        changed = machine.with_parameters(**{first.name: first.bounds[0] or first.bounds[1]})
        assert machine_from_toml(changed.to_toml()) == changed
        assert changed != machine


def test_machine_file_with_effects_comes_back(tmp_path):
    machine = MACHINES["amb_rotor"].with_effects(
        make_effect("unbalance", {"moment_kg_m": 3.3e-5}, at=MACHINES["amb_rotor"].bare_assembly().place("rotor").name),
        make_effect("coupling_misalignment", {"offset_m": 1e-4}),
    )
    path = tmp_path / "machine.toml"
    path.write_text(machine.to_toml(), encoding="utf-8")
    assert machine_from_toml(path) == machine


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("machine = ", "not valid TOML"),
        ('machine = "gearbox"', "format"),
        ('format = 1\nmachine = "lathe"', "unknown"),
        ('format = 1\nmachine = "gearbox"\npreset = "best"', "preset"),
        ('format = 1\nmachine = "gearbox"\n[parameters]\nload = 3', "no parameter"),
        ('format = 1\nmachine = "gearbox"\n[parameters]\nload_torque_n_m = "3 N.m"', "not a number"),
        ('format = 1\nmachine = "gearbox"\n[parameters]\nload_torque_n_m = 1e99', "allowed"),
        ('format = 1\nmachine = "gearbox"\ncolour = "red"', "unknown entry"),
        ('format = 1\nmachine = "gearbox"\n[[effects]]\nmoment_kg_m = 1', "no name"),
        ('format = 1\nmachine = "gearbox"\n[[effects]]\neffect = "rust"', "unknown"),
        ('format = 1\nmachine = "gearbox"\n[[effects]]\neffect = "unbalance"\nmass = 1', "no parameter"),
        ('format = 1\nmachine = "gearbox"\neffects = 3', "headings"),
        ("format = 1\nmachine = []", "in quotes"),
        ('format = 1\nmachine = "gearbox"\npreset = 2', "in quotes"),
        ('format = 1\nmachine = "gearbox"\n[[effects]]\neffect = [1]', "in quotes"),
        ('format = 1\nmachine = "gearbox"\n[[effects]]\neffect = "unbalance"\nat = 3', "in quotes"),
        ('format = 1\nmachine = "gearbox"\n[parameters]\nload_torque_n_m = [3]', "not a number"),
    ],
)
def test_mistakes_in_a_machine_file_are_named_with_the_file(text, message, tmp_path):
    with pytest.raises(InvalidValueError, match=message):
        machine_from_toml(text)
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InvalidValueError, match=r"mine\.toml"):
        machine_from_toml(tmp_path / "mine.toml")


def test_missing_machine_file_is_said(tmp_path):
    with pytest.raises(InvalidValueError, match="cannot be read"):
        machine_from_toml(Path(tmp_path / "none.toml"))


def test_machines_are_immutable_and_effects_stack():
    machine = find_machine("gearbox")
    with pytest.raises(dataclasses.FrozenInstanceError):
        machine.preset_name = "as_printed"  # type: ignore[misc]
    unbalance = effect_catalogue()["unbalance"]()
    assert machine.with_effects(unbalance).without_effects() == machine
    assert machine.with_effects(unbalance).with_effects(unbalance).effects == (unbalance, unbalance)


def test_unknown_names_say_what_there_is():
    with pytest.raises(InvalidValueError, match="gearbox"):
        find_machine("lathe")
    with pytest.raises(InvalidValueError, match="unbalance"):
        make_effect("rust", {})
    with pytest.raises(AttributeError):
        simulators.lathe  # noqa: B018
    with pytest.raises(AttributeError, match="effect"):
        simulators.effects.Rust  # noqa: B018

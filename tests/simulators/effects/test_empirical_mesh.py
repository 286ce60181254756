"""Empirical mesh: the teeth's error by components, and all stiffness in proportion; a harder mesh deflects less."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.empirical_mesh import EmpiricalMesh
from rotorwise.simulators.effects.mesh_error_harmonics import MeshErrorHarmonics
from rotorwise.simulators.effects.tooth_crack import ToothCrack
from rotorwise.simulators.machine import find_machine, machine_from_toml

from .test_gear_eccentricity import signals
from .test_tooth_crack import mesh_of

BOX = find_machine("gearbox")
PHASE = np.linspace(0, 5, 400)
NOTHING = {f"{n}_{part}_m": 0.0 for n in ("first", "second", "third") for part in ("sine", "cosine")}


def test_its_error_is_one_of_harmonics_by_components(figure):
    parts = {"first": (1e-6, -2e-6), "second": (-5e-7, 0.0), "third": (0.0, 3e-7)}
    own = {f"{n}_{name}_m": x for n, both in parts.items() for name, x in zip(("sine", "cosine"), both, strict=True)}
    other = {f"{n}_m": math.hypot(*both) for n, both in parts.items()}
    other |= {f"{n}_angle_rad": math.atan2(both[1], both[0]) for n, both in parts.items()}
    one, two = (signals(mesh_of(effect), PHASE) for effect in (EmpiricalMesh(**own), MeshErrorHarmonics(**other)))
    assert one == pytest.approx(two, rel=1e-12, abs=1e-18)
    figure("Error of the teeth against harmonics of that size and angle", one[1], two[1])


def test_its_stiffness_is_a_share_and_damage_takes_away_what_it_did():
    harder, crack = EmpiricalMesh(**NOTHING, stiffness_share=0.2), ToothCrack()
    sound, both = signals(mesh_of(), PHASE)[0], signals(mesh_of(harder, crack), PHASE)[0]
    assert signals(mesh_of(harder), PHASE)[0] == pytest.approx(1.2 * sound, rel=1e-12)
    assert both - 1.2 * sound == pytest.approx(signals(mesh_of(crack), PHASE)[0] - sound, abs=1e-6 * sound.max())
    mean = mesh_of(harder, crack).mean_stiffness_n_m
    assert mean - mesh_of(crack).mean_stiffness_n_m == pytest.approx(0.2 * mesh_of().mean_stiffness_n_m, rel=1e-9)


def test_slow_gears_deflect_in_inverse_proportion():
    """Far below any resonance the approach less the error is force over stiffness, on average over whole pitches."""
    runs = [
        BOX.with_effects(EmpiricalMesh(**NOTHING, stiffness_share=share))
        .simulate(speed_rpm=30.0, duration_s=6 / 23, rate_hz=11500.0, settle_s=0.4)
        .probe("transmission error")
        for share in (0.0, 1.0)
    ]
    first, second = (run.mean() - BOX.values["mean_transmission_error_m"] for run in runs)
    assert second / first == pytest.approx(0.5, rel=0.01)


def test_a_file_keeps_it_and_gears_must_exist():
    machine = BOX.with_effects(EmpiricalMesh(stiffness_share=-0.1, second_cosine_m=-1e-6))
    assert machine_from_toml(machine.to_toml()) == machine
    with pytest.raises(MissingPartError, match="gear"):
        find_machine("test_rig").with_effects(EmpiricalMesh()).system(speed_rpm=1200)

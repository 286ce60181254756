"""Tooth crack: beam theory, what the mesh loses and when, growth with load, order of the solver across it."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.tooth_crack import ToothCrack
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.machines.gearbox import PINION_TEETH, RATIO, WHEEL_TEETH, tooth_pair
from rotorwise.simulators.rotor_dynamics.gear_mesh_law import GEAR_MESH
from rotorwise.simulators.solvers.stepper import LaneGroup, Stepper
from rotorwise.simulators.speed_profile import steady

BOX, PAIR = find_machine("gearbox"), tooth_pair()


def mesh_of(*effects):
    assembly = BOX.bare_assembly()
    for effect in effects:
        effect.contribute(assembly)
    return assembly.component("mesh")


def stiffness(mesh, pitches, **options):
    phase = np.atleast_1d(np.asarray(pitches, float))[:, None] * 2 * math.pi / PINION_TEETH
    timeline = Timeline(phase, phase, np.ones_like(phase), np.zeros_like(phase))
    parameters = np.array(mesh.interface_force().parameters)[:, None]
    return GEAR_MESH.signals(timeline, parameters, **options)[0, :, 0]


@pytest.mark.parametrize("gear", [PAIR.pinion, PAIR.wheel])
def test_crack_compliance_is_the_integral_over_the_tooth(gear, figure):
    """The same strain energy by adaptive quadrature over the height, section by section."""
    from scipy.integrate import quad

    depth, slant, roll = 0.3, math.pi / 4, 0.8 * gear.tip_roll_angle_rad
    lean = roll - gear.base_half_angle_rad
    rolls = np.linspace(gear.start_roll_angle_rad, gear.tip_roll_angle_rad, 20001)
    heights, widths = gear._flank_point(rolls)
    contact_height, contact_width = gear._flank_point(np.array(roll))
    root = widths.max()
    left = root - 2 * root * depth * math.sin(slant)
    modulus, shear, face = gear.material.youngs_modulus_pa, gear.material.shear_modulus_pa, gear.face_width_m

    def density(height, cracked):
        half = float(np.interp(height, heights, widths)) if height > heights[0] else float(widths[0])
        thickness = half + min(half, left) if cracked else 2 * half
        lever = (contact_height - height) * math.cos(lean) - contact_width * math.sin(lean)
        inertia = thickness**3 * face / 12
        return lever**2 / (modulus * inertia) + 1.2 * math.cos(lean) ** 2 / (shear * thickness * face)

    low, base = gear._straight_part_m()
    bottom = low if low < base else heights[0]
    falling = widths.argmax()
    kink = float(np.interp(-left, -widths[falling:], heights[falling:]))
    whole = quad(
        lambda h: density(h, True) - density(h, False), bottom, contact_height, points=[base, kink], limit=400
    )[0]
    found = gear.crack_compliance_m_n(np.array(roll), depth=depth, crack_angle_rad=slant)
    assert float(found) == pytest.approx(whole, rel=1e-4)
    figure("Compliance that a crack adds to a tooth, against beam theory", float(found), whole)


def test_deeper_cracks_yield_more_and_none_yields_nothing():
    rolls = np.linspace(0.3, PAIR.pinion.tip_roll_angle_rad, 5)
    added = [
        PAIR.pinion.crack_compliance_m_n(rolls, depth=depth, crack_angle_rad=math.pi / 4)
        for depth in (0.0, 0.1, 0.2, 0.4, 0.5, 0.65)
    ]
    assert added[0] == pytest.approx(0.0, abs=1e-30)
    assert np.all(np.diff(np.array(added), axis=0) > 0)
    # Half of the tooth gone and more of it at the tip's lever: the beam is several times as soft as a sound one.
    assert np.all(added[-2] < 10 * PAIR.pinion.beam_compliance_m_n(rolls))


@pytest.mark.parametrize(("at", "teeth"), [("pinion", PINION_TEETH), ("wheel", WHEEL_TEETH)])
def test_the_mesh_is_softer_for_one_contact_a_turn_by_the_pairs_own_amount(at, teeth):
    gear, mesh, sound = getattr(PAIR, at), mesh_of(ToothCrack(depth=0.3, at=at)), mesh_of()
    pitches = np.linspace(-0.2, 2.2, 241) + 2 * teeth + 1e-7
    change = stiffness(mesh, pitches) - stiffness(sound, pitches)
    pair_phase = pitches - 2 * teeth
    inside = (pair_phase > 0) & (pair_phase < PAIR.contact_ratio)
    roll = PAIR.roll_angles_rad(pair_phase[inside])[0 if at == "pinion" else 1]
    added = gear.crack_compliance_m_n(roll, depth=0.3, crack_angle_rad=math.pi / 4)
    before = 1 / PAIR.pair_stiffness_n_m(pair_phase[inside])
    expected = 1 / (before + added) - 1 / before
    # The polynomial rounds the corner where the contact passes the end of the crack's shadow.
    assert change[inside] == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())
    assert np.all(change[~inside] == 0)
    assert np.all(
        stiffness(mesh, np.linspace(2.0, teeth - 0.1, 500)) == stiffness(sound, np.linspace(2.0, teeth - 0.1, 500))
    )


def test_the_core_holds_the_mean_of_the_cracked_mesh():
    mesh = mesh_of(ToothCrack(depth=0.4))
    pitches = (np.arange(400 * PINION_TEETH) + 0.5) / 400
    lost = np.mean(stiffness(mesh_of(), pitches) - stiffness(mesh, pitches))
    assert mesh_of().mean_stiffness_n_m - mesh.mean_stiffness_n_m == pytest.approx(lost, rel=1e-2)
    assert lost > 0


def test_two_cracked_teeth_that_meet_yield_in_series():
    """Compliances of one pair add; order of the effects does not matter."""
    one, two = ToothCrack(depth=0.4), ToothCrack(depth=0.4, at="wheel")
    both = mesh_of(one, two)
    phase = 0.4
    before = 1 / PAIR.pair_stiffness_n_m(phase)
    added = sum(1 / damaged_pair(mesh_of(e), phase) - before for e in (one, two))
    assert 1 / damaged_pair(both, phase) == pytest.approx(before + added, rel=1e-6)
    assert mesh_of(two, one).interface_force().parameters == both.interface_force().parameters


def damaged_pair(mesh, phase):
    """Return the stiffness of the damaged pair at ``phase`` of its contact, the earlier pair taken off."""
    return stiffness(mesh, phase)[0] - PAIR.pair_stiffness_n_m(phase + 1)


def test_a_branch_goes_on_smoothly_beyond_its_jump():
    mesh = mesh_of(ToothCrack(depth=0.3))
    change = PAIR.jump_phases[1]
    pitches = change + np.linspace(-0.04, 0.04, 81)
    branch = np.full((81, 1), (change - 0.01) * 2 * math.pi / PINION_TEETH)
    along = stiffness(mesh, pitches, branch_rad=branch)
    assert np.abs(np.diff(along, 2)).max() < 1e-5 * along.mean()


def test_the_dip_of_the_transmission_error_grows_with_load():
    """Slow rolling: approach = F / k, so that the extra approach in the dip is in proportion to the load."""
    dips = []
    for load in (20.0, 40.0):
        runs = [
            machine.simulate(speed_rpm=20.0, duration_s=0.5, rate_hz=2000.0, settle_s=0.3).probe("transmission error")
            for machine in (
                m.with_parameters(load_torque_n_m=load, transmission_error_m=0.0)
                for m in (BOX, BOX.with_effects(ToothCrack(depth=0.4, angle_rad=0.6)))
            )
        ]
        dips.append(np.max(runs[1] - runs[0]))
    assert dips[1] / dips[0] == pytest.approx(2.0, rel=0.1)
    phase = np.linspace(0.0, PAIR.contact_ratio, 200)
    force = 40.0 * RATIO / PAIR.pinion.base_radius_m
    extra = force / stiffness(mesh_of(ToothCrack(depth=0.4)), phase) - force / stiffness(mesh_of(), phase)
    assert dips[1] == pytest.approx(extra.max(), rel=0.1)


def test_step_halving_converges_across_the_cracked_tooth():
    """As for the sound gearbox: the damage changes at the jumps that the mesh has anyway."""
    made = BOX.with_effects(ToothCrack(depth=0.3, angle_rad=0.8))
    profile, step = steady(speed_rpm=1800.0), BOX.definition.step_s
    group = LaneGroup([made], [profile], [made.system(speed_rpm=profile)])
    settled = Stepper(group, step_s=step / 2, start_s=0.0)
    for _ in range(20):
        settled.advance(2000)
    signals = []
    for factor in (1, 2, 8):
        run = Stepper(group, step_s=step / factor, start_s=0.0)
        run.states = settled.states.copy()
        signals.append(run.advance(2000 * factor)[::factor, :, 0])
    which = [probe.name for probe in made.system(speed_rpm=1800.0).probes].index("pinion torsional velocity")
    errors = [np.std(signal - signals[2], axis=0)[which] / np.std(signals[2], axis=0)[which] for signal in signals[:2]]
    assert errors[0] < 2e-4
    assert np.log2(errors[0] / errors[1]) > 2.7


def test_bad_cracks_and_machines_without_gears_are_refused():
    with pytest.raises(InvalidValueError, match="allowed"):
        PAIR.pinion.crack_compliance_m_n(np.array(0.5), depth=0.7, crack_angle_rad=1.0)
    with pytest.raises(MissingPartError):
        ToothCrack().contribute(find_machine("test_rig").bare_assembly())
    with pytest.raises(MissingPartError):
        ToothCrack(at="output wheel").contribute(BOX.bare_assembly())

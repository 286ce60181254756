"""Housing stages, base plate, linear bearing, weight, flexible shaft and motor rotor against closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.simulators.assembly import Assembly
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.rotor_dynamics.base_plate import MOUNT_SHARE, BasePlate
from rotorwise.simulators.rotor_dynamics.flexible_shaft import add_bending, add_torsion, total_mass_kg
from rotorwise.simulators.rotor_dynamics.hertz import ball_contact_stiffness
from rotorwise.simulators.rotor_dynamics.housing import HousingStage, add_housing
from rotorwise.simulators.rotor_dynamics.linear_bearing import LinearBearing, stiffness_under_load_n_m
from rotorwise.simulators.rotor_dynamics.motor_rotor import MotorRotor
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing
from rotorwise.simulators.rotor_dynamics.shaft_parts import Disc, Material, ShaftElement
from rotorwise.simulators.rotor_dynamics.weight import Weight
from rotorwise.simulators.system import build_system
from scipy.linalg import eigh

STEEL = Material(2.1e11, 7850.0, 0.3)


def matrix(assembly, kind):
    names = assembly.coordinates
    found = np.zeros((len(names), len(names)))
    for (row, column), value in getattr(assembly, kind).items():
        found[names.index(row), names.index(column)] += value
    return found


def finished(assembly):
    for component in assembly.components.values():
        component.finish(assembly)
    return assembly


def frequencies_hz(assembly):
    """Return undamped natural frequencies."""
    squares = eigh(matrix(assembly, "stiffness"), matrix(assembly, "mass"), eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0.0)) / (2 * math.pi)


# -- housing -------------------------------------------------------------------------------------------------------


def stage(mass_kg, x_hz, *, y_hz=900.0, axial_hz=300.0, damping_ratio=0.02):
    return HousingStage(mass_kg, {"x": x_hz, "y": y_hz, "axial": axial_hz}, damping_ratio)


def test_one_stage_vibrates_at_its_own_frequencies_with_its_own_damping():
    assembly = Assembly(speed_rad_s=0.0)
    add_housing(assembly, "h", base={}, stages=[stage(0.5, 1300.0)])
    values = np.linalg.eigvals(build_system(finished(assembly)).core)
    values = values[values.imag > 0]
    assert np.sort(np.abs(values)) / (2 * math.pi) == pytest.approx([300.0, 900.0, 1300.0], rel=1e-12)
    assert -values.real / np.abs(values) == pytest.approx(0.02, rel=1e-9)


@given(st.floats(0.1, 5.0), st.floats(0.01, 5.0), st.floats(100.0, 3000.0), st.floats(100.0, 9000.0))
def test_two_stages_obey_the_sum_and_the_product_of_their_squared_frequencies(first_kg, second_kg, low_hz, high_hz):
    assembly = Assembly(speed_rad_s=0.0)
    add_housing(assembly, "h", base={}, stages=[stage(first_kg, low_hz), stage(second_kg, high_hz)])
    finished(assembly)
    rows = [assembly.coordinates.index(name) for name in ("h_1.x", "h_2.x")]
    stiffness, mass = (matrix(assembly, kind)[np.ix_(rows, rows)] for kind in ("stiffness", "mass"))
    squares = eigh(stiffness, mass, eigvals_only=True) / (2 * math.pi) ** 2
    share = 1 + second_kg / first_kg
    # Trace and determinant of M^-1 K written out for k_1 = (m_1 + m_2) w_1^2 and k_2 = m_2 w_2^2.
    assert squares.prod() == pytest.approx(share * (low_hz * high_hz) ** 2, rel=1e-6)
    assert squares.sum() == pytest.approx(share * (low_hz**2 + high_hz**2), rel=1e-9)


def test_a_very_stiff_cap_rides_along_and_a_very_soft_one_stays_behind():
    for cap_hz, expected in ((1e5, 1300.0), (1.0, 1300.0 * math.sqrt(0.7 / 0.5))):
        assembly = Assembly(speed_rad_s=0.0)
        add_housing(assembly, "h", base={}, stages=[stage(0.5, 1300.0), stage(0.2, cap_hz)])
        nearest = min(frequencies_hz(finished(assembly)), key=lambda hz: abs(hz - expected))
        assert nearest == pytest.approx(expected, rel=1e-4)


def test_the_pedestal_is_a_support_that_can_be_weakened():
    assembly = Assembly(speed_rad_s=0.0)
    add_housing(assembly, "h", base={}, stages=[stage(0.5, 1300.0)])
    assembly.component("support", "h pedestal").scale_stiffness(x=0.25)
    assert max(frequencies_hz(finished(assembly))) == pytest.approx(900.0)
    assert pytest.approx(sorted(frequencies_hz(assembly))[1]) == 650.0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: add_housing(Assembly(0.0), "h", base={}, stages=[]), "0 stages"),
        (lambda: HousingStage(0.0, {"x": 1.0, "y": 1.0, "axial": 1.0}, 0.0), "is 0.0; allowed"),
        (lambda: HousingStage(1.0, {"x": 1.0, "y": 1.0}, 0.0), "Add 'axial'"),
        (lambda: HousingStage(1.0, {"x": 1.0, "y": -1.0, "axial": 1.0}, 0.0), "in y in Hz is -1.0"),
        (lambda: HousingStage(1.0, {"x": 1.0, "y": 1.0, "axial": 1.0}, -0.1), "Damping ratio -0.1"),
        (lambda: BasePlate(17.0, 0.8, 0.0, 0.1, 1e4, 0.5, 0.08, 0.05), "width_m of the base plate is 0.0"),
        (lambda: LinearBearing("b", find_bearing("6205"), {}, {}, -1.0, 1.0, 0.0), "stiffness_x_n_m = -1.0"),
    ],
)
def test_impossible_parts_are_refused(make, words):
    with pytest.raises(InvalidValueError, match=words):
        make()


# -- base plate ----------------------------------------------------------------------------------------------------


def plate(**changes):
    values = {
        "mass_kg": 17.0,
        "length_m": 0.8,
        "width_m": 0.35,
        "height_m": 0.1,
        "mount_stiffness_n_m": 1.7e4,
        "mount_shear_ratio": 0.5,
        "mount_damping_ratio": 0.08,
        "mount_depth_m": 0.0,
    }
    return BasePlate(**{**values, **changes})


def test_plate_with_mounts_in_the_plane_of_its_centre_has_six_uncoupled_modes():
    base = plate()
    assembly = Assembly(speed_rad_s=0.0)
    base.add(assembly)
    k, shear = 4 * 1.7e4, 4 * 1.7e4 * 0.5
    across, along = MOUNT_SHARE * 0.35 / 2, MOUNT_SHARE * 0.8 / 2
    about_x, about_y, about_z = base.inertias_kg_m2
    squares = [k / 17, shear / 17, shear / 17, k * along**2 / about_x, k * across**2 / about_z]
    squares.append(shear * (along**2 + across**2) / about_y)
    expected = np.sort(np.sqrt(squares)) / (2 * math.pi)
    assert frequencies_hz(assembly) == pytest.approx(expected, rel=1e-10)
    assert base.bounce_hz == pytest.approx(math.sqrt(k / 17) / (2 * math.pi))


def test_bouncing_plate_has_the_stated_damping_ratio():
    assembly = Assembly(speed_rad_s=0.0)
    plate().add(assembly)
    system = build_system(assembly)
    values, vectors = np.linalg.eig(system.core)
    row = assembly.coordinates.index("base.y")
    bounce = values[np.argmax(np.abs(vectors[row]) / np.abs(vectors[:6]).sum(axis=0) * (values.imag > 0))]
    assert abs(bounce) / (2 * math.pi) == pytest.approx(plate().bounce_hz, rel=1e-9)
    assert -bounce.real / abs(bounce) == pytest.approx(0.08, rel=1e-9)


@given(st.tuples(*[st.floats(-1, 1)] * 3), st.tuples(*[st.floats(-1, 1)] * 6))
def test_points_of_the_plate_move_as_a_rigid_body(position, motion):
    point = plate().point(x_m=position[0], y_m=position[1], z_m=position[2])
    names = ("base.x", "base.y", "base.axial", "base.angle_x", "base.angle_y", "base.angle_z")
    values = dict(zip(names, motion, strict=True))
    expected = np.array(motion[:3]) + np.cross(motion[3:], position)
    found = [sum(arm * values[name] for name, arm in point[d].items()) for d in ("x", "y", "axial")]
    assert found == pytest.approx(expected, abs=1e-12)


# -- bearing, weight, shaft, motor ---------------------------------------------------------------------------------


def test_stiffness_under_load_is_the_slope_of_the_hertz_load():
    balls, contact = 8, 1e10
    angles = 2 * math.pi * np.arange(balls) / balls

    def load(depth):
        return contact * np.sum(np.maximum(depth * np.cos(angles), 0) ** 1.5 * np.cos(angles))

    depth, small = 1e-6, 1e-10
    slope = (load(depth + small) - load(depth - small)) / (2 * small)
    assert stiffness_under_load_n_m(contact_stiffness=contact, balls=balls, load_n=load(depth)) == pytest.approx(
        slope, rel=1e-6
    )


@pytest.mark.parametrize("name", ["MaFaulDa", "ER-12K"])
def test_the_rigs_bearing_stiffness_is_that_of_its_contacts_under_the_rotors_weight(name):
    geometry = find_bearing(name)
    contact = ball_contact_stiffness(
        ball_diameter_m=geometry.ball_diameter_m,
        pitch_diameter_m=geometry.pitch_diameter_m,
        inner_conformity=0.52,
        outer_conformity=0.52,
        youngs_modulus_pa=2.1e11,
        poisson_ratio=0.3,
    )
    stiffness = stiffness_under_load_n_m(contact_stiffness=contact.combined, balls=geometry.balls, load_n=8.0)
    # The parameter's default is rounded to one digit; its prior is a factor of 2.
    assert stiffness == pytest.approx(2e7, rel=0.15)


def test_linear_bearing_holds_the_rings_together():
    assembly = Assembly(speed_rad_s=0.0)
    for name in ("in.x", "out.x", "in.y", "out.y", "in.z", "out.z"):
        assembly.add_coordinate(name, mass=2.0)
    rows = [{f"in.{axis}": 1.0, f"out.{axis}": -1.0} for axis in "xyz"]
    bearing = LinearBearing("b", find_bearing("ER-12K"), rows[0], rows[1], 4e6, 9e6, 0.0, rows[2], 1e6)
    bearing.scale_stiffness(y=0.25)
    assembly.add_component(bearing)
    # Two masses of 2 kg against each other: w^2 = k (1/2 + 1/2).
    expected = np.sqrt([0, 0, 0, 1e6, 2.25e6, 4e6]) / (2 * math.pi)
    assert frequencies_hz(finished(assembly)) == pytest.approx(expected, rel=1e-9, abs=1e-3)
    assert bearing.ball_pass_order == pytest.approx(3.052, abs=1e-3)
    with pytest.raises(InvalidValueError, match="times -1"):
        bearing.scale_stiffness(x=-1.0)


ELEMENTS = [ShaftElement(0.1, 0.016)] * 4
DISCS = [Disc(2, 0.9, 1.3e-3, 2.6e-3)]


def shaft():
    assembly = Assembly(speed_rad_s=0.0)
    add_bending(assembly, "s", elements=ELEMENTS, discs=DISCS, material=STEEL, damping_ratio=0.01)
    return assembly


def test_weight_pulls_down_with_mass_times_gravity_and_with_no_moment_about_the_mass_centre():
    assembly = shaft()
    assembly.add_component(Weight("weight", 10.0))
    pull = finished(assembly).forces[0].outputs[0]
    mass = total_mass_kg(ELEMENTS, DISCS, STEEL)
    assert mass == pytest.approx(0.9 + 7850 * math.pi / 4 * 0.016**2 * 0.4)
    # A rigid translation and a rigid tilt about the middle, where the disc is, as virtual motions.
    lift = sum(value for name, value in pull.items() if name.endswith(".y"))
    tilt = sum(value * (0.1 * int(name[2]) - 0.2) for name, value in pull.items() if name.endswith(".y"))
    tilt -= sum(value for name, value in pull.items() if name.endswith(".angle_x"))
    assert lift == pytest.approx(-mass, rel=1e-12)
    assert tilt == pytest.approx(0.0, abs=1e-12)
    assert not any(name.endswith((".x", ".angle_y")) for name in pull)


def test_free_shaft_has_damping_only_where_it_bends_or_twists():
    assembly = shaft()
    add_torsion(
        assembly,
        ("hub", "disc"),
        lengths_m=[0.4],
        diameter_m=0.016,
        discs=[Disc(1, 0.9, 1.3e-3, 2.6e-3)],
        material=STEEL,
        damping_ratio=0.01,
    )
    values = np.linalg.eigvals(build_system(assembly).core)
    values = values[values.imag > 2 * math.pi * 10]
    assert -values.real / np.abs(values) == pytest.approx(0.01, rel=1e-6)
    inertia = 2.6e-3 + 7850 * math.pi / 32 * 0.016**4 * 0.4
    twists = [assembly.coordinates.index(name) for name in ("hub.torsion", "disc.torsion")]
    assert matrix(assembly, "mass")[np.ix_(twists, twists)].sum() == pytest.approx(inertia, rel=1e-12)


def test_motor_rotor_bounces_and_tilts_on_its_two_bearings():
    rotor = MotorRotor(1.5, 6e-4, 0.1, 0.14, 0.05, 3e7, 1e6, 0.05)
    assembly = Assembly(speed_rad_s=0.0)
    end = rotor.add(assembly, lambda distance: {"x": {}, "y": {}, "axial": {}})
    diametral = 3e-4 + 1.5 * 0.1**2 / 12
    squares = [0.0, 1e6 / 1.5, 2 * 3e7 / 1.5, 2 * 3e7 / 1.5, 6e7 * 0.07**2 / diametral, 6e7 * 0.07**2 / diametral]
    expected = np.sort(np.sqrt(squares)) / (2 * math.pi)
    assert frequencies_hz(assembly) == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert end["x"] == {"motor.x": 1.0, "motor.angle_y": pytest.approx(0.12)}


def test_motor_rotor_that_moves_with_its_stator_strains_nothing():
    base = plate(mount_depth_m=0.05)
    assembly = Assembly(speed_rad_s=0.0)
    base.add(assembly)
    mounts = matrix(assembly, "stiffness")
    rotor = MotorRotor(1.5, 6e-4, 0.1, 0.14, 0.05, 3e7, 1e6, 0.05)
    rotor.add(assembly, lambda distance: base.point(y_m=0.13, z_m=-0.13 - distance))
    stiffness = matrix(assembly, "stiffness")
    stiffness[: len(mounts), : len(mounts)] -= mounts
    # The rotor's mass centre is 0.12 m behind its end, that is at z = -0.25 m from the plate's centre.
    tilt = {"base.angle_x": 1.0, "base.angle_y": 2.0, "base.x": 3.0, "base.axial": 4.0}
    tilt |= {"motor.angle_x": 1.0, "motor.angle_y": 2.0, "motor.x": 3.0 - 2 * 0.25, "motor.y": 0.25}
    tilt |= {"motor.axial": 4.0 + 0.13}
    motion = np.array([tilt.get(name, 0.0) for name in assembly.coordinates])
    assert np.abs(stiffness @ motion).max() < 1e-8 * np.abs(stiffness).max()

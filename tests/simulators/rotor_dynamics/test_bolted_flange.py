"""Bolted flange: potential against the sum over the bolts, force against its gradient, symmetries, linear forms."""

import cmath
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.simulators.assembly import Assembly, Place
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.rotor_dynamics.bolted_flange import BoltedFlange
from rotorwise.simulators.rotor_dynamics.bolted_flange_exact import EXACT_FLANGE
from rotorwise.simulators.rotor_dynamics.bolted_flange_linear import LINEARISED_FLANGE, PRINTED_FLANGE

ANGLE = st.floats(-math.pi, math.pi)
SMALL = st.floats(-2e-3, 2e-3)
AXES = ("x", "y", "torsion")


def rotor(number):
    return Place(f"rotor_{number}", frozenset({"rotor"}), {axis: {f"{axis}_{number}": 1.0} for axis in AXES})


def flange(*, bolts=5, losses=(), hole=0.4e-3 + 0.3e-3j, axis=-0.2e-3 - 0.5e-3j, **options):
    made = BoltedFlange(
        "flange",
        rotor(1),
        rotor(2),
        bolts=bolts,
        bolt_stiffness_n_m=4e5,
        bolt_circle_radius_m=0.3,
        hole_offset_m=hole,
        axis_offset_m=axis,
        **options,
    )
    for bolt, loss in losses:
        made.weaken(bolt, loss=loss)
    return made


LOSSES = {"equal": (), "one lost": ((2, 1.0),), "two weak": ((1, 0.4), (3, 0.9))}


def bolt_sum(made, z, first, second):
    """Eq (6) bolt by bolt: hole on flange 2 minus hole on flange 1, as two real coordinates."""
    total = 0.0
    for angle, share in zip(made.bolt_angles_rad, made.stiffness_shares, strict=True):
        hole_1 = made.bolt_circle_radius_m * np.array([math.cos(angle + first), math.sin(angle + first)])
        own = made.bolt_circle_radius_m * np.array([math.cos(angle), math.sin(angle)])
        own += [made.hole_offset_m.real, made.hole_offset_m.imag]
        turn = np.array([[math.cos(second), -math.sin(second)], [math.sin(second), math.cos(second)]])
        gap = turn @ own + [z.real + made.axis_offset_m.real, z.imag + made.axis_offset_m.imag] - hole_1
        total += made.bolt_stiffness_n_m * share * gap @ gap / 2
    return total


def timeline(angle):
    at = np.array([[angle]])
    return Timeline(np.zeros((1, 1)), at, np.ones((1, 1)), np.zeros((1, 1)))


def linear_part(made, motion):
    """Forces of the springs that `finish` puts into the linear core, on (X, Y, twist 1, twist 2)."""
    parameters = made.law_parameters()
    twist = parameters[3] * (motion[3] - motion[2])
    return np.array([-parameters[0] * motion[0], -parameters[0] * motion[1], twist, -twist])


def force(made, motion, angle, law=EXACT_FLANGE, *, plain=False):
    """Generalised forces on (X, Y, twist 1, twist 2), interface plus linear core."""
    parameters = np.array(made.law_parameters())[:, None]
    signals = law.signals(timeline(angle), parameters)[:, 0]
    u = np.zeros((4, 1))
    rows = np.arange(4)
    if law.is_linear:
        coefficients = signals[4:, 0].reshape(4, 4)
        u[:, 0] = signals[:4, 0] + coefficients @ motion
    else:
        compiled = law.force.py_func if plain else law.force
        compiled(np.ascontiguousarray(signals), parameters, np.array(motion, float)[:, None], rows, rows, u)
    return u[:, 0] + linear_part(made, motion)


def energy(made, motion, angle):
    return made.potential_j(complex(motion[0], motion[1]), angle + motion[2], angle + motion[3])


@pytest.mark.parametrize("losses", LOSSES.values(), ids=LOSSES)
@given(x=SMALL, y=SMALL, first=ANGLE, second=ANGLE)
def test_potential_is_the_sum_over_the_bolts(losses, x, y, first, second):
    made = flange(losses=losses)
    # The largest energy of these bolts, two radii apart, is the scale of rounding.
    scale = 5 * 4e5 * (2 * 0.3) ** 2 / 2
    assert made.potential_j(complex(x, y), first, second) == pytest.approx(
        bolt_sum(made, complex(x, y), first, second), abs=1e-12 * scale
    )


@given(x=SMALL, y=SMALL, first=ANGLE, second=ANGLE, delta=SMALL)
def test_closed_form_of_equal_bolts_and_vertical_offset(x, y, first, second, delta):
    made = flange(bolts=4, hole=1j * delta, axis=-1j * delta)
    stiffness, radius = 4 * 4e5, 0.3
    horizontal, vertical = x - delta * math.sin(second), y - delta + delta * math.cos(second)
    expected = (horizontal**2 + vertical**2) / 2 + radius**2 * (1 - math.cos(second - first))
    assert made.potential_j(complex(x, y), first, second) == pytest.approx(
        stiffness * expected, abs=1e-12 * stiffness * radius**2
    )


@pytest.mark.parametrize("losses", LOSSES.values(), ids=LOSSES)
@given(x=SMALL, y=SMALL, first=st.floats(-0.5, 0.5), second=st.floats(-0.5, 0.5), angle=ANGLE)
def test_force_is_minus_the_gradient(losses, x, y, first, second, angle):
    made = flange(losses=losses)
    motion = np.array([x, y, first, second])
    # Complex steps do not pass through math functions; a fourth-order difference leaves 1e-9 of the scale.
    widths = np.array([1e-4, 1e-4, 1e-3, 1e-3])
    scale = np.array([4e5 * 0.3, 4e5 * 0.3, 4e5 * 0.09, 4e5 * 0.09]) * 5
    got = force(made, motion, angle)
    for i in range(4):
        step = np.zeros(4)
        step[i] = widths[i]
        near = energy(made, motion + step, angle) - energy(made, motion - step, angle)
        far = energy(made, motion + 2 * step, angle) - energy(made, motion - 2 * step, angle)
        gradient = (8 * near - far) / (12 * widths[i])
        assert got[i] == pytest.approx(-gradient, abs=1e-8 * scale[i])


@pytest.mark.parametrize("losses", LOSSES.values(), ids=LOSSES)
@given(x=SMALL, y=SMALL, first=ANGLE, second=ANGLE, angle=ANGLE, turn=ANGLE)
def test_turning_everything_turns_the_force(losses, x, y, first, second, angle, turn):
    made, turned = flange(losses=losses), flange(losses=losses)
    turned.axis_offset_m *= cmath.exp(1j * turn)
    z = complex(x, y) * cmath.exp(1j * turn)
    before = force(made, [x, y, first, second], angle)
    after = force(turned, [z.real, z.imag, first, second], angle + turn)
    scale = 5 * 4e5 * 0.3
    assert complex(*after[:2]) == pytest.approx(complex(*before[:2]) * cmath.exp(1j * turn), abs=1e-11 * scale)
    assert after[2:] == pytest.approx(before[2:], abs=1e-11 * scale)


@given(x=SMALL, y=SMALL, first=ANGLE, second=ANGLE, angle=ANGLE)
def test_moments_balance_about_the_common_centre(x, y, first, second, angle):
    # The bolts are internal: with force F on rotor 2 at z + s, the moments about rotor 1's centre add up to nothing.
    made = flange(losses=LOSSES["two weak"])
    push_x, push_y, torque_1, torque_2 = force(made, [x, y, first, second], angle)
    arm = complex(x, y) + made.axis_offset_m
    moment = arm.real * push_y - arm.imag * push_x
    assert torque_1 + torque_2 + moment == pytest.approx(0.0, abs=1e-11 * 5 * 4e5 * 0.3)


@pytest.mark.parametrize("losses", LOSSES.values(), ids=LOSSES)
def test_compiled_force_is_the_plain_one(losses):
    made = flange(losses=losses)
    motion = [1e-4, -2e-4, 0.02, -0.01]
    # Fused multiply-add in compiled code may differ in the last digits of cancelling terms.
    assert force(made, motion, 0.7) == pytest.approx(force(made, motion, 0.7, plain=True), abs=1e-9)


@pytest.mark.parametrize("losses", LOSSES.values(), ids=LOSSES)
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5])
def test_linearised_law_is_the_tangent_of_the_exact_one(losses, angle):
    made = flange(losses=losses)
    motion = np.array([3e-4, -2e-4, 1.1e-3, -0.7e-3])
    errors = []
    # Small enough that the cubic part of sin(twist) does not show beside the second order.
    for scale in (0.02, 0.01, 0.005):
        exact, linear = (force(made, scale * motion, angle, law) for law in (EXACT_FLANGE, LINEARISED_FLANGE))
        errors.append(np.abs(exact - linear).max())
    # What is left out is of second order: a quarter for half the motion.
    assert errors[0] > 0
    assert errors[1] / errors[0] == pytest.approx(0.25, abs=0.01)
    assert errors[2] / errors[1] == pytest.approx(0.25, abs=0.01)
    at_rest = [force(made, np.zeros(4), angle, law) for law in (EXACT_FLANGE, LINEARISED_FLANGE)]
    assert at_rest[0] == pytest.approx(at_rest[1], abs=1e-9)


def test_printed_law_is_equations_15_and_16():
    delta, factor = 5e-4, 3.0
    parameters = np.array([factor, delta, 1.0, 1.0])[:, None]
    angle = 0.6
    signals = PRINTED_FLANGE.signals(timeline(angle), parameters)[:, 0, 0]
    cos, sin = math.cos(angle), math.sin(angle)
    assert signals[:3] == pytest.approx(factor * np.array([-cos, -sin, -delta]))
    change = factor * np.array([[0, 0, sin], [0, 0, cos], [sin, cos, 0]])
    assert signals[3:].reshape(3, 3) == pytest.approx(-change)


def test_printed_offset_sum_of_a_lost_bolt():
    made = flange(bolts=4, hole=5e-4j, axis=-5e-4j, form="printed", losses=((1, 1.0),))
    # Eq (18) with R_1 of Eq (3), both as printed.
    expected = 4e5 * (4 * 5e-4 / 2 - 0.3 * math.sqrt(1 + 5e-4**2 + 2 * 5e-4))
    assert made._printed_parameters()[0] == pytest.approx(expected)


@pytest.mark.parametrize("torque", [100.0, 1000.0])
def test_lost_bolt_turns_torque_into_a_turning_force(torque):
    # Aligned flange, N = 4, one bolt gone: three bolts carry the twist T / (3 K r^2). The lost bolt no longer balances
    # the one opposite, so that the sideways force is K r twist, turning with the flange.
    made = flange(bolts=4, hole=0j, axis=0j, losses=((1, 1.0),))
    twist = -torque / (3 * 4e5 * 0.09)
    for angle in (0.0, 1.0, 2.0):
        push = complex(*force(made, [0.0, 0.0, 0.0, twist], angle)[:2])
        expected = torque / (3 * 0.3)
        # Chord instead of arc: relative twist squared over 24, and the direction turns by half the twist.
        assert abs(push) == pytest.approx(expected, rel=twist**2)
        assert cmath.phase(push / cmath.exp(1j * angle)) == pytest.approx(-math.pi / 2 + twist / 2, abs=1e-9)


@pytest.mark.parametrize("bolts", [3, 4, 7])
def test_bolts_that_are_unlike_turn_torque_into_a_turning_force(bolts):
    # Aligned: the bolts carry the twist T / (N K r^2) together, and their shares 1 + |u| cos leave the force
    # K r twist N |u| / 2 = |u| T / (2 r) on flange 2, a quarter turn behind where they are stiffest.
    uneven, torque = 0.03 * cmath.exp(0.7j), 500.0
    made = flange(bolts=bolts, hole=0j, axis=0j, unevenness=uneven)
    assert made.stiffness_shares.sum() == pytest.approx(bolts)
    twist = torque / (bolts * 4e5 * 0.09)
    for angle in (0.0, 1.3):
        push = complex(*force(made, [0.0, 0.0, 0.0, twist], angle)[:2])
        assert abs(push) == pytest.approx(abs(uneven) * torque / (2 * 0.3), rel=twist**2)
        turned = push / cmath.exp(1j * (angle + 0.7))
        assert cmath.phase(turned) == pytest.approx(-math.pi / 2 + twist / 2, abs=1e-9)
    # An axis apart makes of it a torque at 1X, K r |s| N |u| / 2, that no equal bolts make.
    apart = flange(bolts=bolts, hole=0j, axis=-0.5e-3j, unevenness=uneven)
    torques = [force(apart, [0.0, 0.0, 0.0, 0.0], angle)[2] for angle in np.linspace(0, 2 * math.pi, 8, endpoint=False)]
    first = 2 * np.fft.rfft(torques)[1] / 8
    assert abs(first) == pytest.approx(4e5 * 0.3 * 0.5e-3 * bolts * 0.03 / 2, rel=1e-9)


def test_misalignment_adds_as_a_vector_and_fits_at_angle_zero():
    made = flange(hole=0j, axis=0j)
    made.misalign(offset_m=3e-4, offset_phase_rad=0.0)
    made.misalign(offset_m=4e-4, offset_phase_rad=math.pi / 2)
    assert made.hole_offset_m == pytest.approx(3e-4 + 4e-4j)
    assert made.potential_j(0j, 0.0, 0.0) == pytest.approx(0.0, abs=1e-12)
    assert made.potential_j(0j, math.pi, math.pi) == pytest.approx(5 * 4e5 * (2 * 5e-4) ** 2 / 2)


@given(angle=ANGLE, other=ANGLE, tilt=st.floats(1e-4, 0.05), bolts=st.integers(3, 12))
def test_tilt_shortens_the_hole_circle_without_effect_on_equal_bolts(angle, other, tilt, bolts):
    # The claim of `misalign`: holes of a tilted flange, seen along the shaft, lie on an ellipse; with equal bolts the
    # sideways force is that of the round circle, and the torque differs by the factor (1 + cos tilt) / 2 only.
    alpha = 2 * np.pi * np.arange(bolts) / bolts
    seen = 0.3 * np.exp(1j * (alpha + angle))
    seen = seen.real + 1j * seen.imag * math.cos(tilt)
    fixed = 0.3 * np.exp(1j * (alpha + other))
    assert abs(np.sum(seen - fixed)) < 1e-13
    torque = np.sum((np.conj(fixed) * (seen - fixed)).imag)
    assert torque == pytest.approx(bolts * 0.09 * math.sin(angle - other) * (1 + math.cos(tilt)) / 2, abs=1e-13)


def test_note_says_that_an_angle_changes_nothing():
    made = flange()
    made.misalign(angle_rad=1e-3)
    assembly = Assembly(speed_rad_s=1.0)
    made.finish(assembly)
    assert "1" in assembly.notes[0]
    assert "tilt" in assembly.notes[0]


@pytest.mark.parametrize("bolts", [2, 3.5])
def test_number_of_bolts_is_refused(bolts):
    with pytest.raises(InvalidValueError, match="whole number, 3 or more"):
        flange(bolts=bolts)


@pytest.mark.parametrize(("bolt", "loss"), [(0, 0.5), (6, 0.5), (1, 1.5)])
def test_loss_of_a_bolt_is_refused(bolt, loss):
    with pytest.raises(InvalidValueError, match="bolt 1 to 5"):
        flange().weaken(bolt, loss=loss)


def test_nearest_bolt():
    made = flange(bolts=4)
    angles = (0.0, math.pi / 2, math.pi, -math.pi / 2, 2 * math.pi, -2 * math.pi, 0.7)
    assert [made.bolt_at(angle) for angle in angles] == [1, 2, 3, 4, 1, 1, 1]


def test_printed_equations_refuse_a_horizontal_offset():
    made = flange(bolts=4, hole=1e-4 + 5e-4j, form="printed")
    with pytest.raises(InvalidValueError, match="vertical offset only"):
        made.finish(Assembly(speed_rad_s=1.0))

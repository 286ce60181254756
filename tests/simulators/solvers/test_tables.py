"""Modal coordinates, phi functions and the product of the compiled step against plain linear algebra."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.simulators import gearbox
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.block_form import block_form
from rotorwise.simulators.solvers.layout import step_layout
from rotorwise.simulators.solvers.plan import Room, block_signals, force_plan
from rotorwise.simulators.solvers.tables import phi_columns, phi_columns_of_blocks, phi_functions, step_tables
from rotorwise.simulators.speed_profile import steady
from scipy.linalg import expm


@settings(max_examples=200, deadline=None)
@given(st.floats(-40.0, 1.0), st.floats(-40.0, 40.0))
def test_phi_functions_are_those_of_an_augmented_exponential(real, imaginary):
    # e^z and the phi functions stand in the first row of the exponential of a Jordan block bordered by z.
    z = complex(real, imaginary)
    augmented = np.diag(np.ones(3, dtype=complex), 1)
    augmented[0, 0] = z
    truth = expm(augmented)[0]
    found = phi_functions(np.array([z]))
    assert np.array(found)[:, 0] == pytest.approx(truth, rel=1e-12, abs=1e-14)


def test_phi_functions_of_nothing_are_their_limits():
    assert np.array(phi_functions(np.zeros(1)))[:, 0] == pytest.approx([1 / math.factorial(k) for k in range(4)])


@pytest.mark.parametrize("name", ["gearbox", "amb_rotor"])
def test_modal_form_is_the_same_system(name):
    system = find_machine(name).system(speed_rpm=1800.0)
    form = block_form(system)
    assert form.is_blocks
    assert form.inverse @ form.basis == pytest.approx(np.eye(system.states), abs=1e-7)
    # Backward error of eigenvectors of length one.
    residual = np.linalg.norm(system.core @ form.basis - form.basis @ form.core, axis=0)
    assert np.all(residual < 1e-12 * np.linalg.norm(system.core))


def test_tables_of_blocks_are_those_of_the_whole():
    form = block_form(gearbox.system(speed_rpm=1800.0))
    one, many = phi_columns_of_blocks(form, 1e-5), phi_columns(form.core, form.force_columns, 1e-5)
    assert one[0] == pytest.approx(many[0], abs=1e-12)
    for own, whole in zip(one[1], many[1], strict=True):
        assert own == pytest.approx(whole, abs=1e-11 * np.abs(whole).max())


@pytest.mark.parametrize("lanes", [1, 2, 7, 8, 13, 64])
def test_compiled_products_are_matrix_products(lanes):
    from rotorwise.simulators.solvers.product import add_products

    system = gearbox.system(speed_rpm=1800.0)
    form = block_form(system)
    layout = step_layout(form, system, step_tables(form, 1 / 60_000), lanes)

    layout.work[1:-8] = np.random.default_rng(1).normal(size=layout.work[1:-8].shape)
    plain = layout.memory.copy()
    for source, columns, target, height, at in layout.program:
        shape = (columns, height) if lanes == 1 else (height, columns)
        matrix = plain[at : at + columns * height].reshape(shape)
        vectors = plain[source : source + columns * lanes].reshape(columns, lanes)
        plain[target : target + height * lanes] += ((matrix.T if lanes == 1 else matrix) @ vectors).ravel()
    add_products(layout.memory, layout.program, 0, layout.program.shape[0], lanes)
    assert layout.memory == pytest.approx(plain, rel=1e-11, abs=1e-11)


def test_even_cosines_are_cosines():
    phase = np.stack([1e4 + 0.01 * np.arange(1000), 0.02 * np.arange(1000)], axis=1)
    timeline = Timeline(phase, phase, phase, phase, advance_rad=np.array([0.01, 0.02]))
    for order in (0.0, 0.381, 1.0, 23.0):
        cos, sin = timeline.cos_sin(order)
        # Rounding of the angle itself: 2e5 rad times 1e-16.
        assert cos == pytest.approx(np.cos(order * phase), abs=1e-10)
        assert sin == pytest.approx(np.sin(order * phase), abs=1e-10)
        part = timeline.select(np.array([1])).cos_sin(order)
        assert np.array_equal(part[0], cos[:, [1]])


def test_blocks_of_signals_do_not_depend_on_where_they_begin():
    profile = steady(speed_rpm=1800.0)
    plan = force_plan([gearbox.system(speed_rpm=1800.0)], [profile])
    step, room = 1 / 60_000, Room()
    whole = block_signals(plan, 0.0, step, 400, room)
    kept = whole.pushes.copy(), whole.halves.copy(), whole.jumped.copy(), whole.events.copy()
    later = block_signals(plan, 150 * step, step, 250, room)
    assert later.pushes == pytest.approx(kept[0][300:], abs=1e-9 * np.abs(kept[0]).max())
    assert later.halves == pytest.approx(kept[1][300:], abs=1e-9)
    assert later.jumped == pytest.approx(kept[2][150:], rel=1e-9, abs=1e-12)
    inside = kept[3][kept[3][:, 0] >= 150]
    assert later.events[:, 0] == pytest.approx(inside[:, 0] - 150)
    assert later.events[:, 3] == pytest.approx(inside[:, 3], abs=1e-12)

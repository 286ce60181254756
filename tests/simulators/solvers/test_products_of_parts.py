"""What is left out of a product is zero, and costs nothing else."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.block_form import block_form
from rotorwise.simulators.solvers.products_of_parts import in_order_of_parts, pieces
from rotorwise.simulators.solvers.tables import step_tables


@given(st.integers(0, 2**32 - 1), st.integers(0, 20), st.integers(0, 14), st.floats(0.0, 1.0), st.sampled_from([1, 64]))
def test_pieces_hold_every_number_once(seed, height, width, share, lanes):
    generator = np.random.default_rng(seed)
    matrix = generator.normal(size=(height, width)) * (generator.random((height, width)) < share)
    left = matrix.copy()
    for start, stop, first, last in pieces(matrix, rows=4, lanes=lanes):
        assert first % 2 == 0
        assert 0 <= start < stop <= height
        assert 0 <= first < last <= width
        left[start:stop, first:last] = 0.0
    assert not left.any()
    rows = [row for start, stop, _, _ in pieces(matrix, rows=4, lanes=lanes) for row in range(start, stop)]
    assert len(rows) == len(set(rows))


def test_shafts_that_nothing_links_make_small_products():
    system = in_order_of_parts(find_machine("gearbox").system(speed_rpm=1800.0))
    tables = step_tables(block_form(system), 1 / 60_000)
    for matrix in (tables.half_rows, tables.update[1]):
        area = sum((stop - start) * (last - first) for start, stop, first, last in pieces(matrix, rows=4, lanes=64))
        assert area < 0.6 * matrix.size


@pytest.mark.parametrize("name", ["gearbox", "test_rig", "rigid_coupling"])
def test_the_order_of_parts_changes_no_machine(name):
    system = find_machine(name).system(speed_rpm=1800.0)
    ordered = in_order_of_parts(system)
    for k in range(len(system.forces)):
        assert np.array_equal(ordered.motion_rows[ordered.inputs[k]], system.motion_rows[system.inputs[k]])
        assert np.array_equal(ordered.force_columns[:, ordered.outputs[k]], system.force_columns[:, system.outputs[k]])
        assert np.array_equal(ordered.probe_columns[:, ordered.outputs[k]], system.probe_columns[:, system.outputs[k]])

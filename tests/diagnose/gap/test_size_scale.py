"""Sizes on a logarithmic scale: a factor is a difference, small ones are themselves, and back; not of phases."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.size_scale import (
    KNEE,
    at_most_once,
    from_scale,
    gained,
    in_units,
    knees_of,
    on_scale,
    to_scale,
)

KINDS = (LineKind(), LineKind(phase=False))


def lines(sizes, deviations):
    """Return lines of one probe with a phase, then without, in as many conditions as there are sizes."""
    amplitudes = np.stack([1j * np.asarray(sizes), np.asarray(sizes) + 0j], axis=-1)[:, None, :]
    return OrderLines(
        tuple(Condition(1000.0 + 100 * i) for i in range(len(sizes))),
        ("a",),
        (1.0, 3.05),
        amplitudes,
        np.stack([deviations, deviations], axis=-1)[:, None, :].astype(float),
        KINDS,
    )


def test_of_a_machine_that_repeats_only_the_envelope_is_on_the_scale():
    one = lines([1.0, 2.0], [0.3, 0.2])
    beside = replace(one, kinds=(LineKind(), LineKind(phase=False)))
    envelope = replace(one, kinds=(LineKind(), LineKind(phase=False, envelope=True)))
    assert np.isinf(knees_of([beside], envelope_only=True)).all()
    knees = knees_of([envelope], envelope_only=True)
    assert np.isinf(knees[0, 0])
    assert knees[0, 1] == pytest.approx(KNEE * 0.2)
    assert not on_scale(envelope, knees).spectrum_on_scale
    assert on_scale(beside, knees_of([beside])).spectrum_on_scale


def test_the_knee_is_that_of_the_quietest_record_and_of_sizes_only():
    loud, quiet = lines([1.0, 2.0], [0.3, 0.2]), lines([1.0], [0.1])
    knees = knees_of([loud, quiet])
    assert np.isinf(knees[0, 0])
    assert knees[0, 1] == pytest.approx(KNEE * 0.1)
    unseen = lines([1.0], [np.inf])
    assert np.isinf(knees_of([unseen])).all()


def test_a_factor_is_the_same_difference_of_any_large_line_and_small_ones_stay():
    knees = np.array([[np.inf, 0.1]])

    def scaled(size):
        return to_scale(np.array([[1j * size, size + 0j]]), knees)[0]

    assert scaled(30.0)[1] - scaled(10.0)[1] == pytest.approx(scaled(300.0)[1] - scaled(100.0)[1], rel=1e-4)
    assert scaled(30.0)[1] - scaled(10.0)[1] == pytest.approx(0.1 * np.log(3), rel=1e-4)
    assert scaled(1e-3)[1] == pytest.approx(1e-3, rel=1e-4)
    assert scaled(30.0)[0] == 30j


@example([5e-324], 1.0)
@example([0.0, 1e-10], 1.0)
@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=4), st.floats(1e-3, 1e3))
def test_there_and_back(sizes, noise):
    one = lines(sizes, np.full(len(sizes), noise))
    there = on_scale(one, knees_of([one]))
    back = in_units(there)
    assert back.amplitudes == pytest.approx(one.amplitudes, rel=1e-9, abs=1e-9 * noise)
    assert back.deviations == pytest.approx(one.deviations, rel=1e-9)
    assert in_units(one) is one
    assert from_scale(there.amplitudes, None) is there.amplitudes


def test_a_deviation_is_that_of_the_scale():
    sure, knees = np.array([1e-5, 1e-8]), np.array([[np.inf, 0.3]])
    there = on_scale(lines([5.0, 0.01], sure), knees)
    more = on_scale(lines([5.0 + 1e-6, 0.01 + 1e-6], sure), knees)
    slope = np.real(more.amplitudes - there.amplitudes)[:, 0, 1] / 1e-6
    assert there.deviations[:, 0, 1] == pytest.approx(sure * slope, rel=1e-5)
    assert there.deviations[:, 0, 0] == pytest.approx(sure)
    # Less sure, it is the mean slope over three deviations.
    wide = on_scale(lines([5.0], np.array([0.1])), knees).deviations[0, 0, 1]
    assert wide == pytest.approx(0.3 * (np.arcsinh(5.0 / 0.3) - np.arcsinh(4.7 / 0.3)) / 3, rel=1e-9)


@given(st.floats(0.0, 3.0), st.floats(1.0, 1e3))
def test_noise_is_no_further_from_nothing_than_in_units_however_quiet_another_record_is(times, noisier):
    one = lines([times * noisier], np.array([noisier]))
    there = on_scale(one, KNEE * np.array([[np.inf, 1.0]]))
    assert np.real(there.amplitudes[0, 0, 1]) == pytest.approx(times * there.deviations[0, 0, 1], rel=1e-9)


def test_a_tolerance_refers_to_one_factor_e_at_most():
    knees = np.array([[np.inf, 0.1]])
    change = np.array([[[3j, 5.0], [3j, -5.0], [3j, 0.02]]], dtype=complex).transpose(1, 0, 2)
    found = at_most_once(change, knees)
    assert found[:, 0, 0] == pytest.approx(3j)
    assert found[:, 0, 1] == pytest.approx([0.1, -0.1, 0.02])
    assert at_most_once(change, None) is change


@given(st.floats(0.0, 1e3), st.floats(1e-3, 1e3))
def test_a_gain_changes_a_large_size_by_its_share_of_the_knee(size, knee):
    knees, step = np.array([[np.inf, knee]]), 1e-5
    low, here, high = (to_scale(np.array([[size * 1j, size]]) * (1 + s), knees) for s in (-step, 0.0, step))
    assert gained(here, knees) == pytest.approx((high - low) / (2 * step), rel=1e-4, abs=1e-9)
    assert gained(here, knees)[0, 1].real <= knee
    assert gained(here, None) is here

"""Thinning and JSON: what is drawn must be what was measured."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rotorwise.datasets.errors import RotorwiseError
from rotorwise.diagnose.report.encode import (
    encode_curve,
    numbers,
    peak_preserving_indices,
    pool_map,
    to_json,
)

VALUES = st.floats(-1e6, 1e6) | st.sampled_from([math.nan, math.inf, -math.inf])
SIGNALS = st.integers(1, 400).flatmap(lambda size: arrays(float, size, elements=VALUES))


@given(SIGNALS, st.integers(4, 100))
def test_thinning_keeps_extremes_ends_order_and_limit(y: np.ndarray, limit: int) -> None:
    keep = peak_preserving_indices(y, limit)
    assert keep.size <= max(limit, 4)
    assert (np.diff(keep) > 0).all()
    assert keep[0] == 0
    assert keep[-1] == y.size - 1
    finite = y[np.isfinite(y)]
    if finite.size:
        kept = y[keep][np.isfinite(y[keep])]
        assert kept.max() == finite.max()
        assert kept.min() == finite.min()


@given(SIGNALS, st.integers(16, 100), st.floats(0, 400))
def test_focus_keeps_extremes_and_limit(y: np.ndarray, limit: int, focus: float) -> None:
    coded = encode_curve(np.arange(y.size), y, limit=limit, focus=focus)
    assert coded["shown"] <= limit
    positions = np.cumsum(json.loads(coded["i"])) if "i" in coded else np.asarray(json.loads(coded["x"]))
    assert (np.diff(positions) > 0).all()
    finite = y[np.isfinite(y)]
    if finite.size:
        drawn = [value for value in json.loads(coded["y"]) if value is not None]
        assert max(drawn) == pytest.approx(finite.max(), rel=1e-3)
        assert min(drawn) == pytest.approx(finite.min(), rel=1e-3)


def test_focus_draws_every_point_of_the_part_that_the_reader_looks_at() -> None:
    y = np.random.default_rng(1).random(20000)
    coded = encode_curve(np.arange(20000), y, limit=8000, focus=1500)
    positions = np.cumsum(json.loads(coded["i"]))
    assert (positions[:1501] == np.arange(1501)).all()


@given(st.floats(0, 1e5), st.floats(1e-4, 1e3), st.integers(2, 3000))
def test_even_positions_come_back(start: float, step: float, size: int) -> None:
    x = start + step * np.arange(size)
    coded = encode_curve(x, np.sin(np.arange(size)), limit=500)
    if "i" in coded:
        index = np.cumsum(json.loads(coded["i"]))
        drawn = coded["x0"] + coded["dx"] * index
        assert np.allclose(drawn, x[index], atol=2e-3 * step)
    else:
        assert np.isin(np.round(json.loads(coded["x"]), 3), np.round(x, 3)).mean() > 0.5


def test_uneven_positions_are_kept() -> None:
    x = np.array([0.0, 1.0, 5.0, 5.5])
    assert json.loads(encode_curve(x, x, limit=100)["x"]) == [0.0, 1.0, 5.0, 5.5]


def test_arrays_of_different_length_are_refused() -> None:
    with pytest.raises(RotorwiseError, match="x 3, y 2"):
        encode_curve(np.arange(3), np.arange(2), limit=10)


@given(arrays(float, st.integers(0, 50), elements=st.floats(allow_nan=True, allow_infinity=True)))
def test_numbers_round_and_turn_what_is_not_finite_into_null(values: np.ndarray) -> None:
    back = json.loads(numbers(values))
    for value, copy in zip(values, back, strict=True):
        if abs(value) < 1.79e308:
            assert copy == pytest.approx(value, rel=6e-4, abs=1e-320)
        else:
            assert copy is None


@given(st.recursive(st.none() | st.booleans() | st.integers() | st.text(), lambda inner: st.lists(inner)))
def test_json_comes_back_and_holds_no_markup(value: object) -> None:
    text = to_json(value)
    assert json.loads(text) == value
    assert not set("<>&") & set(text)


def test_json_of_nan_is_null() -> None:
    assert to_json({"a": math.nan, "b": np.array([1.0, math.inf])}) == '{"a":null,"b":[1,null]}'


@given(st.integers(1, 40), st.integers(1, 40), st.integers(1, 12), st.integers(1, 12), st.integers(0, 99))
def test_pooled_map_keeps_the_highest_level(height: int, width: int, rows: int, columns: int, seed: int) -> None:
    levels = np.random.default_rng(seed).normal(size=(height, width))
    pooled, per_row, per_column = pool_map(levels, rows, columns)
    assert pooled.shape[0] <= rows
    assert pooled.shape[1] <= columns
    row, column = np.unravel_index(levels.argmax(), levels.shape)
    assert pooled[row // per_row, column // per_column] == levels.max()

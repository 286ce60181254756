"""The extended machine file: it is the machine, it says where its values come from, it harms no other file."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.gap.extended_file import (
    FIRST_WORDS,
    ExtendedFileError,
    check_extended_place,
    extended_text,
    write_extended,
)
from rotorwise.diagnose.gap.result import KINDS
from rotorwise.simulators.effect import Effect, effect_catalogue
from rotorwise.simulators.machine import machine_from_toml

from .made_results import made


@pytest.mark.parametrize("kind", KINDS)
def test_file_gives_the_machine_back_unchanged(kind: str, tmp_path: Path) -> None:
    result, path = made(kind), tmp_path / "extended.toml"
    write_extended(result, path, recordings=[tmp_path / "a.csv"], notes=("Load not known.",))
    assert machine_from_toml(path) == result.extended
    assert machine_from_toml(path).to_toml() == result.extended.to_toml()


def test_file_simulates_as_the_machine_itself(tmp_path: Path) -> None:
    result, path = made("one cause"), tmp_path / "extended.toml"
    write_extended(result, path)
    runs = [
        one.simulate(speed_rpm=3000.0, duration_s=0.1, rate_hz=2000.0).signals
        for one in (machine_from_toml(path), result.extended)
    ]
    np.testing.assert_array_equal(*runs)


@st.composite
def any_effect(draw: st.DrawFn) -> Effect:
    effect = draw(st.sampled_from(sorted(effect_catalogue().items())))[1]
    return effect(**{one.name: draw(st.floats(*one.bounds)) for one in effect.parameters() if one.prior})


@given(effects=st.lists(any_effect(), max_size=3), text=st.text(max_size=200))
@settings(max_examples=40, deadline=None)
def test_any_effects_and_any_remark_survive(effects: list[Effect], text: str) -> None:
    result = replace(made("several causes", effects=effects), remarks=(text,), sentence=text or "x")
    assert machine_from_toml(extended_text(result, sources=[text], notes=[text])) == result.extended


def test_values_carry_their_interval_and_what_they_were() -> None:
    lines = extended_text(made("one cause")).splitlines()
    assert "moment_kg_m = 0.00011  # 8.8e-05 to 0.000132 kg.m" in lines
    assert 'effect = "unbalance"  # probability 0.97' in lines
    assert "coupling_stiffness_n_m = 81010.2  # calibrated, fitted beside what was added; given: 81400" in lines


def test_a_value_that_the_data_do_not_tell_says_so() -> None:
    result = made("one cause")
    cause = result.causes[0]
    open_angle = replace(cause.parameters["angle_rad"], low=-3.0, high=3.0, is_told=False)
    open_one = replace(cause, parameters={**cause.parameters, "angle_rad": open_angle})
    lines = extended_text(replace(result, causes=(open_one,))).splitlines()
    assert "angle_rad = 0.7  # not told by the data: -3 to 3 rad possible" in lines


def test_two_effects_of_one_name_keep_their_own_intervals() -> None:
    unbalance = effect_catalogue()["unbalance"]
    both = [unbalance(moment_kg_m=1e-4, at="disc"), unbalance(moment_kg_m=2e-4, at="coupling")]
    text = extended_text(made("several causes", effects=both))
    assert re.findall(r"^moment_kg_m = .*# (\S+) to", text, flags=re.MULTILINE) == ["8e-05", "0.00016"]


def test_head_says_verdict_and_origin_without_a_date() -> None:
    result = made("one cause")
    text = extended_text(result, sources=["1500.csv", "2600.csv"])
    head = " ".join(line.lstrip("# ") for line in text.splitlines() if line.startswith("#"))
    assert text.startswith(FIRST_WORDS)
    assert "Cause: unbalance at disc" in head
    assert "Fitted to 1500 rpm; 3300 rpm; 4000 rpm at path_1, path_2, path_4. Held out: 2600 rpm." in head
    assert "Recordings: 1500.csv, 2600.csv." in head
    assert not re.search(r"\d{4}-\d\d-\d\d|\d\d:\d\d", text)
    assert extended_text(result, sources=["1500.csv", "2600.csv"]) == text
    assert "No effect was added" in extended_text(made("cannot tell"))


def test_only_an_earlier_extended_machine_is_replaced(tmp_path: Path) -> None:
    path, foreign = tmp_path / "extended.toml", tmp_path / "mine.toml"
    result = made("one cause")
    write_extended(made("none"), path)
    with pytest.raises(ExtendedFileError, match=r"exists already.*--force"):
        write_extended(result, path)
    write_extended(result, path, force=True)
    assert machine_from_toml(path) == result.extended
    foreign.write_text(result.machine.to_toml())
    with pytest.raises(ExtendedFileError, match="never replaced"):
        write_extended(result, foreign, force=True)
    assert foreign.read_text() == result.machine.to_toml()
    assert sorted(one.name for one in tmp_path.iterdir()) == ["extended.toml", "mine.toml"]


def test_places_that_would_do_harm_are_refused(tmp_path: Path) -> None:
    recording = tmp_path / "1500.csv"
    for path, words in (
        (tmp_path / "1500.toml", "sidecar"),
        (tmp_path / "recording.toml", "sidecar"),
        (tmp_path / "a.txt", "ends in .toml"),
        (tmp_path / "none" / "a.toml", "does not exist"),
        (tmp_path / "machine.toml", "is to be extended"),
    ):
        with pytest.raises(ExtendedFileError, match=words):
            check_extended_place(path, force=True, recordings=[recording], machine=str(tmp_path / "machine.toml"))
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(ExtendedFileError, match="is a folder"):
        check_extended_place(tmp_path / "folder.toml", force=True)

"""Recipes: what may stand in one, and how a signal's number becomes a machine."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.datasets.recipe import Recipe
from rotorwise.datasets.recipe_draw import draw_signal, label_columns, position_of, severity_of, split_of
from rotorwise.datasets.recipe_file import load_recipe, recipe_from_json, shipped_recipes
from rotorwise.datasets.recipe_parts import MOST_BYTES, MOST_RUNS, Parts
from rotorwise.datasets.recipe_values import Choice, parse_choice
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.parameter import LogNormal, Parameter, Uniform

SMALL = Path(__file__).with_name("recipe_small.toml")


def changed(**entries: object) -> Recipe:
    """Return the small recipe with some entries changed."""
    return recipe_from_json(json.dumps({**json.loads(load_recipe(SMALL).source), **entries}, sort_keys=True))


def generator(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


# Choices


@given(low=st.floats(0.01, 10), width=st.floats(0.1, 10), cells=st.integers(1, 5), seed=st.integers(0, 99))
def test_a_range_gives_one_value_from_each_of_its_parts(low: float, width: float, cells: int, seed: int) -> None:
    for spacing, scale in (("linear", float), ("log", np.log)):
        choice = parse_choice("x", {"from": low, "to": low + width, "cells": cells, "spacing": spacing})
        edges = np.linspace(scale(low), scale(low + width), cells + 1)
        values = [scale(choice.draw(generator(seed), cell)) for cell in range(choice.count)]
        assert len(values) == cells
        assert all(a - 1e-9 <= v <= b + 1e-9 for a, v, b in zip(edges, values, edges[1:], strict=False))


def test_a_logarithmic_range_has_its_median_at_the_geometric_mean() -> None:
    choice = parse_choice("x", {"from": 1.0, "to": 100.0, "spacing": "log"})
    values = [choice.draw(generator(seed)) for seed in range(2000)]
    # The median of 2000 draws scatters by sqrt(pi/2/2000) of ln 100 / sqrt(12), 4 %; four times that.
    assert np.median(values) == pytest.approx(10.0, rel=0.16)


def test_whole_numbers_are_equally_likely_to_the_ends() -> None:
    choice = parse_choice("x", {"from": 1, "to": 3, "whole": True})
    counts = np.bincount([int(choice.draw(generator(seed))) for seed in range(3000)], minlength=4)
    assert counts[0] == 0
    # Binomial deviation 26; four times that.
    assert np.abs(counts[1:] - 1000).max() < 104


def test_a_prior_stays_within_the_bounds_and_otherwise_keeps_its_shape() -> None:
    declared = Parameter("k", "N/m", 1.0, (0.5, 2.0), "stiffness", "test", LogNormal(1.0, 2.0))
    values = np.log([parse_choice("k", "prior", declared).draw(generator(seed)) for seed in range(2000)])
    assert np.abs(values).max() <= np.log(2.0)
    # A normal distribution cut at one deviation on both sides has 0.540 of its deviation; 3 % is two of ours.
    assert values.std() == pytest.approx(0.540 * np.log(2.0), rel=0.04)


def test_a_prior_out_of_reach_of_its_bounds_is_an_error_and_no_endless_search() -> None:
    with pytest.raises(InvalidValueError, match="gave no value from 10 to 11"):
        Choice(low=10.0, high=11.0, prior=Uniform(0.0, 1.0)).draw(generator(1))


@pytest.mark.parametrize(
    ("given_value", "words"),
    [
        (True, "allowed: a number"),
        ({"grid": []}, "allowed: a number"),
        ({"grid": ["a"]}, "no finite number"),
        ({"from": 2, "to": 1}, "rising"),
        ({"from": 0, "to": 1, "spacing": "log"}, "log from more than 0"),
        ({"from": 1, "to": 2, "cells": 0}, "cells = 0"),
        ({"from": 1.5, "to": 3, "whole": True}, "whole ends"),
        ({"around": 1, "factor": 1}, "factor above 1"),
        ({"from": -1, "to": 1}, "allowed: 0 to 5 N/m"),
        ({"grid": [1, 9]}, "allowed: 0 to 5 N/m"),
        (float("nan"), "nan"),
        (10**400, "no finite number"),
        ({"grid": [10**400]}, "no finite number"),
        ({"around": 1, "factor": 1e300}, "no finite number"),
        ({"around": 1, "factor": 1e9}, "at most 1000"),
        ({"around": 9, "factor": 1.1}, "allowed: 0 to 5 N/m"),
        ({"from": 1, "to": 2, "cells": 10**9}, "1 to 100000"),
        ("often", "allowed: a number"),
    ],
)
def test_what_is_no_choice_is_refused(given_value: object, words: str) -> None:
    declared = Parameter("k", "N/m", 1.0, (0.0, 5.0), "stiffness", "test")
    with pytest.raises(InvalidValueError, match=words):
        parse_choice("k", given_value, declared)


# Numbers, parts, splits


def test_numbers_and_places_are_one_to_one() -> None:
    recipe = load_recipe(SMALL)
    places = [position_of(recipe, number) for number in range(recipe.signals)]
    assert recipe.signals == 6 * 2 * (1 + 2 * 2)
    assert len({(*p.run, p.record) for p in places}) == recipe.signals
    assert [p.number for p in places] == list(range(recipe.signals))
    with pytest.raises(InvalidValueError, match="allowed: 0 to"):
        position_of(recipe, recipe.signals)


@settings(max_examples=25, deadline=None)
@given(
    draws=st.integers(1, 40),
    instances=st.integers(1, 90),
    duration_s=st.sampled_from([0.2, 100.0, 3000.0]),
    records=st.integers(1, 3),
    limit=st.none() | st.integers(1, 5000),
)
def test_parts_hold_every_number_once(
    draws: int, instances: int, duration_s: float, records: int, limit: int | None
) -> None:
    machine = json.loads(load_recipe(SMALL).source)["machine"][0]
    machine["records"] = records
    machine["case"][1]["instances"] = instances
    other = {**machine, "name": "other", "case": machine["case"][:1]}
    recipe = changed(draws=draws, splits={"all": 1.0}, duration_s=duration_s, machine=[machine, other])
    parts = Parts(recipe, limit)
    numbers = [list(parts.numbers(part)) for part in range(parts.count)]
    assert [number for one in numbers for number in one] == list(range(min(recipe.signals, limit or recipe.signals)))
    assert all(0 < len(one) <= MOST_RUNS * records for one in numbers)
    # No run is computed in two parts.
    assert all(len(one) % records == 0 for one in numbers[:-1])
    # A shorter dataset is the beginning of the longer one: parts keep their place.
    whole = Parts(recipe)
    assert all(list(whole.numbers(part))[: len(one)] == one for part, one in enumerate(numbers))


def test_no_part_of_long_signals_is_larger_than_the_memory_allows() -> None:
    parts = Parts(changed(duration_s=5000.0))
    # Four probes of 64 bits.
    assert all(len(parts.numbers(part)) * 4 * 8 * 5_000_000 <= MOST_BYTES for part in range(3))
    assert [len(parts.numbers(part)) for part in range(3)] == [1, 1, 1]


def test_a_hundred_thousand_signals_are_planned_without_listing_them() -> None:
    begun = time.process_time()
    recipe = changed(draws=10_000)
    parts = Parts(recipe)
    assert recipe.signals == 100_000
    last = parts.numbers(parts.count - 1)[-1]
    assert draw_signal(recipe, position_of(recipe, last)).position.number == 99_999
    assert time.process_time() - begun < 2.0


@given(shares=st.lists(st.floats(0.05, 1.0), min_size=1, max_size=4), draws=st.integers(1, 300))
def test_splits_meet_their_shares_in_every_run_of_draws(shares: list[float], draws: int) -> None:
    recipe = changed(splits={"all": 1.0})
    total = sum(shares)
    recipe = replace(recipe, splits={str(i): share / total for i, share in enumerate(shares)})
    found = [split_of(recipe, draw) for draw in range(draws)]
    for name, share in recipe.splits.items():
        # The golden ratio's discrepancy is below (ln N / ln golden + 2) / N.
        assert abs(found.count(name) - share * draws) <= np.log(draws) / np.log(1.618) + 2


def test_a_machine_draw_is_one_machine_in_one_split() -> None:
    recipe = load_recipe(SMALL)
    drawn = [draw_signal(recipe, position_of(recipe, number)) for number in range(recipe.signals)]
    for draw in range(recipe.draws):
        own = [one for one in drawn if one.position.draw == draw]
        assert len({one.machine.values["coupling_stiffness_n_m"] for one in own}) == 1
        assert len({(one.position.speed, one.speed_rpm) for one in own}) == 2
    assert len({one.machine.values["coupling_stiffness_n_m"] for one in drawn}) == recipe.draws
    assert len({one.seed for one in drawn}) == recipe.signals


def test_a_fault_keeps_its_values_over_speeds_and_its_severity_is_a_label() -> None:
    recipe = load_recipe(SMALL)
    drawn = [draw_signal(recipe, position_of(recipe, number)) for number in range(recipe.per_round)]
    column = "effect.coupling_misalignment.offset_phase_rad"
    phases: dict[int, set[float]] = {}
    for one in drawn[2:]:
        phases.setdefault(one.position.fault, set()).add(one.values[column])
    assert [len(values) for values in phases.values()] == [1, 1, 1, 1]
    assert len(set.union(*phases.values())) == 4
    offsets = [severity_of(recipe, one.values)["misalignment_offset_m"] for one in drawn]
    assert offsets == [0.0] * 2 + [1e-5] * 4 + [4e-5] * 4
    assert {one.machine.effects[0].values()["offset_m"] for one in drawn[2:]} == {1e-5, 4e-5}


def test_a_further_random_value_does_not_change_the_others() -> None:
    recipe = load_recipe(SMALL)
    machine = json.loads(recipe.source)["machine"][0]
    machine["parameters"]["unbalance_kg_m"] = {"from": 1e-5, "to": 2e-4}
    more = changed(machine=[machine])
    for number in (0, 5, 37):
        one, other = (draw_signal(r, position_of(r, number)) for r in (recipe, more))
        assert other.values["machine.coupling_stiffness_n_m"] == one.values["machine.coupling_stiffness_n_m"]
        assert (other.speed_rpm, other.seed, other.chain) == (one.speed_rpm, one.seed, one.chain)


# Files


@pytest.mark.parametrize("name", shipped_recipes())
def test_a_shipped_recipe_is_whole(name: str) -> None:
    recipe = load_recipe(name)
    assert recipe.name == name
    assert recipe.meaning
    assert recipe.limits
    assert recipe_from_json(recipe.source).fingerprint == recipe.fingerprint
    columns = label_columns(recipe)
    # The first and the last signal of every case can be drawn, and its labels have columns.
    number = 0
    for machine in recipe.machines:
        for case in machine.cases:
            for at in (number, number + case.faults * machine.conditions - 1, number + recipe.per_round):
                if at < recipe.signals:
                    drawn = draw_signal(recipe, position_of(recipe, at))
                    assert set(drawn.values) <= set(columns)
                    assert drawn.position.case is case
            number += case.faults * machine.conditions


def test_everything_that_changes_the_content_changes_the_fingerprint() -> None:
    recipe = load_recipe(SMALL)
    machine = json.loads(recipe.source)["machine"][0]
    prints = {recipe.fingerprint}
    prints |= {changed(**{key: value}).fingerprint for key, value in (("seed", 8), ("draws", 7), ("duration_s", 0.3))}
    prints.add(changed(machine=[{**machine, "speed_rpm": 1500}]).fingerprint)
    prints.add(changed(machine=[{**machine, "preset": "as_printed"}]).fingerprint)
    assert len(prints) == 6


def test_the_fingerprint_knows_priors_and_defaults_of_this_version(monkeypatch: pytest.MonkeyPatch) -> None:
    from rotorwise.simulators import amb_rotor
    from rotorwise.simulators import machine as machines

    before = load_recipe(SMALL).fingerprint
    own = tuple(
        replace(one, default=one.default * 1.1) if one.name == "shaft_length_m" else one
        for one in amb_rotor.definition.parameters
    )
    other = replace(amb_rotor, definition=replace(amb_rotor.definition, parameters=own))
    monkeypatch.setattr(machines, "machine_catalogue", lambda: {"amb_rotor": other})
    recipe_from_json.cache_clear()
    try:
        assert load_recipe(SMALL).fingerprint != before
    finally:
        recipe_from_json.cache_clear()


def test_a_machine_file_becomes_part_of_the_recipe(tmp_path: Path) -> None:
    from rotorwise.simulators import amb_rotor

    own = tmp_path / "mine.toml"
    own.write_text(amb_rotor.with_parameters(unbalance_kg_m=3e-4).to_toml(), encoding="utf-8")
    text = SMALL.read_text(encoding="utf-8").replace('machine = "amb_rotor"', 'machine = "mine.toml"')
    (tmp_path / "r.toml").write_text(text, encoding="utf-8")
    recipe = load_recipe(tmp_path / "r.toml")
    own.unlink()
    again = recipe_from_json(recipe.source)
    assert again.machines[0].name == "mine"
    assert draw_signal(again, position_of(again, 0)).machine.values["unbalance_kg_m"] == 3e-4


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("format = 1", "format = 2", "allowed: format = 1"),
        ("format = 1", "format = ", "not valid TOML"),
        ("seed = 7", "seed = -1", "seed = -1"),
        ("seed = 7", "", "seed = None"),
        ("rate_hz = 1000", "", "rate_hz = None; allowed: more than 0; there is no default"),
        ("draws = 6", "draws = 0", "draws = 0"),
        ("draws = 6", "draws = 1", "none falls to the split"),
        ("draws = 6", "draws = 1000000000", "Lower draws"),
        ("train = 0.5", "train = 0.4", "add up to 0.9"),
        ('name = "small"', 'name = "small"\nsede = 1', "unknown entry 'sede'"),
        ('machine = "amb_rotor"', 'machine = "amb"', "Machine 'amb' is unknown"),
        ('"path_1"', '"path_9"', "No probe 'path_9'"),
        ("speed_rpm = { from = 1200, to = 2400, cells = 2 }", "", "has no speed_rpm; there is no default"),
        ("speed_rpm = {", "load = 3.0\nspeed_rpm = {", "has none. Leave it out"),
        ("coupling_stiffness_n_m =", "coupling =", "no parameter 'coupling'"),
        ('coupling_stiffness_n_m = "prior"', "coupling_stiffness_n_m = { grid = [1e5, 2e5] }", "Put it into the cases"),
        ('effect = "coupling_misalignment"', 'effect = "tooth_crack"', "tooth_crack"),
        ("offset_m = {", "offset = {", "no parameter 'offset'"),
        ('name = "healthy"', 'name = "parallel misalignment"', "two cases 'parallel misalignment'"),
        ("pulses_per_revolution = 1", "pulses_per_revolution = { from = 1, to = 4 }", "one number for all signals"),
        ("pulses_per_revolution = 1", "pulses = 1", "no setting 'pulses'"),
        ('effect.coupling_misalignment.offset_m"]', 'effect.unbalance.moment_kg_m"]', "comes from"),
        ("duration_s = 0.2", "duration_s = 1e9", "Change duration_s or rate_hz"),
        ("seed = 7", "seed = 2026-01-01", "2026-01-01 is a date or a time"),
        ("seed = 7", "seed = 1" + "0" * 5000, "not valid TOML"),
        ("seed = 7", "seed = 7\nlimits = " + "[" * 20_000, "not valid TOML"),
        ("seed = 7", "seed = 7\n" + "a." * 3000 + "b = 1", "without end"),
        ("rate_hz = 1000", "rate_hz = 1" + "0" * 400, "allowed: more than 0"),
        ('meaning = "For tests"', 'meaning = "\\u001b[31m"', "printable"),
        ('name = "healthy"', 'name = "a\\u0000"', "printable"),
        ('noise = { "m" =', 'noise = { "mm" =', "no recorded probe is in 'mm'; allowed: m."),
        ("[chain]", '[chain]\nfull_scale = { "m/s2" = 5 }', "no recorded probe is in 'm/s2'; allowed: m."),
        ("[chain]", '[chain]\nfull_scale = { "m" = 0 }', "more than 0"),
        ("[chain]", "[chain]\nbits = 5000", "at most 32"),
        ("[chain]", "[chain]\nbits = 2.7", "whole = true"),
        ("[chain]", "[chain]\nbits = { from = 12, to = 24 }", "whole = true"),
        ("[chain]", "[chain]\nanti_alias_hz = 300\nanti_alias_order = 100000", "at most 32"),
        ("pulses_per_revolution = 1", "pulses_per_revolution = 8", "320 pulses a second at 2400 rpm; allowed at 1000"),
        ("pulses_per_revolution = 1", "pulses_per_revolution = 1\npulse_width = { from = 0.01, to = 0.5 }", "Hz: 10,"),
    ],
)
def test_a_mistake_in_a_recipe_is_named(old: str, new: str, words: str, tmp_path: Path) -> None:
    text = SMALL.read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "r.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InvalidValueError, match=r"Recipe .*r\.toml") as caught:
        load_recipe(tmp_path / "r.toml")
    assert words in str(caught.value)


def test_a_mark_of_the_byte_order_is_no_mistake(tmp_path: Path) -> None:
    (tmp_path / "r.toml").write_bytes(b"\xef\xbb\xbf" + SMALL.read_bytes())
    assert load_recipe(tmp_path / "r.toml") == load_recipe(SMALL)


def test_an_unknown_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(InvalidValueError, match="Did you mean tiny"):
        load_recipe("tinny")
    with pytest.raises(InvalidValueError, match="cannot be read"):
        load_recipe("nowhere.toml")


def test_the_recipe_of_the_manual_is_one(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "datasets" / "README.md").read_text(encoding="utf-8")
    (tmp_path / "r.toml").write_text(text.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    recipe = load_recipe(tmp_path / "r.toml")
    # Speeds x loads x records x (healthy + instances x grid).
    assert recipe.signals == 200 * 4 * 2 * 2 * (1 + 3 * 2)

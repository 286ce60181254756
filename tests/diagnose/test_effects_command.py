"""``rotorwise effects``: the whole catalogue in one screen, everything about one effect, JSON, wrong names."""

import json

import pytest
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.machine import machine_catalogue

from . import command

CATALOGUE = effect_catalogue()


def run(*arguments, width=80):
    return command.run("effects", *arguments, environment={"COLUMNS": str(width)})


def test_list_has_one_row_an_effect():
    lines = run().stdout.splitlines()
    assert all(len(line) <= 80 for line in lines)
    first = [line.split()[0] for line in lines]
    assert [first.count(name) for name in CATALOGUE] == [1] * len(CATALOGUE)
    assert len(lines) <= len(CATALOGUE) + 5


@pytest.mark.parametrize("name", ["unbalance", "mains_hum", "speed_wander"])
def test_one_effect_with_all_that_it_declares(name):
    answer = run(name)
    assert answer.returncode == 0
    words = " ".join(answer.stdout.split())
    effect = CATALOGUE[name]
    assert effect.MEANING in words
    assert effect.CHECK in words
    for parameter in effect.parameters():
        assert parameter.name in words
        assert f"default {parameter.default:.4g}" in words
    for rival in effect.RIVALS:
        assert rival in words
    assert all(len(line) <= 80 for line in answer.stdout.splitlines())


def test_lines_are_named_with_their_growth():
    assert "1X (lateral, force: speed^2, not with load)" in run("unbalance").stdout
    assert "50 Hz" in " ".join(run("mains_hum").stdout.split())


def test_json_of_one_and_of_all():
    one, every = json.loads(run("rub", "--json").stdout), json.loads(run("--json").stdout)
    assert [data["name"] for data in every] == list(CATALOGUE)
    assert one == next(data for data in every if data["name"] == "rub")
    assert set(one["lines"]) <= set(machine_catalogue())
    for data in every:
        assert data["lines"], f"no machine has the part of {data['name']}"
        for parameter in data["parameters"]:
            assert parameter["lowest"] <= parameter["default"] <= parameter["highest"]


def test_wrong_name_says_what_is_allowed():
    answer = run("unbalanse")
    assert answer.returncode == 2
    assert "Did you mean unbalance?" in answer.stderr
    assert "looseness" in answer.stderr
    assert not answer.stdout

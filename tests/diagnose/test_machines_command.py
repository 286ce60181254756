"""``rotorwise machines``: the list, everything about one machine, a file that reads back, wrong names."""

import json

import pytest
from rotorwise.simulators.machine import machine_catalogue, machine_from_toml

from . import command

CATALOGUE = machine_catalogue()


def run(*arguments):
    return command.run("machines", *arguments, environment={"COLUMNS": "80"})


def test_list_names_every_machine():
    words = run().stdout
    for name, machine in CATALOGUE.items():
        assert name in words
        assert machine.definition.meaning.split()[0] in words


@pytest.mark.parametrize("name", CATALOGUE)
def test_one_machine_with_probes_load_and_parameters(name):
    answer = run(name)
    assert answer.returncode == 0
    assert all(len(line) <= 80 for line in answer.stdout.splitlines())
    words = " ".join(answer.stdout.split())
    machine = CATALOGUE[name]
    for probe in machine.bare_assembly().probes:
        assert probe.name in words
    for parameter in machine.definition.parameters:
        assert parameter.name in words
        assert f"{machine.values[parameter.name]:.6g}" in words


@pytest.mark.parametrize("name", CATALOGUE)
def test_file_reads_back_as_the_same_machine(name):
    text = run(name, "--toml").stdout
    read = machine_from_toml(text)
    assert read.values == CATALOGUE[name].values
    assert set(read.changed) == {one.name for one in CATALOGUE[name].definition.parameters}
    assert "# " in text


def test_preset_and_file_are_taken(tmp_path):
    shown = json.loads(run("test_rig", "--preset", "adi", "--json").stdout)
    assert shown["preset"] == "adi"
    values = CATALOGUE["test_rig"].preset("adi").values
    assert {one["name"]: one["value"] for one in shown["parameters"]} == values
    (tmp_path / "own.toml").write_text(run("test_rig", "--preset", "adi", "--toml").stdout, encoding="utf-8")
    again = json.loads(run(str(tmp_path / "own.toml"), "--json").stdout)
    assert again == shown


def test_json_of_all_is_a_list():
    assert [one["name"] for one in json.loads(run("--json").stdout)] == list(CATALOGUE)


@pytest.mark.parametrize(
    "arguments", [("amb_roto",), ("--toml",), ("amb_rotor", "--preset", "none"), ("amb_rotor", "--toml", "--json")]
)
def test_wrong_use_says_what_is_allowed(arguments):
    answer = run(*arguments)
    assert answer.returncode == 2
    assert answer.stdout == ""
    assert "allowed: " in answer.stderr
    assert "Traceback" not in answer.stderr


def test_a_file_with_a_byte_order_mark_is_read_and_one_without_machine_is_named(tmp_path):
    (tmp_path / "mark.toml").write_text(run("amb_rotor", "--toml").stdout, encoding="utf-8-sig")
    assert run(str(tmp_path / "mark.toml")).returncode == 0
    (tmp_path / "none.toml").write_text("format = 1\n", encoding="utf-8")
    answer = run(str(tmp_path / "none.toml"))
    assert answer.returncode == 2
    assert "none.toml names no machine; allowed: machine = " in answer.stderr

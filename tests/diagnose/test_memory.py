"""A record that would fill the memory is refused before it does, and a part of it is looked at."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from rotorwise.diagnose import look_read, memory
from rotorwise.diagnose.memory import MemoryNeed, available_bytes, check_fits
from rotorwise.simulators.errors import InvalidValueError

from .look_files import RATE, payload, run, write_csv

TIME = np.arange(30_000) / RATE
SPEED = 12 + 3 * TIME
ANGLE = np.cumsum(SPEED) / RATE
NEED = MemoryNeed(always=1e6, a_sample=30.0, a_value=10.0)


@pytest.fixture(scope="module")
def run_up(tmp_path_factory):
    """6 s from 12 to 30 Hz: one probe, a pulse a turn."""
    noise = np.random.default_rng(0).normal(0, 1, TIME.size)
    columns = {"x (um)": 40 * np.cos(2 * np.pi * ANGLE) + noise, "tacho (V)": 5.0 * ((ANGLE % 1.0) < 0.05)}
    return write_csv(tmp_path_factory.mktemp("memory") / "run_up.csv", columns)


def free(monkeypatch: pytest.MonkeyPatch, amount: float | None) -> None:
    """Let the machine say that so many bytes are free."""
    for module in (memory, look_read):
        monkeypatch.setattr(module, "available_bytes", lambda: amount)


def test_what_this_machine_says_is_free():
    found = available_bytes()
    if not Path("/proc/meminfo").exists():
        assert found is None
        return
    assert found is not None
    assert 0 < found <= os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.parametrize(("limit", "used", "left"), [("5000000", "2000000", 3e6), ("max", "2000000", 8e9 * 1.024)])
def test_the_limit_of_a_container_counts(tmp_path, monkeypatch, limit, used, left):
    for name, text in (("meminfo", "MemTotal: 9000000 kB\nMemAvailable: 8000000 kB\n"), ("max", limit), ("now", used)):
        (tmp_path / name).write_text(text, encoding="ascii")
    monkeypatch.setattr(memory, "_MEMINFO", tmp_path / "meminfo")
    monkeypatch.setattr(memory, "_GROUPS", ((str(tmp_path / "max"), str(tmp_path / "now")),))
    assert available_bytes() == pytest.approx(left)


def test_a_machine_that_does_not_say_is_not_asked(tmp_path, monkeypatch):
    monkeypatch.setattr(memory, "_MEMINFO", tmp_path / "absent")
    monkeypatch.setattr(memory, "_GROUPS", ())
    assert available_bytes() is None
    check_fits(NEED, samples=10**12, channels=4, rate_hz=1e3)


def test_the_length_that_is_named_fits_and_a_longer_one_does_not(monkeypatch):
    free(monkeypatch, 51e6)
    samples = NEED.samples_within(51e6, 2)
    assert samples == 1_000_000
    check_fits(NEED, samples=samples, channels=2, rate_hz=1e4)
    with pytest.raises(InvalidValueError, match=r"100 s fit\. Take a part with --start and --stop"):
        check_fits(NEED, samples=samples + 1, channels=2, rate_hz=1e4)
    # Memory that the record holds already need not be free.
    check_fits(NEED, samples=samples + 1, channels=2, rate_hz=1e4, held_bytes=16e6)


@pytest.mark.parametrize("amount", [1e6, 0.3e9 + 4e5])
def test_orders_says_what_to_do_before_memory_is_full(run_up, monkeypatch, capsys, amount):
    free(monkeypatch, amount)
    assert run(monkeypatch, "orders", run_up, "--tacho", "tacho") == 3
    said = capsys.readouterr().err
    assert "6 s of 1 channel need about" in said
    assert "--start and --stop" in said
    free(monkeypatch, None)
    assert run(monkeypatch, "orders", run_up, "--tacho", "tacho") == 0


def test_memory_that_ends_during_the_work_is_no_crash(run_up, monkeypatch, capsys):
    def full(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("rotorwise.diagnose.orders.measure", full)
    assert run(monkeypatch, "orders", run_up, "--tacho", "tacho") == 3
    assert "no memory left. Take a part with --start and --stop" in capsys.readouterr().err


def test_a_part_fits_where_the_whole_does_not(run_up, monkeypatch, capsys):
    whole = 0.3e9 + TIME.size * 43.0
    free(monkeypatch, whole - 4e5)  # a third less than the samples need
    assert run(monkeypatch, "orders", run_up, "--tacho", "tacho", "--start", "1", "--stop", "3", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    # From 15 to 21 Hz; without the percent at each end.
    assert answer["speed"]["lowest_rpm"] == pytest.approx(60 * 15, rel=0.03)
    assert answer["speed"]["highest_rpm"] == pytest.approx(60 * 21, rel=0.03)
    assert "from 1 to 3 s" in answer["warnings"][0]


@pytest.mark.parametrize("command", ["envelope", "sidebands"])
def test_the_other_looks_take_a_part_too(run_up, monkeypatch, capsys, tmp_path, command):
    page = tmp_path / "part.html"
    arguments = ("--tacho", "tacho", "--start", "2", "--report", page)
    assert run(monkeypatch, command, run_up, *arguments) == 0
    assert "from 2 to 6 s" in capsys.readouterr().out.replace("\n", " ")
    assert payload(page)["speedHz"] == pytest.approx(24.0, rel=0.01)  # the mean of 18 and 30 Hz


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("--start", "-1"), 2, "the start before the stop"),
        (("--start", "3", "--stop", "2"), 2, "the start before the stop"),
        (("--start", "nan"), 2, "the start before the stop"),
        (("--start", "inf"), 2, "the start before the stop"),
        (("--stop", "nan"), 2, "the start before the stop"),
        (("--start", "99"), 3, "Part of 0 samples"),
        (("--start", "1", "--stop", "1.01"), 3, "Part of 50 samples"),
    ],
)
def test_parts_that_are_none(run_up, monkeypatch, capsys, arguments, code, message):
    assert run(monkeypatch, "orders", run_up, "--tacho", "tacho", *arguments) == code
    assert message in capsys.readouterr().err

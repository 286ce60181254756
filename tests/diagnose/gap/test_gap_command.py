"""`rotorwise gap`: a hidden unbalance is found from files alone; refusals come before the work, without traceback."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rotorwise.datasets.simulated import record_machine
from rotorwise.datasets.write import write_recording
from rotorwise.diagnose.cli import app
from rotorwise.diagnose.gap import explain
from rotorwise.diagnose.gap.predict import UnpredictableError
from rotorwise.diagnose.gap.result import KINDS
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import find_machine, machine_from_toml
from rotorwise.simulators.sensor_chain import SensorChain

from ..command import Done, run
from .made_results import made

ROTOR = find_machine("amb_rotor")
MOMENT, ANGLE = 2e-4, 0.7
#: A search over one effect, against nothing and something unknown, takes seconds.
FEW = [word for name in effect_catalogue() if name != "unbalance" for word in ("--without", name)]


def rotorwise(*arguments: object) -> Done:
    done = run("gap", *arguments)
    assert "Traceback" not in done.stderr + done.stdout, done.stderr
    return done


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    base = tmp_path_factory.mktemp("measured")
    (base / "baseline").mkdir()
    chain = SensorChain(pulses_per_revolution=1, noise={"m": 2e-8})
    faulty = ROTOR.with_effects(Unbalance(moment_kg_m=MOMENT, angle_rad=ANGLE))
    for i, speed in enumerate((1500.0, 2100.0, 3300.0, 4000.0)):
        for machine, name, seed in ((ROTOR, "baseline/", i), (faulty, "", 50 + i)):
            run = record_machine(machine, speed_rpm=speed, duration_s=2.0, rate_hz=2000.0, chain=chain, seed=seed)
            place = base / f"{name}{speed:.0f}.npz"
            write_recording(run.recording, place, file_format="npz", notes={}, remarks="", force=False)
    return base


@pytest.fixture(scope="module")
def answered(folder: Path) -> tuple[Done, Path]:
    out = folder / "out"
    out.mkdir()
    outputs = ("--report", out / "gap.html", "-o", out / "extended.toml", "--json")
    return rotorwise(folder, "--machine", "amb_rotor", *FEW, *outputs), out


def test_the_hidden_unbalance_is_found_from_the_files(answered: tuple[Any, Path]) -> None:
    done, _ = answered
    assert done.returncode == 0, done.stderr
    verdict = json.loads(done.stdout)["verdict"]
    assert verdict["kind"] == "one cause"
    cause = verdict["causes"][0]
    assert cause["effect"] == "unbalance"
    assert cause["probability"] > 0.9
    moment, angle = cause["parameters"]["moment_kg_m"], cause["parameters"]["angle_rad"]
    assert moment["value"] == pytest.approx(MOMENT, rel=0.1)
    assert moment["low"] < moment["value"] < moment["high"]
    assert angle["value"] == pytest.approx(ANGLE, abs=0.1)


def test_the_extended_machine_simulates_the_measured_motion(answered: tuple[Any, Path], folder: Path) -> None:
    _, out = answered
    made_again = out / "again.npz"
    recorded = ("--speed", 3300, "--duration", 2, "--rate", 2000, "-o", made_again)
    done = run("simulate", out / "extended.toml", *recorded)
    assert done.returncode == 0, done.stderr
    levels = []
    for path in (made_again, folder / "3300.npz"):
        with np.load(path) as content:
            levels.append(content["signals"][:4].std(axis=1))
    # The unbalance is known within about 3 %, and the rotor runs at a flank of its resonance.
    np.testing.assert_allclose(levels[0], levels[1], rtol=0.1)


def test_json_goes_to_stdout_and_files_are_told_on_stderr(answered: tuple[Any, Path]) -> None:
    done, out = answered
    assert f"report: {out / 'gap.html'}" in done.stderr
    assert f"extended machine: {out / 'extended.toml'}" in done.stderr
    formed = json.loads(done.stdout)
    assert formed["extended"] == machine_from_toml(out / "extended.toml").to_toml()
    page = (out / "gap.html").read_text(encoding="utf-8")
    assert formed["verdict"]["kind"] == "one cause"
    assert "unbalance" in page


# ---- the command around a made answer ----


@pytest.fixture
def answer(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Done]:
    """Return a function that runs the command in this process with a made result, or an error, as the answer."""

    def made_answer(result: Any, *arguments: object) -> Done:
        def explained(campaign: Any, machine: Any, **options: Any) -> Any:
            options["tell"]("searching")
            if isinstance(result, BaseException):
                raise result
            return result

        monkeypatch.setattr(explain, "explain_gap", explained)
        code = app(["gap", *map(str, arguments)], standalone_mode=False)
        return Done(arguments, code or 0, *capsys.readouterr())

    return made_answer


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_answer_is_shown_and_written(
    answer: Callable[..., Done], folder: Path, tmp_path: Path, kind: str
) -> None:
    outputs = ("--report", tmp_path / "a.html", "-o", tmp_path / "a.toml")
    done = answer(made(kind), folder, "--machine", "amb_rotor", *outputs)
    assert done.returncode == 0, done.stderr
    assert f"report: {tmp_path / 'a.html'}" in " ".join(done.stdout.splitlines())
    assert machine_from_toml(tmp_path / "a.toml") == made(kind).extended
    assert "<h1" in (tmp_path / "a.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("problem", "code", "words"),
    [
        (UnpredictableError("No motion. Change it."), 3, "No motion. Change it."),
        (np.linalg.LinAlgError("Singular matrix"), 1, "a mistake of rotorwise (LinAlgError: Singular matrix)"),
        (KeyError("x"), 1, "Please report it"),
    ],
)
def test_an_engine_that_fails_gives_a_message(
    answer: Callable[..., Done], folder: Path, problem: Exception, code: int, words: str
) -> None:
    done = answer(problem, folder, "--machine", "amb_rotor")
    assert done.returncode == code
    assert words in done.stderr
    assert done.stdout == ""


def test_an_unreadable_file_does_not_cost_the_answer(answer: Callable[..., Done], folder: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.npz"
    broken.write_bytes(b"PK\x03\x04 cut")
    done = answer(made("none"), folder, broken, "--machine", "amb_rotor")
    assert done.returncode == 3
    assert "broken.npz" in done.stderr
    assert "The model explains the data" in " ".join(done.stdout.split())


def test_refusals_come_before_the_work(answer: Callable[..., Done], folder: Path, tmp_path: Path) -> None:
    """The engine is never asked: it would raise."""
    page, mine, empty = tmp_path / "page.html", tmp_path / "mine.toml", tmp_path / "empty"
    page.write_text("<!DOCTYPE html>mine")
    mine.write_text(ROTOR.to_toml())
    empty.mkdir()
    rotor = ("--machine", "amb_rotor")
    for arguments, code, words in (
        ((folder, "--machine", "pump"), 2, "allowed: amb_rotor, gearbox"),
        ((folder, *rotor, "--preset", "adi"), 2, "no preset 'adi'"),
        ((folder, *rotor, "--without", "unbalanc"), 2, "Did you mean unbalance?"),
        ((folder, *rotor, "--load", "3"), 2, "has no load"),
        ((folder, *rotor, "--probe", "X=path_9"), 2, "no probe 'path_9'"),
        ((folder, "--machine", "test_rig"), 2, "none of its channels is a probe"),
        ((folder, *rotor, "--sidecar", empty / "no.toml"), 2, "no such file. Check --sidecar"),
        ((empty, *rotor), 2, "No recording to explain"),
        ((tmp_path / "nowhere", *rotor), 2, "no such file or folder"),
        ((folder, *rotor, "--report", page), 4, "--force"),
        ((folder, "--machine", mine, "-o", mine, "--force"), 4, "is to be extended"),
        ((folder, *rotor, "-o", folder / "1500.toml", "--force"), 4, "sidecar"),
    ):
        done = answer(AssertionError("asked"), *arguments)
        assert (done.returncode, done.stdout) == (code, ""), (arguments, done.stderr)
        assert words in done.stderr
    assert (page.read_text(), mine.read_text()) == ("<!DOCTYPE html>mine", ROTOR.to_toml())


def test_a_missing_machine_is_a_usage_error(folder: Path) -> None:
    done = rotorwise(folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert "--machine" in done.stderr

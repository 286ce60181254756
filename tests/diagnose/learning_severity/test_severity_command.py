"""``rotorwise severity`` from a dataset to an estimate, its files, and what it refuses."""

import json
import pickle
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rotorwise.datasets.generate import build
from rotorwise.diagnose.learning.severity.conformal import ConformalRegressor
from rotorwise.diagnose.learning.severity.model_file import (
    SeverityFileError,
    load_model,
    model_bytes,
    model_versions,
    save_model,
)

from ..command import Done, run

RECIPE = Path(__file__).parent / "recipe_small.toml"


def rotorwise(*words: object, cwd: Path | None = None) -> Done:
    return run(*words, cwd=cwd)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return a folder with a dataset, a model trained on it, and recordings of another machine of the kind."""
    place = tmp_path_factory.mktemp("severity")
    build(RECIPE, place / "store", workers=1)
    told = rotorwise("severity", "train", place / "store", "-o", place / "model.skops", "--coverage", "0.8")
    assert told.returncode == 0, told.stderr
    assert "parallel offset" in told.stdout
    assert " machines, " in told.stdout
    misaligned = "coupling_misalignment:offset_m=6e-5,angle_rad=0,offset_phase_rad=0.5,angle_phase_rad=0"
    for name, speed, rate, effects in (
        ("offset.csv", 3000, 2000, ("--with", misaligned)),
        ("fast.csv", 4000, 2000, ()),
        ("coarse.csv", 3000, 1000, ()),
    ):
        simulate = ("simulate", "amb_rotor", "--set", "unbalance_kg_m=2e-5", *effects)
        told = rotorwise(*simulate, "--speed", speed, "--duration", 1, "--rate", rate, "-o", place / name)
        assert told.returncode == 0, told.stderr
    lines = (place / "offset.csv").read_text().splitlines()
    for row in (-30, -29, -28):
        cells = lines[row].split(",")
        lines[row] = ",".join([cells[0], "nan", *cells[2:]])
    (place / "gap.csv").write_text("\n".join(lines) + "\n")
    shutil.copy(place / "offset.toml", place / "gap.toml")
    return place


@pytest.fixture(scope="module")
def answer(folder) -> dict:
    """Return what `estimate` says of the misaligned machine's recording, which has a sidecar."""
    told = rotorwise("severity", "estimate", folder / "model.skops", folder / "offset.csv", "--json")
    assert told.returncode == 0, told.stderr
    (found,) = json.loads(told.stdout)
    return found


def test_an_offset_is_estimated_and_the_zones_are_compared(folder, answer):
    (found,) = answer["estimates"]
    # A handful of machines teaches little: what must hold is the interval.
    assert (found["target"], found["unit"]) == ("parallel offset", "mm")
    assert found["low"] <= 0.06 <= found["high"]
    assert found["low"] <= found["value"] <= found["high"]
    assert answer["predicted_zones"]["together"]["zone"] == answer["measured_zone"]["zone"]
    assert answer["finding"] is None
    told = rotorwise("severity", "estimate", folder / "model.skops", folder / "offset.csv")
    assert "zone the simulator predicts" in told.stdout
    assert "ISO 14839-2" in told.stdout


def test_a_plain_file_is_judged_by_the_machines_own_table_too(folder, answer, tmp_path):
    plain = tmp_path / "plain"
    plain.mkdir()
    shutil.copy(folder / "offset.csv", plain / "offset.csv")
    words = ("--unit", "m", "--tacho", "tacho", "--speed", 3000, "--json")
    told = rotorwise("severity", "estimate", folder / "model.skops", plain, *words)
    assert told.returncode == 0, told.stderr
    (found,) = json.loads(told.stdout)
    assert found["measured_zone"] == answer["measured_zone"]
    assert found["measured_zone"]["standard"] == "ISO 14839-2"


def test_an_empty_folder_is_told(folder, tmp_path):
    told = rotorwise("severity", "estimate", folder / "model.skops", tmp_path)
    assert told.returncode == 2
    assert "No recording in" in told.stderr


def test_records_outside_the_training_are_refused_and_the_others_answered(folder, answer):
    refused = {
        "fast.csv": "the model was trained from 2950 to 3050 rpm",
        "coarse.csv": "Sampling rate 1000 Hz; the model needs",
        "absent.csv": "absent.csv",
        "gap.csv": "Channel path_2 lacks 3 of 2000 samples",
    }
    names = [folder / name for name in (*refused, "offset.csv")]
    told = rotorwise("severity", "estimate", folder / "model.skops", *names, "--json")
    assert told.returncode == 3
    assert "Traceback" not in told.stderr
    *others, last = json.loads(told.stdout)
    assert [set(one) for one in others] == [{"path", "refused"}] * len(refused)
    for (name, said), one in zip(refused.items(), others, strict=True):
        assert Path(one["path"]).name == name
        assert said in one["refused"]
        assert said in told.stderr
    assert last["estimates"] == answer["estimates"]


def test_other_probes_are_refused(folder, tmp_path):
    names = [word for name in ("a", "b", "c", "d", "tacho") for word in ("--channel-name", name)]
    shutil.copy(folder / "offset.csv", tmp_path / "renamed.csv")
    shutil.copy(folder / "offset.toml", tmp_path / "renamed.toml")
    told = rotorwise("severity", "estimate", folder / "model.skops", tmp_path / "renamed.csv", *names)
    assert told.returncode == 3
    assert "No channel 'path_1' in the recording" in told.stderr


def test_evaluate_says_coverage_and_zones(folder):
    told = rotorwise("severity", "evaluate", folder / "model.skops", folder / "store", "--split", "test", "--json")
    assert told.returncode == 0, told.stderr
    found = json.loads(told.stdout)
    assert {one["case"] for one in found["targets"]} == {
        "all", "with the fault", "healthy", "parallel misalignment",
    }  # fmt: skip
    assert sum(sum(row) for row in found["zones"]["counts"]) == found["zones"]["records"] > 0


def test_a_split_that_is_not_there_is_told(folder):
    text = rotorwise("severity", "evaluate", folder / "model.skops", folder / "store", "--split", "nowhere")
    assert text.returncode == 2
    assert "no rows of split 'nowhere'; allowed: test, train" in text.stderr


def test_too_few_machines_and_wrong_words_are_told(folder, tmp_path):
    for words, said in (
        (("--coverage", "0.95"), "machines for intervals of 95 %; allowed: 19 or more"),
        (("--coverage", "1.5"), "--coverage 1.5; allowed: above 0, below 1"),
    ):
        told = rotorwise("severity", "train", folder / "store", "-o", tmp_path / "model.skops", *words)
        assert told.returncode == 2
        assert said in told.stderr
        assert not (tmp_path / "model.skops").exists()


def test_a_model_is_not_replaced_unasked_and_other_data_never(folder, tmp_path):
    mine = tmp_path / "notes.skops"
    mine.write_text("mine")
    for words in ([], ["--force"]):
        told = rotorwise("severity", "train", folder / "store", "-o", mine, *words)
        assert told.returncode == 4
        assert mine.read_text() == "mine"
    told = rotorwise("severity", "train", folder / "store", "-o", folder / "model.skops")
    assert told.returncode == 4
    assert "exists already" in told.stderr


def test_a_file_gives_the_same_answers_as_the_model(trained, tmp_path):
    save_model(trained.model, tmp_path / "model.skops")
    again = load_model(tmp_path / "model.skops")
    assert again.card == trained.model.card
    assert again.remarks == ()
    assert again.card["versions"] == model_versions()
    for name, one in trained.model.regressors.items():
        values = trained.held_out.values
        assert np.array_equal(one.predict_interval(values), again.regressors[name].predict_interval(values))
        assert np.array_equal(
            one.predict_interval(values, coverage=0.7), again.regressors[name].predict_interval(values, coverage=0.7)
        )


def changed(content: bytes, path: Path, *, extra: bool = False, cut: bool = False) -> Path:
    path.write_bytes(content[: len(content) // 2] if cut else content)
    if extra:
        with zipfile.ZipFile(path, "a") as archive:
            archive.writestr("more.txt", "x")
    return path


def test_foreign_damaged_and_changed_files_are_refused(trained, tmp_path):
    content = model_bytes(trained.model)
    with zipfile.ZipFile(tmp_path / "foreign.skops", "w") as archive:
        archive.writestr("schema.json", "{}")
    (tmp_path / "pickle.skops").write_bytes(pickle.dumps({"a": 1}))
    cases = (
        (tmp_path / "foreign.skops", "is no severity model"),
        (tmp_path / "pickle.skops", "is no severity model"),
        (changed(content, tmp_path / "cut.skops", cut=True), "is no severity model"),
        (changed(content, tmp_path / "more.skops", extra=True), "was changed after it was written"),
        (tmp_path / "absent.skops", "No such file"),
    )
    for path, said in cases:
        with pytest.raises(SeverityFileError, match=said):
            load_model(path)


def test_estimators_that_are_none_are_refused(trained, tmp_path):
    for number, regressors in enumerate(({"parallel offset": None}, {"size": ConformalRegressor()})):
        place = tmp_path / f"{number}.skops"
        place.write_bytes(model_bytes(replace(trained.model, regressors=regressors)))
        with pytest.raises(SeverityFileError, match="allowed: fitted estimators of parallel offset"):
            load_model(place)


def test_a_type_that_no_model_holds_is_refused(trained, tmp_path, monkeypatch):
    from rotorwise.diagnose.learning.severity import model_file

    save_model(trained.model, tmp_path / "model.skops")
    without = tuple(name for name in model_file.TRUSTED if not name.endswith("ConformalRegressor"))
    monkeypatch.setattr(model_file, "TRUSTED", without)
    with pytest.raises(SeverityFileError, match="ConformalRegressor, which no severity model"):
        load_model(tmp_path / "model.skops")


def test_another_version_is_told(trained, tmp_path, monkeypatch):
    from rotorwise.diagnose.learning.severity import model_file

    save_model(trained.model, tmp_path / "model.skops")
    monkeypatch.setattr(model_file, "model_versions", lambda: {**model_versions(), "scikit-learn": "99"})
    assert "scikit-learn" in load_model(tmp_path / "model.skops").remarks[0]

"""``rotorwise train`` and ``rotorwise evaluate`` as a user meets them."""

from __future__ import annotations

import json

import pytest
from rotorwise.diagnose.cli import app
from rotorwise.diagnose.learning.feature_file import write_features
from typer.testing import CliRunner

from .conftest import made_table


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("commands")
    write_features(made_table(), folder / "features.parquet", {"fingerprint": "made"})
    return folder


def run(*arguments: object):
    return CliRunner().invoke(app, [str(one) for one in arguments])


def test_a_model_is_trained_judged_and_never_overwritten(files) -> None:
    model, features = files / "a.skops", files / "features.parquet"
    first = run("train", features, "-o", model, "--model", "linear")
    assert first.exit_code == 0, first.output
    assert "Judged on machines that it did not see" in first.output
    before = model.read_bytes()
    second = run("train", features, "-o", model, "--model", "linear")
    assert second.exit_code == 4
    assert "--force" in second.output
    assert model.read_bytes() == before
    assert run("train", features, "-o", features, "--force").exit_code == 4

    page = files / "page.html"
    shown = run("evaluate", model, features, "--split", "test", "--json", "--report", page)
    assert shown.exit_code == 0, shown.output
    found = json.loads(shown.stdout)
    assert found["recall"]["bearing_outer_race"] > 0.95
    assert set(found["by"]) == {"speed_rpm", "load"}
    assert set(found["situations"]) == {"alone", "with a healthy record"}
    assert not found["remarks"]
    text = page.read_text(encoding="utf-8")
    assert "Confusion matrix" in text
    assert "http://" not in text.split("<script>")[0].replace("http://www.w3.org", "")
    assert run("evaluate", model, features, "--report", page).exit_code == 4
    flattering = json.loads(run("evaluate", model, features, "--json").stdout)
    assert "were learned" in flattering["remarks"][0]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("train", "nowhere", "-o", "x.skops"), 3, "holds no dataset"),
        (("train", "features.parquet", "-o", "x.skops", "--model", "forest"), 2, "boosting, linear"),
        (("train", "features.parquet", "-o", "x.skops", "--iterations", "0"), 2, "1 or more"),
        (("train", "features.parquet", "-o", "absent/x.skops"), 4, "folder that exists"),
        (("evaluate", "features.parquet", "features.parquet"), 3, "no model of rotorwise"),
        (("evaluate", "default", "features.parquet", "--split", "none"), 2, "test, train"),
        (("evaluate", "default", "absent.csv"), 3, "absent.csv"),
        (("evaluate", "default", "features.parquet", "--seed"), 2, "--seed"),
    ],
)
def test_bad_input_is_one_message(files, monkeypatch, arguments, code, words) -> None:
    monkeypatch.chdir(files)
    answer = run(*arguments)
    assert answer.exit_code == code, answer.output
    assert words in answer.output
    assert "Traceback" not in answer.output

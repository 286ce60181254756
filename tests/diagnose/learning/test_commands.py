"""``rotorwise train`` and ``rotorwise evaluate`` as a user meets them."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from rotorwise.diagnose.learning.feature_file import write_features

from ..command import run
from .conftest import made_table


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("commands")
    table = made_table()
    columns = {name: column for name, column in table.columns.items() if name != "speed_rpm"}
    infinite = table.values.copy()
    infinite[0, table.names.index("crest_factor")] = np.inf
    for name, one in {
        "features": table,
        "test_only": table.where(table.columns["split"] == "test"),
        "empty": table.where(table.labels == "rub"),
        "infinite": replace(table, values=infinite),
        "no_speed": replace(table, columns=columns),
    }.items():
        write_features(one, folder / f"{name}.parquet", {"fingerprint": "made"})
    time = np.arange(20000) / 10000
    noise = np.random.default_rng(0).normal(0.0, 0.1, time.size)
    signal = pa.table({"a": np.sin(2 * np.pi * 25.0 * time) + noise})
    pq.write_table(signal, folder / "recording.parquet")
    (folder / "none").mkdir()
    whole = pq.read_table(folder / "features.parquet")
    texts, backwards = pa.array(["a"] * whole.num_rows), pa.array([-5.0] * whole.num_rows)
    for name, column, values in (
        ("text", "feature.crest_factor", texts),
        ("backwards", "speed_rpm", backwards),
        ("unlabelled", "label", pa.nulls(whole.num_rows, pa.string())),
    ):
        place = whole.column_names.index(column)
        pq.write_table(whole.set_column(place, column, values), folder / f"{name}.parquet")
    pq.write_table(whole.replace_schema_metadata({b"rotorwise features": b"[1]"}), folder / "other_head.parquet")
    return folder


def test_a_model_is_trained_judged_and_never_overwritten(files) -> None:
    model, features = files / "a.skops", files / "features.parquet"
    first = run("train", features, "-o", model, "--model", "linear")
    assert first.returncode == 0, first.stderr
    assert "Judged on machines that it did not see" in first.stdout
    before = model.read_bytes()
    second = run("train", features, "-o", model, "--model", "linear")
    assert second.returncode == 4
    assert "--force" in second.stderr
    assert model.read_bytes() == before
    assert run("train", features, "-o", features, "--force").returncode == 4

    page = files / "page.html"
    shown = run("evaluate", model, features, "--split", "test", "--json", "--report", page)
    assert shown.returncode == 0, shown.stderr
    found = json.loads(shown.stdout)
    assert found["recall"]["bearing_outer_race"] > 0.95
    assert set(found["by"]) == {"speed_rpm", "load"}
    assert set(found["situations"]) == {"alone", "with a healthy record"}
    assert not found["remarks"]
    text = page.read_text(encoding="utf-8")
    assert "Confusion matrix" in text
    assert "http://" not in text.split("<script>")[0].replace("http://www.w3.org", "")
    assert run("evaluate", model, features, "--report", page).returncode == 4
    flattering = json.loads(run("evaluate", model, features, "--json").stdout)
    assert "were learned" in flattering["remarks"][0]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("train", "nowhere", "-o", "x.skops"), 3, "holds no dataset"),
        (("train", "features.parquet", "-o", "x.skops", "--model", "forest"), 2, "boosting, linear"),
        (("train", "features.parquet", "-o", "x.skops", "--iterations", "0"), 2, "1 to 10000"),
        (("train", "features.parquet", "-o", "absent/x.skops"), 4, "folder that exists"),
        (("evaluate", "features.parquet", "features.parquet"), 3, "no model of rotorwise"),
        (("evaluate", "default", "features.parquet", "--split", "none"), 2, "test, train"),
        (("evaluate", "default", "absent.csv"), 3, "absent.csv"),
        (("evaluate", "default", "features.parquet", "--seed"), 2, "--seed"),
        (("train", "features.parquet", "-o", "x.skops", "--seed", 10**20), 2, "0 to 4294967295"),
        (("train", "features.parquet", "-o", "x.skops", "--features", "x.skops"), 2, "model's own file"),
        (("train", "features.parquet", "-o", "x.skops", "--features", "no/y.parquet"), 4, "does not exist"),
        (("train", "test_only.parquet", "-o", "x.skops"), 2, "shows nothing"),
        (("train", "empty.parquet", "-o", "x.skops"), 3, "has no row"),
        (("train", "infinite.parquet", "-o", "x.skops"), 3, "has feature.crest_factor = inf"),
        (("train", "text.parquet", "-o", "x.skops"), 3, "has feature.crest_factor of type string"),
        (("train", "backwards.parquet", "-o", "x.skops"), 3, "has speed_rpm = -5; allowed: speeds above 0"),
        (("evaluate", "default", "unlabelled.parquet"), 3, "has None as label"),
        (("evaluate", "default", "other_head.parquet"), 3, "has format [1]"),
        (("train", "no_speed.parquet", "-o", "x.skops"), 3, "lacks speed_rpm"),
        (("train", "recording.parquet", "-o", "x.skops"), 3, "no feature file"),
        (("train", "features.parquet", "-o", f"{'x' * 300}.skops"), 4, "name too long"),
        (("evaluate", "default", "none"), 2, "No recording in none"),
        (("evaluate", "default", "features.parquet", "--label", "rub"), 2, "--label says nothing to a dataset"),
        (("evaluate", "default", "recording.parquet", "--split", "test"), 2, "--split says nothing to recordings"),
    ],
)
def test_bad_input_is_one_message(files, monkeypatch, arguments, code, words) -> None:
    monkeypatch.chdir(files)
    answer = run(*arguments)
    assert answer.returncode == code, answer.stderr
    assert words in answer.stderr
    assert "Traceback" not in answer.stderr


def test_what_cannot_be_read_stops_no_other_recording_and_parquet_may_be_a_recording(files, monkeypatch) -> None:
    monkeypatch.chdir(files)
    (files / "broken.csv").write_text("no numbers here")
    words = ("--rate", "10000", "--unit", "m/s2", "--speed", "1500", "--label", "healthy", "--json")
    answer = run("evaluate", "default", "broken.csv", "recording.parquet", *words)
    assert answer.returncode == 3
    assert "broken.csv" in answer.stderr
    found = json.loads(answer.stdout)
    assert [one["answer"] is None for one in found["files"]] == [True, False]
    assert found["rows"] == 1
    assert "cannot be read" in found["remarks"][-1]

"""Training, files of models and features, evaluation: what is stated, what is refused, what is never lost."""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.learning import default_model as shipped
from rotorwise.diagnose.learning import model_file
from rotorwise.diagnose.learning.archive import digest
from rotorwise.diagnose.learning.combination import Weights, fit_weights, log_odds
from rotorwise.diagnose.learning.evaluation import Judged, by_column, scores
from rotorwise.diagnose.learning.fault_classifier import FaultClassifier
from rotorwise.diagnose.learning.feature_file import FeatureFileError, features_bytes, read_features, write_features
from rotorwise.diagnose.learning.model_file import ModelFileError, load_model, model_bytes, model_from_bytes, save_model
from rotorwise.diagnose.learning.training import train
from sklearn.linear_model import LogisticRegression
from threadpoolctl import threadpool_limits


@pytest.fixture(scope="module")
def model(table):
    with threadpool_limits(1):
        return train(table, origin={"recipe": "made"}, model="linear")


def test_the_card_keeps_machines_apart_and_says_how_it_was_judged(model, table) -> None:
    card = model.card
    assert not set(card["machines_fitted"]) & set(card["machines_held_out"])
    assert len(card["machines_fitted"]) + len(card["machines_held_out"]) == np.unique(table.groups).size
    judged = card["judged_on_held_out_machines"]
    assert set(judged) == {"machine", "severity", "condition"}
    assert judged["machine"]["recall"]["bearing_outer_race"] > 0.95
    assert 0 < judged["severity"]["rows"] < judged["machine"]["rows"]
    assert card["combination"]["rules"] >= 0
    assert json.loads(json.dumps(card)) == card


def test_a_file_gives_the_same_answers_and_is_never_replaced_unasked(model, table, tmp_path) -> None:
    path = tmp_path / "a.skops"
    save_model(model, path)
    again = load_model(path)
    values = np.full((3, len(model.features)), 0.2)
    assert np.array_equal(again.classifier.predict_proba(values), model.classifier.predict_proba(values))
    assert np.array_equal(again.classifier.novelty_p_value(values), model.classifier.novelty_p_value(values))
    assert again.card == model.card
    assert not again.remarks
    with pytest.raises(ModelFileError, match="--force"):
        save_model(model, path)
    save_model(model, path, force=True)
    other = tmp_path / "mine.txt"
    other.write_text("mine")
    with pytest.raises(ModelFileError, match="never replaces other data"):
        save_model(model, other, force=True)
    assert other.read_text() == "mine"
    assert [one.name for one in tmp_path.iterdir() if one.name.startswith(".")] == []


def _rewritten(content: bytes, change) -> bytes:
    """Return the archive with its schema changed, the comment as it was."""
    sink = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(sink, "w") as new:
        for name in old.namelist():
            part = old.read(name)
            new.writestr(name, change(part) if name == "schema.json" else part)
        new.comment = old.comment
    return sink.getvalue()


def test_changed_foreign_and_damaged_files_are_refused(model, tmp_path, monkeypatch) -> None:
    content = model_bytes(model)
    with pytest.raises(ModelFileError, match="changed after it was written"):
        model_from_bytes(_rewritten(content, lambda part: part.replace(b"linear", b"boosts")), name="x")
    with pytest.raises(ModelFileError, match="no model of rotorwise"):
        model_from_bytes(b"PK not a zip", name="x")
    with pytest.raises(ModelFileError, match=r"no model|damaged"):
        model_from_bytes(content[: len(content) // 2], name="x")
    plain = io.BytesIO()
    with zipfile.ZipFile(plain, "w") as archive:
        archive.writestr("schema.json", "{}")
    with pytest.raises(ModelFileError, match="no model of rotorwise"):
        model_from_bytes(plain.getvalue(), name="x")
    with pytest.raises(ModelFileError, match="Check the path"):
        load_model(tmp_path / "absent.skops")

    # A forged file with a right digest and a type of its own: refused before anything is made of it.
    def hostile(part: bytes) -> bytes:
        old, new = b'"Novelty"', b'"system"'
        assert old in part
        return part.replace(old, new).replace(b"rotorwise.diagnose.learning.novelty", b"os")

    forged = io.BytesIO(_rewritten(content, hostile))
    with zipfile.ZipFile(forged, "a") as file:
        file.comment = b"rotorwise model " + digest(file).encode()
    with pytest.raises(ModelFileError, match=r"os\.system"):
        model_from_bytes(forged.getvalue(), name="x")


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"features": ("a", "b")}, "other features than the"),
        ({"card": {}}, "limit of unknown is None"),
        ({"classifier": FaultClassifier(model="linear")}, "not fitted"),
        ({"classifier": LogisticRegression()}, "LogisticRegression instead of a classifier of faults"),
    ],
)
def test_a_whole_file_that_holds_something_else_is_refused(model, changed, words) -> None:
    with pytest.raises(ModelFileError, match=words):
        model_from_bytes(model_bytes(replace(model, **changed)), name="x")


def test_other_versions_are_told(model, monkeypatch) -> None:
    content = model_bytes(model)
    here = model_file.model_versions()
    monkeypatch.setattr(model_file, "model_versions", lambda: {**here, "scikit-learn": "99.0"})
    assert "scikit-learn" in model_from_bytes(content, name="x").remarks[0]


def test_features_keep_four_digits_and_refuse_what_is_not_theirs(table, tmp_path) -> None:
    again, origin = read_features(features_bytes(table, {"seed": 3}))
    assert origin == {"seed": 3}
    assert again.names == table.names
    assert np.array_equal(again.labels, table.labels)
    assert np.allclose(again.values, table.values, rtol=2.0**-12, atol=0)
    assert np.array_equal(again.columns["group"], table.columns["group"])
    path = tmp_path / "f.parquet"
    write_features(table, path, {})
    with pytest.raises(FeatureFileError, match="--force"):
        write_features(table, path, {})
    mine = tmp_path / "mine.parquet"
    mine.write_bytes(b"mine")
    with pytest.raises(FeatureFileError, match="no feature file"):
        write_features(table, mine, {}, force=True)
    assert mine.read_bytes() == b"mine"


def test_scores_count_as_one_would_by_hand() -> None:
    found = Judged(
        truth=np.array(["healthy", "healthy", "not evident", "rub", "rub", "rub"]),
        answer=np.array(["healthy", "rub", "healthy", "rub", "healthy", "rub"]),
        probability=np.array([0.9, 0.5, 0.7, 0.9, 0.6, 0.9]),
        p_value=np.array([0.5, 0.5, 0.5, 0.5, 0.5, 0.001]),
        unknown_below=0.02,
    )
    got = scores(found)
    assert got["right"] == 3 / 5
    assert got["recall"] == {"healthy": 0.5, "not evident": 1.0, "rub": 0.5}
    assert got["false_alarms"] == 1 / 3
    assert got["unknown"] == 1 / 6
    assert got["confusion"]["rub"] == {"healthy": 1, "rub": 1, "unknown": 1}
    assert sum(one["rows"] for one in got["calibration"]) == 5


def test_conditions_are_values_where_they_are_few_and_ranges_else() -> None:
    rows = 12
    found = Judged(
        *(np.repeat("healthy", rows) for _ in range(2)), *(np.full(rows, 0.9) for _ in range(2)), unknown_below=0.02
    )
    two = by_column(found, np.where(np.arange(rows) < 4, 1000.0, 2000.0))
    assert {name: part["rows"] for name, part in two.items()} == {"1000": 4, "2000": 8}
    many = by_column(found, np.r_[np.nan, np.arange(1.0, rows)])
    assert sum(part["rows"] for part in many.values()) == rows - 1
    assert len(many) == 3
    assert by_column(found, np.full(rows, np.nan)) == {}
    alike = by_column(found, np.r_[np.full(4, 1795.9), np.full(4, 1796.1), np.full(4, 1750.0)])
    assert {name: part["rows"] for name, part in alike.items()} == {"1796": 8, "1750": 4}


def test_weights_of_independent_evidence_are_found_again() -> None:
    stream = np.random.default_rng(0)
    rules, model = stream.uniform(0.02, 0.98, (2, 20000))
    truth = Weights(-0.5, 0.7, 1.2)
    present = stream.uniform(size=20000) < truth.combined(rules, model)
    found = fit_weights(rules, model, present)
    assert np.allclose(list(found.data().values()), list(truth.data().values()), atol=0.1)
    against = stream.uniform(size=20000) < 1 / (1 + np.exp(log_odds(rules) - log_odds(model)))
    assert fit_weights(rules, model, against).rules == 0.0


def test_the_default_model_is_cached_and_does_without_a_cache(tmp_path, monkeypatch) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    for folder in (blocked, tmp_path / "cache"):
        monkeypatch.setenv("ROTORWISE_CACHE", str(folder))
        shipped.plain_default_model.cache_clear()
        with threadpool_limits(1):
            assert shipped.plain_default_model().card["combination"] is not None
    assert len(list((tmp_path / "cache").iterdir())) == 1
    assert blocked.read_text() == "in the way"
    shipped.plain_default_model.cache_clear()
    monkeypatch.setattr(shipped, "default_model", None)  # not fitted again
    assert "bearing_outer_race" in shipped.plain_default_model().classifier.classes_
    shipped.plain_default_model.cache_clear()


def test_the_model_doubts_and_raises_no_alarm() -> None:
    weights = Weights(constant=1.0, rules=1.0, model=1.0)
    rules, model = np.array([0.3, 0.3, 0.9]), np.array([0.95, 0.05, 0.5])
    assert weights.combined(rules, model)[0] > 0.5
    assert np.all(weights.doubted(rules, model) <= rules)
    assert weights.doubted(rules, model)[1] == weights.combined(rules, model)[1]

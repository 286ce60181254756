"""The shipped model from its arrays: the same answers as scikit-learn's, and scikit-learn stays out of an analysis."""

import subprocess
import sys
from importlib.resources import files

import numpy as np
import pytest
from rotorwise.diagnose.learning import default_model as shipped
from rotorwise.diagnose.learning.changes import learning_rows
from rotorwise.diagnose.learning.fault_classifier import FaultClassifier
from rotorwise.diagnose.learning.feature_file import read_features
from rotorwise.diagnose.learning.model_file import Model, ModelFileError
from rotorwise.diagnose.learning.plain_model import plain, plain_bytes, plain_from_bytes
from rotorwise.simulators.errors import InvalidValueError


@pytest.fixture(scope="module")
def shipped_features() -> np.ndarray:
    content = files("rotorwise.diagnose.learning").joinpath(shipped.FEATURES).read_bytes()
    return learning_rows(read_features(content)[0], seed=3)[0]


def test_arrays_answer_as_scikit_learn_does_on_the_shipped_features(shipped_features) -> None:
    full, arrays = shipped.default_model(), shipped.plain_default_model()
    assert arrays.features == full.features
    assert arrays.card == full.card
    assert arrays.classifier.classes_.tolist() == [str(one) for one in full.classifier.classes_]
    expected = full.classifier.predict_proba(shipped_features)
    assert arrays.classifier.predict_proba(shipped_features) == pytest.approx(expected, rel=0, abs=1e-12)
    p_value = full.classifier.novelty_p_value(shipped_features)
    assert arrays.classifier.novelty_p_value(shipped_features) == pytest.approx(p_value, rel=0, abs=1e-12)


@pytest.mark.parametrize("spread", [0.1, 3.0, 1e4])
def test_arrays_answer_as_scikit_learn_does_on_random_features(spread) -> None:
    stream = np.random.default_rng(int(spread * 10))
    full, arrays = shipped.default_model(), shipped.plain_default_model()
    rows = stream.normal(0.0, spread, (500, len(full.features)))
    rows[stream.uniform(size=rows.shape) < 0.2] = np.nan
    expected = full.classifier.predict_proba(rows)
    assert arrays.classifier.predict_proba(rows) == pytest.approx(expected, rel=0, abs=1e-12)
    p_value = full.classifier.novelty_p_value(rows)
    assert arrays.classifier.novelty_p_value(rows) == pytest.approx(p_value, rel=0, abs=1e-12)


def _fitted(model: str, classes: int, rows: int = 40) -> FaultClassifier:
    stream = np.random.default_rng(1)
    labels = np.repeat([f"fault {number}" for number in range(classes)], rows)
    place = np.repeat(np.arange(classes), rows)[:, None]
    features = stream.normal(size=(labels.size, 4)) + 2.0 * place * np.array([1.0, 0.5, 0.0, -1.0])
    features[stream.uniform(size=features.shape) < 0.1] = np.nan
    features[:, 2] = np.nan  # nobody has it
    return FaultClassifier(model=model, iterations=5).fit(features, labels)


def test_a_model_with_gaps_comes_back_from_its_bytes_the_same() -> None:
    fitted = _fitted("linear", 4)
    kept = plain_from_bytes(plain_bytes(Model(plain(fitted), ("a", "b", "c", "d"), {"unknown_below": 0.02})))
    asked = np.random.default_rng(2).normal(2, 4, (300, 4))
    assert kept.classifier.predict_proba(asked) == pytest.approx(fitted.predict_proba(asked), rel=0, abs=1e-12)
    assert kept.classifier.novelty_p_value(asked) == pytest.approx(fitted.novelty_p_value(asked), rel=0, abs=1e-12)
    assert (kept.features, kept.card) == (("a", "b", "c", "d"), {"unknown_below": 0.02})


@pytest.mark.parametrize("place", [0, 40, 500, 1500, -30, -1])
def test_one_wrong_bit_is_refused(place) -> None:
    whole = bytearray(plain_bytes(Model(plain(_fitted("linear", 3)), ("a", "b", "c", "d"), {})))
    whole[place] ^= 4
    with pytest.raises(ModelFileError, match="damaged"):
        plain_from_bytes(bytes(whole))


@pytest.mark.parametrize(("model", "classes", "rows"), [("boosting", 3, 40), ("linear", 2, 40), ("linear", 3, 1)])
def test_what_the_arrays_cannot_say_is_refused(model, classes, rows) -> None:
    with pytest.raises(InvalidValueError, match="allowed: linear, calibrated"):
        plain(_fitted(model, classes, rows))


def test_a_damaged_cache_costs_the_fit_again_and_nothing_else(tmp_path, monkeypatch) -> None:
    expected = shipped.plain_default_model()
    with monkeypatch.context() as context:
        context.setenv("ROTORWISE_CACHE", str(tmp_path))
        shipped.plain_default_model.cache_clear()
        shipped.plain_default_model()
        place = next(tmp_path.iterdir())
        whole = plain_bytes(expected)
        for damaged in (b"", b"damaged", whole[: len(whole) // 2], whole.replace(b"npy", b"nay")):
            place.write_bytes(damaged)
            shipped.plain_default_model.cache_clear()
            found = shipped.plain_default_model()
            assert np.array_equal(found.classifier.weights, expected.classifier.weights)
            assert plain_from_bytes(place.read_bytes()).card == expected.card  # written anew
    shipped.plain_default_model.cache_clear()


def test_an_opinion_needs_neither_scikit_learn_nor_a_compiler() -> None:
    shipped.plain_default_model()
    asked = (
        "import sys, numpy as np\n"
        "from rotorwise.diagnose.learning.default_model import plain_default_model\n"
        "from rotorwise.diagnose.learning.opinion import opinion_of, stated\n"
        "import rotorwise.diagnose.run, rotorwise.diagnose.report, rotorwise.diagnose.order_waves\n"
        "import rotorwise.diagnose.signal.vold_kalman\n"
        "model = plain_default_model()\n"
        "print(stated(model, np.zeros(len(model.features))).p_value)\n"
        "print(sorted({'sklearn', 'skops', 'numba', 'pandas', 'pyarrow'} & set(sys.modules)))\n"
    )
    said = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True).stdout.split("\n")
    assert said[1] == "[]"
    assert 0 < float(said[0]) <= 1

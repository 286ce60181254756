"""The figures of the effects' tests: recorded in words, read from a run, written into the table."""

import ast
import shutil
from pathlib import Path

import pytest
from rotorwise.simulators import effect_table
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.effect_figures import FigureError, figures_in, measured_figures
from rotorwise.simulators.effect_table import main, rows_of

from .effects.conftest import deviation

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests" / "simulators" / "effects"


@pytest.mark.parametrize("name", effect_catalogue())
def test_one_test_of_the_effect_records_its_figure(name):
    parsed = ast.parse((TESTS / f"test_{name}.py").read_text(encoding="utf-8"))
    calls = [node for node in ast.walk(parsed) if isinstance(node, ast.Call)]
    assert sum(isinstance(c.func, ast.Name) and c.func.id == "figure" for c in calls) == 1, "the strongest, and only it"


@pytest.mark.parametrize(
    ("found", "expected", "unit", "says"),
    [
        ([1.0, 2.0006], [1.0, 2.0], "", "0.03 % off"),
        (1.0 + 3e-10j, 1.0, "", "3e-10 off"),
        ([3.12, -2.0], [3.0, -2.0], "Hz", "0.1 Hz off"),
        (1.0 + 1e-15, 1.0, "Hz", "to rounding"),
        (1.3, 1.0, "", "30 % off"),
    ],
)
def test_deviation_in_words(found, expected, unit, says):
    assert deviation(found, expected, unit=unit) == says


def test_deviation_from_nothing_is_no_figure():
    with pytest.raises(AssertionError, match="zero everywhere"):
        deviation(1e-9, 0.0)


def junit(path, *cases):
    """Write a JUnit file of test cases, each a module and the figures that it recorded."""
    lines = []
    for module, *texts in cases:
        recorded = "".join(f'<property name="figure" value="{text}"/>' for text in texts)
        lines.append(f'<testcase classname="tests.simulators.effects.test_{module}" name="test_it"><properties>')
        lines.append(f'<property name="other" value="x"/>{recorded}</properties></testcase>')
    path.write_text("<testsuites><testsuite>" + "".join(lines) + "</testsuite></testsuites>", encoding="utf-8")
    return path


def test_figures_are_read_by_effect_and_the_worst_counts(tmp_path):
    written = junit(
        tmp_path / "figures.xml",
        ("wear", "Rise: 3e-10 off", "Rise: 0.02 % off", "Rise: 1e-5 off"),
        ("wear", "Rise: to rounding"),
        ("rub", "Ratio 1: 2: 0.06 dB off"),
        ("rub", "Ratio 1: 2: 0.3 dB off"),
        ("oil_whirl", "Whirl: 0.447X where 0.40 to 0.48X is published"),
        ("unbalance",),
    )
    assert figures_in(written) == {
        "wear": "Rise: 0.02 % off",
        "rub": "Ratio 1: 2: 0.3 dB off",
        "oil_whirl": "Whirl: 0.447X where 0.40 to 0.48X is published",
    }


def folder_of_tests(root, **bodies):
    """Return a checkout's folder of tests with our fixture and one test an effect."""
    tests = root / "tests" / "simulators" / "effects"
    tests.mkdir(parents=True)
    shutil.copy(TESTS / "conftest.py", tests)
    for name, body in bodies.items():
        (tests / f"test_{name}.py").write_text(f"def test_it(figure):\n    {body}\n", encoding="utf-8")
    return tests


def test_figures_come_from_a_run_of_the_tests(tmp_path):
    tests = folder_of_tests(tmp_path, wear="figure('Rise', 1.0 + 3e-10, 1.0)", rub="pass")
    assert measured_figures(["wear", "unbalance"], tests) == {"wear": "Rise: 3e-10 off"}
    with pytest.raises(FigureError, match="No figure from the tests of rub"):
        measured_figures(["wear", "rub"], tests)


def test_nothing_is_written_when_a_test_fails(tmp_path):
    folder_of_tests(tmp_path, wear="assert 1 == 2")
    readme = tmp_path / "simulators" / "effects" / "README.md"
    readme.parent.mkdir(parents=True)
    shutil.copy(ROOT / "simulators" / "effects" / "README.md", readme)
    before = readme.read_bytes()
    with pytest.raises(FigureError, match=r"(?s)ended with 1; allowed is 0.*assert 1 == 2"):
        main(["wear"], tmp_path, tests_only=True)
    assert readme.read_bytes() == before


def test_figures_need_pytest(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(FigureError, match="Install"):
        measured_figures(["wear"], TESTS)


def test_renewing_the_tests_leaves_all_other_cells(tmp_path, monkeypatch):
    readme = tmp_path / "simulators" / "effects" / "README.md"
    readme.parent.mkdir(parents=True)
    shutil.copy(ROOT / "simulators" / "effects" / "README.md", readme)
    before = rows_of(readme.read_text(encoding="utf-8"))
    monkeypatch.setattr(effect_table, "measured_figures", lambda names, tests: dict.fromkeys(names, "Rise: 5 | off"))
    folder_of_tests(tmp_path, wear="pass")
    main(["wear"], tmp_path, tests_only=True)
    after = rows_of(readme.read_text(encoding="utf-8"))
    assert {name for name in before if before[name] != after[name]} == {"wear"}
    old, new = (rows["wear"].split(" | ") for rows in (before, after))
    assert new[:-1] == old[:-1]
    assert new[-1] == "**Rise: 5 / off**<br>[1 tests](../../tests/simulators/effects/test_wear.py):  |"
    assert not (tmp_path / "docs").exists()

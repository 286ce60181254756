"""The architecture, checked on the source files: who imports whom, sizes, errors, doctests, lazy imports."""

import ast
import builtins
import doctest
import importlib
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from rotorwise.simulators.errors import RotorwiseError

ROOT = Path(__file__).resolve().parents[2]
#: Each package and those of ours that it may import.
ALLOWED = {"simulators": set(), "datasets": {"simulators"}, "diagnose": {"simulators", "datasets"}}
FILES = sorted(path for package in ALLOWED for path in (ROOT / package).rglob("*.py"))
#: One test a folder: one a file would be thousands.
FOLDERS = sorted({str(path.parent.relative_to(ROOT)) for path in FILES})
MOST_LINES_A_FILE = 400
MOST_LINES_A_FUNCTION = 60
HEAVY = ("numpy", "scipy", "pandas", "plotly", "sklearn", "numba", "pyarrow", "h5py", "pywt")


def files_of(folder: str) -> list[Path]:
    """Return the source files in a folder, without those below it."""
    return [path for path in FILES if str(path.parent.relative_to(ROOT)) == folder]


def modules_of(folder: str) -> list[str]:
    """Return the names by which the files in a folder are imported."""
    files = [path.relative_to(ROOT).with_suffix("") for path in files_of(folder) if path.stem != "__main__"]
    return ["rotorwise." + ".".join(path.parts).removesuffix(".__init__") for path in files]


def imported_packages(source: str, path: Path) -> set[str]:
    """Return which of our packages a source file imports, other than its own."""
    here = path.relative_to(ROOT).with_suffix("").parts
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            targets = [alias.name.split(".") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ["rotorwise", *here[: len(here) - node.level]] if node.level else []
            base += node.module.split(".") if node.module else []
            targets = [[*base, alias.name] for alias in node.names]
        else:
            continue
        for target in targets:
            # Bare `datasets` would be another project's package of that name.
            if target[0] in ALLOWED:
                found.add("bare " + target[0])
            elif target[0] == "rotorwise" and len(target) > 1:
                found.add(target[1])
    return found - {here[0]}


@pytest.mark.parametrize("folder", FOLDERS)
def test_imports_go_one_way(folder):
    allowed = ALLOWED[Path(folder).parts[0]]
    for path in files_of(folder):
        wrong = imported_packages(path.read_text(encoding="utf-8"), path) - allowed
        assert not wrong, f"{path.relative_to(ROOT)} imports {wrong}; it may import {allowed or 'none'}"


@pytest.mark.parametrize(
    ("source", "path", "found"),
    [
        ("from ..datasets import recording", "simulators/machine.py", {"datasets"}),
        ("from ...datasets.recording import Channel", "simulators/effects/rub.py", {"datasets"}),
        ("from .. import datasets", "simulators/machine.py", {"datasets"}),
        ("def late():\n    import rotorwise.diagnose.result", "datasets/x.py", {"diagnose"}),
        ("import datasets", "diagnose/x.py", {"bare datasets"}),
        ("from ..rotor_dynamics import rolling_bearing", "simulators/effects/rub.py", set()),
        ("from ...simulators.errors import RotorwiseError", "diagnose/signal/__init__.py", {"simulators"}),
        ("import numpy, scipy.signal", "simulators/machine.py", set()),
    ],
)
def test_import_check_itself_sees_every_form(source, path, found):
    assert imported_packages(source, ROOT / path) == found


def test_package_list_matches_the_folders():
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    folders = {
        "rotorwise." + ".".join(path.parent.relative_to(ROOT).parts) for path in FILES if path.stem == "__init__"
    }
    assert set(setup["packages"]) == folders
    assert len(setup["packages"]) == len(folders)
    assert setup["package-dir"] == {f"rotorwise.{package}": package for package in ALLOWED}


def test_every_folder_with_python_files_is_a_package():
    lost = {path.parent for path in FILES if not (path.parent / "__init__.py").exists()}
    assert not lost, f"folders without __init__.py are left out of the installed package: {lost}"


@pytest.mark.parametrize("folder", FOLDERS)
def test_files_and_functions_stay_short(folder):
    for path in files_of(folder):
        text = path.read_text(encoding="utf-8")
        lines = len(text.splitlines())
        assert lines <= MOST_LINES_A_FILE, f"{path.relative_to(ROOT)} has {lines} lines; split it"
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                length, where = code_lines(node), f"{path.relative_to(ROOT)}: {node.name}"
                assert length <= MOST_LINES_A_FUNCTION, f"{where} has {length} lines without docstring; split it"


def code_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return the lines of a function without its docstring, which has to be as long as it has to be."""
    length = (function.end_lineno or function.lineno) - function.lineno + 1
    first = function.body[0]
    if ast.get_docstring(function) is not None:
        length -= (first.end_lineno or first.lineno) - first.lineno + 1
    return length


def test_long_functions_are_measured_without_the_docstring():
    source = 'def f():\n    """One.\n\n    Two.\n    """\n' + "    x = 1\n" * 61
    assert code_lines(ast.parse(source).body[0]) == 62


@pytest.mark.parametrize("folder", FOLDERS)
def test_errors_derive_from_ours(folder):
    for name in modules_of(folder):
        for thing in vars(importlib.import_module(name)).values():
            if isinstance(thing, type) and issubclass(thing, Exception) and thing.__module__ == name:
                where = f"{name}.{thing.__name__}"
                assert issubclass(thing, RotorwiseError), f"{where} does not derive from RotorwiseError"
                assert (thing.__doc__ or "").strip(), f"{where} does not say when it is raised"


_VAGUE = {
    name for name, thing in vars(builtins).items() if isinstance(thing, type) and issubclass(thing, Exception)
} - {
    "NotImplementedError",
    "StopIteration",
    "SystemExit",
    "KeyboardInterrupt",
    "ImportError",
    "AttributeError",
}


@pytest.mark.parametrize("folder", FOLDERS)
def test_only_our_errors_are_raised(folder):
    for path in files_of(folder):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and isinstance(node.exc.func, ast.Name):
                where = f"{path.relative_to(ROOT)}, line {node.lineno}"
                assert node.exc.func.id not in _VAGUE, f"{where} raises {node.exc.func.id}; use an error of ours"


@pytest.mark.parametrize("folder", FOLDERS)
def test_docstring_examples_run(folder):
    for name in modules_of(folder):
        module = importlib.import_module(name)
        found = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE)
        assert found.failed == 0, f"{found.failed} of {found.attempted} examples of {name} fail; see the output above"


@pytest.mark.parametrize(
    "name", ["rotorwise.diagnose.signal.integrate", "rotorwise.simulators.rotor_dynamics.rolling_bearing"]
)
def test_examples_exist_where_formulas_are(name):
    tests = doctest.DocTestFinder().find(importlib.import_module(name))
    assert sum(len(test.examples) for test in tests) > 0


def loaded_by(code: str) -> tuple[set[str], str]:
    """Return the top-level modules that a fresh interpreter has loaded after this code, and its error
    output."""
    code += "\nfinally:\n    print('LOADED', *sorted({name.split('.')[0] for name in sys.modules}))"
    run = subprocess.run(
        [sys.executable, "-c", "import sys\n" + code],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd="/",
    )
    lines = [line for line in run.stdout.splitlines() if line.startswith("LOADED ")]
    return set(lines[-1].split()[1:]) if lines else set(), run.stderr


def test_help_loads_nothing_heavy():
    assert (ROOT / "diagnose" / "cli.py").exists(), "diagnose/cli.py, the rotorwise command, does not exist"
    code = "sys.argv = ['rotorwise', '--help']\ntry:\n    from rotorwise.diagnose.cli import main\n    main()"
    loaded, complaint = loaded_by(code)
    assert "rotorwise" in loaded, complaint
    assert "Traceback" not in complaint
    assert not loaded & set(HEAVY), f"rotorwise --help loads {loaded & set(HEAVY)}; import them inside functions"


@pytest.mark.parametrize("package", ["rotorwise.simulators", "rotorwise.datasets", "rotorwise.diagnose"])
def test_importing_a_package_loads_nothing_heavy(package):
    loaded, complaint = loaded_by(f"try:\n    import {package}")
    assert "rotorwise" in loaded, complaint
    assert not loaded & set(HEAVY), f"import {package} loads {loaded & set(HEAVY)}"


def test_lazy_import_check_itself_sees_a_heavy_module():
    loaded, _ = loaded_by("try:\n    import scipy.signal")
    assert "scipy" in loaded

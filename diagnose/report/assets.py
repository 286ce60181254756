"""The scripts and the style sheet that a report carries inside itself."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from ...simulators.errors import RotorwiseError

_OWN_FILES = files(__package__ or "rotorwise.diagnose.report")


class MissingAssetError(RotorwiseError):
    """The plotly package that holds the plotting script is absent or incomplete."""


def find_plotly_script(folders: tuple[Path, ...] | None = None) -> Path:
    """Return the path of ``plotly.min.js`` inside the installed plotly package.

    The package is found without importing it, because its import takes longer than the whole report.

    Parameters
    ----------
    folders : tuple of Path, optional
        Where to look; the installed plotly package when left out.

    Raises
    ------
    MissingAssetError
        When no folder holds the script.
    """
    if folders is None:
        spec = find_spec("plotly")
        folders = tuple(Path(folder) for folder in spec.submodule_search_locations or ()) if spec else ()
    for folder in folders:
        usual = folder / "package_data" / "plotly.min.js"
        if usual.is_file():
            return usual
        others = sorted(folder.rglob("plotly*.min.js"))
        if others:
            return others[0]
    where = ", ".join(str(folder) for folder in folders) or "no installed plotly package"
    raise MissingAssetError(
        f"plotly.min.js was not found in {where}. The report needs plotly 5.20 or newer: pip install plotly."
    )


def safe_script(text: str) -> str:
    """Return a script in which nothing can end or confuse the HTML element that holds it.

    Line ends are made uniform because the browser does so before it compares the script with its hash.
    """
    uniform = text.replace("\r\n", "\n").replace("\r", "\n")
    for letters in ("</script", "</SCRIPT"):
        uniform = uniform.replace(letters, "<\\/" + letters[2:])
    return uniform.replace("<!--", "<\\!--")


@cache
def plotly_script() -> str:
    """Return plotly's JavaScript, ready to be placed in a script element."""
    return safe_script(find_plotly_script().read_text(encoding="utf-8"))


@cache
def style_sheet() -> str:
    """Return the report's style sheet."""
    return _OWN_FILES.joinpath("report.css").read_text(encoding="utf-8")

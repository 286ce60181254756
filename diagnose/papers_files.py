"""The claims as a Markdown table inside a text of its own, and files that are written whole or not at all."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from ..simulators.errors import RotorwiseError
from .output_file import replace_whole

if TYPE_CHECKING:
    from ..simulators.papers.claim import Claim

BEGIN, END = "<!-- rotorwise papers: begin -->", "<!-- rotorwise papers: end -->"


class TableFileError(RotorwiseError):
    """A table cannot be written where it was asked for."""


def check_table(path: Path) -> None:
    """Raise TableFileError when a table cannot go here."""
    _with_table(path, "")


def write_table(claims: Sequence[Claim], path: Path) -> None:
    """Write the claims between the two marker lines of a text file; everything else in it stays as it is.

    Parameters
    ----------
    claims : sequence of Claim
    path : Path
        A file with the two lines `BEGIN` and `END`, or a new one.

    Raises
    ------
    TableFileError
        When the file has not exactly one pair of markers, is no text, or cannot be written.
    """
    write_whole(path, _with_table(path, markdown(claims)))


def markdown(claims: Sequence[Claim]) -> str:
    """Return one Markdown table a paper and the count of verdicts."""
    from .papers import TITLES, count, rows

    blocks = [count(claims)]
    for paper, own in groupby(claims, key=lambda claim: claim.paper):
        lines = [f"**Paper {paper}: {TITLES.get(paper, '')}**", "", "| Where | Claim | What comes out | Verdict |"]
        lines.append("|---|---|---|---|")
        for claim in own:
            out = "<br>".join(f"*{label}:* {_cell(text)}" for label, text in rows(claim)[1:])
            lines.append(f"| {_cell(claim.place)} | {_cell(claim.says)} | {out} | {claim.verdict} |")
        blocks.append("\n".join(lines))
    return "\n\n".join(blocks)


def _cell(text: str) -> str:
    for letter, code in (("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("\\", "\\\\")):
        text = text.replace(letter, code)
    for letter in "|*_`[]":
        text = text.replace(letter, "\\" + letter)
    return " ".join(text.split())


def _with_table(path: Path, table: str) -> str:
    """Return the file's new text."""
    block = f"{BEGIN}\n\n{table}\n\n{END}"
    if path.is_dir():
        raise TableFileError(f"Table {path} is a folder; allowed: a file. Add a file name, for example README.md.")
    if not path.resolve().parent.is_dir():
        raise TableFileError(f"Folder {path.parent} of table {path.name} does not exist. Make it first.")
    try:
        if not path.exists():
            return block + "\n"
        if not path.is_file():
            raise TableFileError(f"Table {path} is no regular file. Choose another name.")
        old = path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        raise TableFileError(f"Table {path} is no text in UTF-8. Choose another file.") from None
    except OSError as problem:
        raise TableFileError(f"Table {path}: {problem.strerror or problem}. Choose another file.") from problem
    begins, ends = old.count(BEGIN), old.count(END)
    if begins != 1 or ends != 1 or old.index(END) < old.index(BEGIN):
        raise TableFileError(
            f"{path} has {begins} begin and {ends} end markers; allowed: one of each, in this order: {BEGIN} and {END}."
            " Add these two lines where the table shall stand."
        )
    if "\r\n" in old:
        block = block.replace("\n", "\r\n")
    return old[: old.index(BEGIN)] + block + old[old.index(END) + len(END) :]


def write_whole(path: Path, text: str) -> None:
    """Write a text beside its destination and rename it, so that the file is whole or as before.

    Raises
    ------
    TableFileError
        When the place cannot be written to.
    """
    replace_whole(path, text.encode(), error=TableFileError)

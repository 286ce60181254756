"""Where files may go: nothing of the user's is replaced, a link stays a link, a failure leaves nothing behind."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from rotorwise.diagnose.output_file import OutputKind, check_place, write_checked
from rotorwise.simulators.errors import RotorwiseError


class PlaceError(RotorwiseError):
    """Only here."""


KIND = OutputKind(
    name="report",
    content="page",
    example="a.html",
    is_ours=lambda path: path.read_bytes().startswith(b"page"),
    error=PlaceError,
)


@pytest.mark.parametrize(
    ("name", "force", "words"),
    [
        ("folder", True, "is a folder; allowed: a file"),
        ("none/a.html", True, "does not exist; allowed: a folder that exists"),
        ("page.html", False, "exists already.*--force"),
        ("mine.txt", True, "is no page: a report never replaces other data"),
        ("x" * 300, True, "name too long"),
    ],
)
def test_places_that_are_refused(tmp_path: Path, name: str, force: bool, words: str) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "page.html").write_text("page 1")
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(PlaceError, match=words):
        write_checked(tmp_path / name, b"page 2", KIND, force=force)
    assert (tmp_path / "page.html").read_text() == "page 1"
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_a_locked_folder_is_told_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)  # the tests may run as root, who may write anywhere
    with pytest.raises(PlaceError, match="may not be written to"):
        check_place(tmp_path / "a.html", KIND, force=False)


def test_what_cannot_be_looked_at_is_not_replaced(tmp_path: Path) -> None:
    def locked(path: Path) -> bool:
        raise PermissionError(13, "Permission denied")

    (tmp_path / "a.html").write_text("page")
    kind = OutputKind(name="report", content="page", example="a.html", is_ours=locked, error=PlaceError)
    with pytest.raises(PlaceError, match="is no page"):
        check_place(tmp_path / "a.html", kind, force=True)


def test_a_link_is_followed_and_the_mode_kept(tmp_path: Path) -> None:
    target, link = tmp_path / "real.html", tmp_path / "link.html"
    target.write_text("page 1")
    target.chmod(0o640)
    link.symlink_to(target)
    write_checked(link, b"page 2", KIND, force=True)
    assert link.is_symlink()
    assert target.read_bytes() == b"page 2"
    assert target.stat().st_mode & 0o777 == 0o640
    assert sorted(one.name for one in tmp_path.iterdir()) == ["link.html", "real.html"]

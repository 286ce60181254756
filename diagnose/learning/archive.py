"""Fitted models as files: skops, never pickle; damaged, changed and foreign files are refused.

A skops file is a zip archive whose parts say which types they hold. Only the types that a kind of file lists are ever
made. A digest of all parts stands in the archive's comment: it tells a file that was damaged or edited, not one that
was forged, and the list of types is what keeps a forged one harmless.
"""

from __future__ import annotations

import hashlib
import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ...simulators.errors import RotorwiseError
from ..output_file import OutputKind

FORMAT = 1
_PACKAGES = ("rotorwise", "scikit-learn", "numpy", "skops")


@dataclass(frozen=True)
class ArchiveKind:
    """A kind of model file.

    Attributes
    ----------
    name : str
        As messages call it, such as "severity model".
    mark : bytes
        What the archive's comment starts with, before the digest: ``rotorwise``, the name, a space.
    make : str
        The command that makes one.
    error : type
        Raised for everything that is refused.
    """

    name: str
    mark: bytes
    make: str
    error: type[RotorwiseError]

    @property
    def output(self) -> OutputKind:
        """How such a file is written."""
        return OutputKind(
            name=self.name,
            content=f"{self.name} of rotorwise",
            example="model.skops",
            is_ours=lambda target: _is_one(target.read_bytes(), self),
            error=self.error,
        )


def model_versions() -> dict[str, str]:
    """Return the versions of what decides whether a file can be read and what it answers."""
    return {name: version(name) for name in _PACKAGES}


def packed(content: Mapping[str, Any], kind: ArchiveKind) -> bytes:
    """Return what a model consists of as the bytes of its file."""
    from skops.io import dumps

    sink = io.BytesIO(dumps({"format": FORMAT, **content}, compression=zipfile.ZIP_DEFLATED))
    with zipfile.ZipFile(sink, "a") as archive:
        archive.comment = kind.mark + digest(archive).encode()
    return sink.getvalue()


def read_bytes(path: str | Path, kind: ArchiveKind) -> bytes:
    """Return the bytes of a model file; raises the kind's error when it cannot be read."""
    try:
        return Path(path).read_bytes()
    except OSError as problem:
        raise kind.error(
            f"{kind.name.capitalize()} {path}: {problem.strerror or problem}. Check the path. Make one: {kind.make}"
        ) from None


def unpacked(
    content: bytes, kind: ArchiveKind, *, trusted: Sequence[str], name: str, here: Mapping[str, str]
) -> dict[str, Any]:
    """Return what the bytes of a file hold, made of trusted types only.

    Parameters
    ----------
    content : bytes
    kind : ArchiveKind
    trusted : sequence of str
        Everything beyond numbers and texts that the file may hold. skops itself knows scikit-learn's own estimators.
    name : str
        What messages call the file.
    here : mapping of str to str
        See `model_versions`.

    Raises
    ------
    RotorwiseError
        The kind's, when the file is damaged, was edited, or is of another kind; when it holds a type that is not
        trusted; when these versions cannot read it.
    """
    from skops.io import get_untrusted_types, loads

    _check_whole(content, kind, name)
    try:
        unknown = sorted(set(get_untrusted_types(data=content)) - set(trusted))
    except Exception as problem:
        raise kind.error(f"{name} cannot be read: {problem}. Train again.") from None
    if unknown:
        raise kind.error(f"{name} holds {unknown[0]}, which no {kind.name} holds. Do not use it; train again.")
    try:
        # What cannot be loaded safely was refused above.
        found = loads(content, trusted=list(trusted))
        stated = found["format"]
    except Exception as problem:
        raise unreadable(problem, kind, name=name, here=here) from None
    if stated != FORMAT:
        raise kind.error(f"{name} has format {stated}; allowed: {FORMAT}. Train it again.")
    return found


def unreadable(problem: Exception, kind: ArchiveKind, *, name: str, here: Mapping[str, str]) -> RotorwiseError:
    """Return the error for a whole file of the kind that these versions cannot make a model of."""
    versions = ", ".join(f"{package} {own}" for package, own in here.items())
    return kind.error(
        f"{name} cannot be read by {versions} ({type(problem).__name__}: {problem}). Train it again with these "
        "versions."
    )


def other_versions(card: Mapping[str, Any], here: Mapping[str, str]) -> tuple[str, ...]:
    """Return a remark when a model was made with other versions than those here."""
    made = card.get("versions", {})
    other = [f"{name} {made.get(name, '?')} (here {own})" for name, own in here.items() if made.get(name) != own]
    if not other:
        return ()
    return (f"The model was made with {', '.join(other)}: its answers may differ a little. Train it again.",)


def digest(archive: zipfile.ZipFile) -> str:
    """Return the SHA-256 of all parts of an archive, with their names and lengths, in hexadecimal digits."""
    total = hashlib.sha256()
    for name in sorted(archive.namelist()):
        part = archive.read(name)
        total.update(f"{name}\0{len(part)}\0".encode() + part)
    return total.hexdigest()


def _check_whole(content: bytes, kind: ArchiveKind, name: str) -> None:
    said = _comment(content)
    if said is None:
        raise kind.error(f"{name} is no {kind.name} of rotorwise, or a damaged one. Make one: {kind.make}")
    if not said.startswith(kind.mark):
        raise kind.error(f"{name} is {_other_kind(said)}no {kind.name} of rotorwise. Make one: {kind.make}")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            found = digest(archive)
    except Exception as problem:
        raise kind.error(f"{name} is damaged: {problem}. Restore it from a copy, or train again.") from None
    if said != kind.mark + found.encode():
        raise kind.error(f"{name} was changed after it was written. Do not use it; train again.")


def _other_kind(said: bytes) -> str:
    """Return what an archive of another kind is, for a message."""
    found = re.match(rb"rotorwise ([a-z ]+) [0-9a-f]{64}$", said)
    return f"a {found[1].decode()}, " if found else ""


def _is_one(content: bytes, kind: ArchiveKind) -> bool:
    said = _comment(content)
    return said is not None and said.startswith(kind.mark)


def _comment(content: bytes) -> bytes | None:
    """Return the comment of an archive, None for what is none."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return archive.comment
    except (zipfile.BadZipFile, EOFError, ValueError, NotImplementedError):
        return None

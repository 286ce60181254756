"""Recordings to files that the readers here read back, each with the sidecar that says what its format cannot."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from .errors import InvalidValueError
from .recording import Recording
from .write_sidecar import FIRST_WORDS, sidecar_text
from .writers import Writer, csv_text, find_writer, numpy_arrays


@dataclass(frozen=True)
class Destination:
    """Where a recording goes: a file, its sidecar and the writer of the format."""

    path: Path
    sidecar: Path
    writer: Writer


def destination(path: Path | str, *, file_format: str = "", force: bool = False) -> Destination:
    """Return where a recording can be written, or say why not; nothing is written.

    Parameters
    ----------
    path : path
    file_format : str
        Name of a writer; the path's suffix decides when it is empty.
    force : bool
        Whether files written here before may be replaced.

    Raises
    ------
    InvalidValueError
        For an unknown format, a missing folder, an existing file without ``force``, and a file of somebody else's in
        the sidecar's place.
    """
    path = Path(path)
    writer = find_writer(path, file_format=file_format)
    sidecar = path.with_suffix(".toml")
    if sidecar == path:
        raise InvalidValueError(f"{path} has the suffix of its own sidecar; allowed: any other. Change the suffix.")
    _free(path, force=force)
    if sidecar.exists() and not _is_ours(sidecar):
        raise InvalidValueError(
            f"{sidecar} exists and would become the sidecar of {path.name}, but rotorwise has not written it: it is "
            "never replaced. Choose another file name."
        )
    _free(sidecar, force=force)
    return Destination(path, sidecar, writer)


def write_recording(
    recording: Recording,
    path: Path | str,
    *,
    file_format: str = "",
    notes: Mapping[str, str] | None = None,
    remarks: str = "",
    force: bool = False,
) -> Destination:
    """Write a recording and its sidecar, so that reading gives the same recording.

    Both files are written beside their places and renamed: they are whole or absent.

    Parameters
    ----------
    recording : Recording
    path, file_format, force
        See `destination`.
    notes : mapping of str to str, optional
        Header fields, where the format has room for such.
    remarks : str
        Lines that the sidecar holds as comments.

    Returns
    -------
    Destination
        What was written.

    Raises
    ------
    InvalidValueError
        As for `destination`, or when the format cannot hold the recording or the place cannot be written to.
    """
    made = destination(path, file_format=file_format, force=force)
    drafts = [one.with_name(f".{one.name}.{os.getpid()}.part") for one in (made.path, made.sidecar)]
    try:
        made.writer.write(recording, drafts[0], notes=notes or {})
        drafts[1].write_text(sidecar_text(recording, file_name=made.path.name, remarks=remarks), encoding="utf-8")
        for draft, target in zip(drafts, (made.path, made.sidecar), strict=True):
            draft.replace(target)
    except OSError as problem:
        raise InvalidValueError(
            f"{made.path} cannot be written: {problem.strerror or problem}. Choose another place."
        ) from problem
    finally:
        for draft in drafts:
            draft.unlink(missing_ok=True)
    return made


def write_csv(recording: Recording, path: Path | str, *, force: bool = False) -> Path:
    """Write a recording as CSV without a sidecar: ``# key: value``, a header ``name (unit)``, one row a sample, SI.

    Digits are enough to read back exactly the same numbers. A tacho channel comes back as one when its name
    says so (tacho, keyphasor).

    Parameters
    ----------
    recording : Recording
        What to write.
    path : path
        File to write.
    force : bool
        Replace an existing file.

    Raises
    ------
    InvalidValueError
        When the file exists and ``force`` is not set, or the folder is missing.
    """
    path = _free(Path(path), force=force)
    csv_text.write(recording, path, notes={})
    return path


def write_npz(recording: Recording, path: Path | str, *, force: bool = False) -> Path:
    """Write a recording as compressed NPZ: ``signals`` (channels, samples), rate, names, units, speed, label.

    Raises
    ------
    InvalidValueError
        As for :func:`write_csv`.
    """
    path = Path(path)
    path = _free(path if path.suffix == ".npz" else path.with_name(path.name + ".npz"), force=force)
    numpy_arrays.write(recording, path, notes={})
    return path


def _is_ours(sidecar: Path) -> bool:
    try:
        return sidecar.is_file() and sidecar.read_bytes().startswith(FIRST_WORDS.encode())
    except OSError:
        return False


def _free(path: Path, *, force: bool) -> Path:
    if path.is_dir():
        raise InvalidValueError(f"{path} is a folder; allowed: a file. Add a file name.")
    if path.exists() and not path.is_file():
        raise InvalidValueError(f"{path} is no regular file. Give another name.")
    if path.exists() and not force:
        raise InvalidValueError(f"{path} exists already. Give another name, or force (--force) to replace it.")
    if not path.parent.is_dir():
        raise InvalidValueError(f"Folder {path.parent} does not exist. Make it first, or give another.")
    return path

"""Where a dataset lies: a folder of this computer, or any location that fsspec knows (s3://, gs://, memory://, ...).

Both give the same few operations. A file is always whole: in a folder it is written beside its place, flushed to the
disk and renamed; an object store shows an object when all of it has arrived.
"""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import BinaryIO, Protocol
from urllib.parse import unquote, urlsplit

from .errors import InvalidValueError, RotorwiseError

#: Drafts of files; a reader of the data does not look here.
DRAFTS = ".unfinished"
_LOCK = ".lock"
#: Takes a line for people.
Say = Callable[[str], None]


class StoreError(RotorwiseError):
    """A dataset cannot be read, written or continued."""


class Folder(Protocol):
    """A place for files. Names are relative, with "/"."""

    name: str
    #: Whether other processes, on other computers too, reach it under the same name.
    is_shared: bool

    def sizes(self, prefix: str) -> dict[str, int]:
        """Return name and bytes of the files right below a sub-folder; none when it is missing."""
        ...

    def read(self, name: str) -> bytes | None:
        """Return a file's content, None when it is missing."""
        ...

    def open(self, name: str) -> BinaryIO:
        """Open a file that exists for reading."""
        ...

    def end(self, name: str, count: int) -> bytes:
        """Return the last bytes of a file that exists, or all of a shorter one."""
        ...

    def write(self, name: str, content: bytes) -> None:
        """Write a file; it is there as a whole or as it was before."""
        ...

    def is_empty(self) -> bool:
        """Return whether nothing but our own drafts and lock is there."""
        ...

    def alone(self, say: Say = ...) -> AbstractContextManager[Callable[[], None]]:
        """Return a context in which no other process builds here, or raise StoreError.

        What it gives raises StoreError when another build has taken over. `say` is told what is waited for.
        """
        ...


def quiet(_text: str) -> None:
    """Say nothing."""


def folder_of(location: str | Path) -> Folder:
    """Return the folder of a path, a file:// address or another address.

    Raises
    ------
    InvalidValueError
        For an empty text, or an address of a kind that is not installed.
    """
    text = str(location)
    if not text:
        raise InvalidValueError("The location is an empty text; allowed: a folder, or an address. Give one.")
    if isinstance(location, Path) or "://" not in text:
        return LocalFolder(Path(location))
    if text.startswith("file://"):
        return LocalFolder(Path(unquote(urlsplit(text).path)))
    from .store_remote import RemoteFolder

    return RemoteFolder(text)


class LocalFolder:
    """A folder of this computer."""

    is_shared = False

    def __init__(self, path: Path) -> None:
        self.path, self.name = path, str(path)

    def sizes(self, prefix: str) -> dict[str, int]:
        """See `Folder`."""
        with self._told("read"):
            folder = self.path / prefix
            found = folder.iterdir() if folder.is_dir() else ()
            return {one.name: one.stat().st_size for one in found if one.is_file()}

    def read(self, name: str) -> bytes | None:
        """See `Folder`."""
        with self._told("read"):
            return (self.path / name).read_bytes() if (self.path / name).is_file() else None

    def open(self, name: str) -> BinaryIO:
        """See `Folder`."""
        with self._told("read"):
            return (self.path / name).open("rb")

    def end(self, name: str, count: int) -> bytes:
        """See `Folder`."""
        with self._told("read"), (self.path / name).open("rb") as file:
            file.seek(max(file.seek(0, os.SEEK_END) - count, 0))
            return file.read()

    def write(self, name: str, content: bytes) -> None:
        """See `Folder`."""
        target = self.path / name
        draft = self.path / DRAFTS / f"{target.name}.{os.getpid()}.{uuid.uuid4().hex[:8]}"
        with self._told("written to"):
            for folder in (draft.parent, target.parent):
                folder.mkdir(parents=True, exist_ok=True)
            try:
                with draft.open("xb") as file:
                    file.write(content)
                    file.flush()
                    os.fsync(file.fileno())
                draft.replace(target)
            finally:
                draft.unlink(missing_ok=True)
            _flush_folder(target.parent)

    def is_empty(self) -> bool:
        """See `Folder`."""
        with self._told("read"):
            if not self.path.exists():
                return True
            if not self.path.is_dir():
                raise StoreError(f"{self.path} is a file. Choose a folder.")
            return all(one.name in (DRAFTS, _LOCK) for one in self.path.iterdir())

    @contextmanager
    def alone(self, say: Say = quiet) -> Iterator[Callable[[], None]]:
        """See `Folder`. The lock ends with the process, however that ends."""
        del say
        with self._told("written to"):
            self.path.mkdir(parents=True, exist_ok=True)
            lock = (self.path / _LOCK).open("ab")
        with lock:
            with self._told("locked"):
                free = _locked(lock)
            if not free:
                raise StoreError(
                    f"Another process is building in {self.path}. Wait for it, or stop it; nothing has been changed."
                )
            # Whoever wrote a draft that is there now has ended.
            for draft in self.sizes(DRAFTS):
                (self.path / DRAFTS / draft).unlink(missing_ok=True)
            yield lambda: None

    @contextmanager
    def _told(self, done: str) -> Iterator[None]:
        try:
            yield
        except OSError as problem:
            raise StoreError(
                f"{self.path} cannot be {done}: {problem.strerror or problem}. What has been built is whole; make "
                "room or choose another place, then build again: it goes on there."
                if done == "written to"
                else f"{self.path} cannot be {done}: {problem.strerror or problem}. Check path and rights."
            ) from problem


def _flush_folder(path: Path) -> None:
    """Make a rename survive a loss of power; systems that cannot open folders do it by themselves."""
    try:
        number = os.open(path, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(number)
    except OSError:
        pass
    finally:
        os.close(number)


def _locked(file: BinaryIO) -> bool:
    """Lock a file until this process ends; return whether that was possible."""
    try:
        if os.name == "nt":
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # pyright: ignore[reportAttributeAccessIssue]
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except PermissionError:
        if os.name == "nt":
            return False
        raise
    return True

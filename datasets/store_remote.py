"""A dataset at a location that fsspec knows: s3://, gs://, memory://, ..."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import PurePosixPath
from typing import BinaryIO, cast

from .errors import InvalidValueError, RotorwiseError
from .store_folder import Say, StoreError, quiet
from .store_lease import LEASE, leased

#: Object stores: asking one for a folder may make a bucket that nobody wanted.
_WITHOUT_FOLDERS = ("memory", "s3", "s3a", "gs", "gcs", "abfs", "az")


class RemoteFolder:
    """A location that fsspec knows. Builds notice each other by a lease (`store_lease`)."""

    def __init__(self, address: str) -> None:
        self.name = address.rstrip("/")
        self.scheme = scheme = address.partition("://")[0]
        # What lives in this process's memory is seen by this process only.
        self.is_shared = scheme != "memory"
        try:
            import fsspec

            self.system, root = fsspec.url_to_fs(self.name)
        except ImportError as problem:
            raise InvalidValueError(
                f"{address} needs {problem.name or 'fsspec'}, which is not installed. Run: pip install "
                f"{'s3fs' if scheme == 's3' else problem.name or 'fsspec'}"
            ) from None
        except ValueError as problem:
            raise InvalidValueError(f"{address}: {problem}. Give a folder, or an address that fsspec knows.") from None
        self.root = cast(str, root).rstrip("/")

    def _at(self, name: str) -> str:
        return f"{self.root}/{name}"

    def sizes(self, prefix: str) -> dict[str, int]:
        """See `Folder`."""
        with self._told("read"):
            # What another computer has written since is not in the listing that was kept.
            self.system.invalidate_cache()
            try:
                found = self.system.ls(self._at(prefix), detail=True)
            except FileNotFoundError:
                return {}
            return {PurePosixPath(one["name"]).name: int(one["size"] or 0) for one in found if one["type"] == "file"}

    def read(self, name: str) -> bytes | None:
        """See `Folder`."""
        with self._told("read"):
            try:
                return cast(bytes, self.system.cat_file(self._at(name)))
            except FileNotFoundError:
                return None

    def open(self, name: str) -> BinaryIO:
        """See `Folder`."""
        with self._told("read"):
            return cast(BinaryIO, self.system.open(self._at(name), "rb"))

    def end(self, name: str, count: int) -> bytes:
        """See `Folder`."""
        with self._told("read"):
            start = max(int(self.system.size(self._at(name)) or 0) - count, 0)
            return cast(bytes, self.system.cat_file(self._at(name), start=start))

    def write(self, name: str, content: bytes) -> None:
        """See `Folder`."""
        with self._told("written to"):
            target = self._at(name)
            if self.scheme not in _WITHOUT_FOLDERS:
                self.system.makedirs(target.rpartition("/")[0], exist_ok=True)
            self.system.pipe_file(target, content)

    def is_empty(self) -> bool:
        """See `Folder`."""
        with self._told("read"):
            self.system.invalidate_cache()
            try:
                found = self.system.ls(self.root, detail=False)
            except FileNotFoundError:
                return True
        # Consoles of object stores make an object of no bytes for a folder.
        return all(one.rstrip("/") == self.root or PurePosixPath(one).name == LEASE for one in found)

    def remove(self, name: str) -> None:
        """Remove a file that exists."""
        with self._told("written to"):
            self.system.rm_file(self._at(name))

    def alone(self, say: Say = quiet) -> AbstractContextManager[Callable[[], None]]:
        """See `Folder`."""
        return leased(self, say)

    @contextmanager
    def _told(self, done: str) -> Iterator[None]:
        try:
            yield
        except RotorwiseError:
            raise
        except Exception as problem:
            # Each kind of store has errors of its own; all mean that the place does not answer.
            raise StoreError(
                f"{self.name} cannot be {done}: {type(problem).__name__}: {problem}. Check address and rights, then "
                "build again: it goes on where it stopped."
            ) from problem

"""A lease: the file by which builds at an object store notice each other.

An object store has no lock that ends with a process. So a build writes who it is into ``.lease.json`` and counts on
there every `REFRESH_S`. Another build that finds the file watches it. When the count goes on, that build is refused.
When nothing changes for `LIFE_S`, it takes over; at once where the process ran on this computer and has ended. Only
changes count: clocks of computers differ.

An object store cannot create a file only where there is none either: of two builds that begin at the same moment both
write. Each reads back after `PAUSE_S`; the one whose lease has been overwritten is refused.

What remains possible: a writing that takes longer than the pause; a build that was silent for longer than `LIFE_S` (a
computer asleep, a network away) and comes back. Then two build until the one that lost its lease looks at it, which
is `REFRESH_S` later at most and before its next part; that one stops. With the same recipe both write the same bytes.
"""

from __future__ import annotations

import json
import os
import platform
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Protocol

from .store_folder import Say, StoreError

LEASE = ".lease.json"
REFRESH_S = 5.0
LIFE_S = 30.0
PAUSE_S = 1.0


class Place(Protocol):
    """What a lease needs of a location; see `store_folder.Folder`."""

    name: str

    def read(self, name: str) -> bytes | None: ...  # noqa: D102
    def write(self, name: str, content: bytes) -> None: ...  # noqa: D102
    def remove(self, name: str) -> None: ...  # noqa: D102


@contextmanager
def leased(place: Place, say: Say) -> Iterator[Callable[[], None]]:
    """Hold the lease of a location, refreshed by a thread; give what raises when another build has taken over.

    Raises
    ------
    StoreError
        When another build holds it and is alive.
    """
    lease, ended = _Lease(place), threading.Event()
    keeper = threading.Thread(target=lease.keep, args=(ended,), daemon=True)
    try:
        lease.take(say)
        keeper.start()
        yield lease.check
    finally:
        ended.set()
        if keeper.is_alive():
            # It may be writing: the lease would be there again after its removal.
            keeper.join(LIFE_S)
        lease.release()


class _Lease:
    def __init__(self, place: Place) -> None:
        self.place, self.lost_to = place, ""
        process = os.getpid()
        self.said: dict[str, Any] = {
            "token": uuid.uuid4().hex,
            "host": platform.node(),
            "computer": _computer(),
            "process": process,
            "born": _born(process),
            "since": datetime.now(UTC).isoformat(" ", "seconds"),
            "count": 0,
        }

    def take(self, say: Say) -> None:
        """Become the holder, after having seen that nobody else is."""
        found = self.place.read(LEASE)
        if found is not None:
            if not _has_ended(_understood(found)):
                say(f"{self.place.name}: is {_who(found)} alive? Looking for a sign, {LIFE_S:g} s at most.")
                self._watch(found)
            say(f"{self.place.name}: took over from {_who(found)}, which builds no more.")
        self._write()
        time.sleep(PAUSE_S)
        self._look()
        if self.lost_to:
            raise _refusal(self.place.name, self.lost_to)

    def keep(self, ended: threading.Event) -> None:
        """Refresh the lease until the build ends or another one has taken over."""
        while not self.lost_to and not ended.wait(REFRESH_S):
            # A store that does not answer is told by the build when it writes; until then it may answer again.
            with suppress(StoreError):
                self._look()
                if not self.lost_to:
                    self._write()

    def check(self) -> None:
        """Raise StoreError when another build has taken over."""
        if self.lost_to:
            raise StoreError(
                f"{self.place.name}: {self.lost_to} has taken over, as this build gave no sign of life for {LIFE_S:g} "
                "s (was the computer asleep, or the network away?). This one stops; what has been built is whole."
            )

    def release(self) -> None:
        """Remove the lease if it is this one."""
        with suppress(StoreError):
            found = self.place.read(LEASE)
            if found is not None and self._is_own(found):
                self.place.remove(LEASE)

    def _is_own(self, found: bytes) -> bool:
        return _understood(found).get("token") == self.said["token"]

    def _look(self) -> None:
        found = self.place.read(LEASE)
        if found is not None and not self._is_own(found):
            self.lost_to = _who(found)

    def _write(self) -> None:
        self.said["count"] += 1
        self.place.write(LEASE, json.dumps(self.said).encode())

    def _watch(self, found: bytes) -> None:
        """Return when a lease has not changed for its life or is gone; raise when it changes."""
        until = time.monotonic() + LIFE_S
        while time.monotonic() < until:
            time.sleep(REFRESH_S / 5)
            now = self.place.read(LEASE)
            if now is None:
                return
            if now != found:
                raise _refusal(self.place.name, _who(now))


def _refusal(name: str, who: str) -> StoreError:
    return StoreError(f"Another build is writing to {name}: {who}. Wait for it, or stop it; nothing has been changed.")


def _understood(found: bytes) -> dict[str, Any]:
    """Return what a lease says; nothing when somebody else has written the file."""
    try:
        said = json.loads(found)
    except ValueError:
        return {}
    return said if isinstance(said, dict) else {}


def _who(found: bytes) -> str:
    said = _understood(found)
    return f"process {said.get('process', '?')} on {said.get('host', '?')}, begun {said.get('since', '?')}"


def _has_ended(said: dict[str, Any]) -> bool:
    """Return whether a lease is of a process of this computer that is surely not there any more."""
    number = said.get("process")
    # On Windows os.kill would end the process.
    if os.name == "nt" or not isinstance(number, int) or said.get("computer") != _computer():
        return False
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    # Numbers are given again: another process has another birth.
    return said.get("born") != _born(number)


def _born(process: int) -> str:
    """Return when a process began, in ticks since the start of the computer; "" where that cannot be known."""
    try:
        state, *fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except (OSError, ValueError):
        return ""
    # A killed process whose parent has not looked yet computes no more.
    return "ended" if state in "ZX" else fields[18]


def _computer() -> str:
    """Return what tells this computer, and in it this container, from all others."""
    parts = [platform.node()]
    with suppress(OSError):
        parts.append(Path("/proc/sys/kernel/random/boot_id").read_text(encoding="utf-8").strip())
        parts.append(os.readlink("/proc/self/ns/pid"))
    return " ".join(parts if len(parts) > 1 else [*parts, f"{uuid.getnode():x}"])

"""Builds at an object store notice each other: one holds the lease, a stale one blocks nobody."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from rotorwise.datasets import store_lease
from rotorwise.datasets.generate import Progress, build
from rotorwise.datasets.store_folder import Folder, StoreError, folder_of
from rotorwise.datasets.store_lease import LEASE, leased

fsspec = pytest.importorskip("fsspec", reason="needs fsspec (pip install fsspec)")
SMALL = Path(__file__).with_name("recipe_small.toml")
_START_S = 100.0


@pytest.fixture
def place(request: pytest.FixtureRequest) -> Folder:
    """Return an empty location in memory."""
    return folder_of(f"memory://lease/{request.node.name}")


@pytest.fixture
def fast(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make leases live for 1.5 s."""
    for name, seconds in (("REFRESH_S", 0.1), ("LIFE_S", 1.5), ("PAUSE_S", 0.1)):
        monkeypatch.setattr(store_lease, name, seconds)


def ours(**changes: object) -> bytes:
    """Return a lease of this process with changes."""
    return json.dumps({**store_lease._Lease(folder_of("memory://x")).said, **changes}).encode()  # type: ignore[arg-type]


@pytest.mark.usefixtures("fast")
def test_a_second_build_is_refused_while_the_first_one_lives(place: Folder) -> None:
    said: list[str] = []
    with place.alone():
        with pytest.raises(StoreError, match=rf"Another build is writing to .*: process {os.getpid()} on .*, begun 20"):
            build(SMALL, place.name, workers=1, limit=1, say=said.append)
        assert place.sizes("data") == {}
        assert place.read("dataset.json") is None
    assert len(said) == 1
    assert "Looking for a sign, 1.5 s at most" in said[0]
    build(SMALL, place.name, workers=1, limit=1)
    assert place.read(LEASE) is None


@pytest.mark.usefixtures("fast")
@pytest.mark.parametrize(
    "left",
    [ours(computer="another one"), ours(), b"{", b"[]", b'{"process": true}'],
    # The first two differ in every process of the test run.
    ids=["another computer", "this computer", "half", "a list", "no number"],
)
def test_a_lease_that_nobody_refreshes_is_taken_over(place: Folder, left: bytes) -> None:
    place.write(LEASE, left)
    said: list[str] = []
    begun = time.monotonic()
    with place.alone(said.append):
        assert time.monotonic() - begun >= 1.5
        assert place.read(LEASE) != left
    assert "took over from process" in said[-1]


@pytest.mark.usefixtures("fast")
def test_a_lease_that_goes_away_is_not_waited_for(place: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_lease, "LIFE_S", 60.0)
    place.write(LEASE, ours(computer="another one"))
    threading.Timer(0.3, lambda: place.remove(LEASE)).start()  # type: ignore[attr-defined]
    begun = time.monotonic()
    with place.alone():
        assert time.monotonic() - begun < 30


@pytest.mark.usefixtures("fast")
def test_of_two_that_begin_at_the_same_moment_one_builds(place: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_lease, "PAUSE_S", 0.5)
    gate, done, outcomes = threading.Barrier(4), threading.Barrier(4), []

    def begin() -> None:
        gate.wait()
        try:
            with place.alone():
                outcomes.append("in")
                done.wait()
        except StoreError:
            outcomes.append("refused")
            done.wait()

    threads = [threading.Thread(target=begin) for _ in range(4)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert sorted(outcomes) == ["in", "refused", "refused", "refused"]
    assert place.read(LEASE) is None


@pytest.mark.usefixtures("fast")
def test_a_build_that_lost_its_lease_stops_and_leaves_the_new_one(place: Folder) -> None:
    other = ours(token="another", host="vib-3")

    def tell(now: Progress) -> None:
        if now.signals == 10:
            place.write(LEASE, other)
            time.sleep(1.0)

    with pytest.raises(StoreError, match=r"on vib-3, .* has taken over"):
        build(SMALL, place.name, workers=1, tell=tell)
    assert place.read(LEASE) == other
    assert list(place.sizes("data")) == ["part-000000.parquet"]


@pytest.mark.usefixtures("fast")
@pytest.mark.parametrize("problem", [StoreError, KeyboardInterrupt, ZeroDivisionError])
def test_the_lease_goes_with_a_build_that_fails(place: Folder, problem: type[BaseException]) -> None:
    def tell(_now: Progress) -> None:
        assert place.read(LEASE) is not None
        raise problem("on the way")

    with pytest.raises(problem, match="on the way"):
        build(SMALL, place.name, workers=1, tell=tell)
    assert place.read(LEASE) is None


def test_a_store_that_is_away_for_a_while_costs_the_lease_nothing(fast: None) -> None:
    class Unsteady:
        """A store that does not answer while it is away."""

        def __init__(self) -> None:
            self.name, self.files, self.is_away = "unsteady", dict[str, bytes](), False

        def read(self, name: str) -> bytes | None:
            if self.is_away:
                raise StoreError("no answer")
            return self.files.get(name)

        def write(self, name: str, content: bytes) -> None:
            self.read(name)
            self.files[name] = content

        def remove(self, name: str) -> None:
            del self.files[name]

    place = Unsteady()
    with leased(place, lambda _text: None) as check:
        place.is_away = True
        time.sleep(0.5)
        before, place.is_away = place.files[LEASE], False
        time.sleep(0.5)
        assert place.files[LEASE] != before
        check()
    assert place.files == {}


@pytest.mark.skipif(os.name == "nt", reason="processes are asked for by signals")
def test_who_has_ended_is_told_from_who_has_not() -> None:
    def has_ended(**changes: object) -> bool:
        return store_lease._has_ended(json.loads(ours(**changes)))

    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    try:
        theirs = {"process": child.pid, "born": store_lease._born(child.pid)}
        assert not has_ended()
        assert not has_ended(**theirs)
        if Path("/proc/self/stat").exists():
            # The number was given again.
            assert has_ended(process=child.pid)
    finally:
        child.kill()
    if Path("/proc/self/stat").exists():
        for _ in range(1000):
            if Path(f"/proc/{child.pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "Z":
                break
            time.sleep(0.01)
        assert has_ended(**theirs)
    child.wait()
    assert has_ended(**theirs)
    assert not has_ended(**theirs, computer="another one")
    assert not has_ended(process="4711")
    assert not has_ended(process=10**30)


_BUILDER = """
import sys
from rotorwise.datasets.generate import build
def tell(now):
    print(now.signals, flush=True)
    if now.signals == 20:
        sys.stdin.read()
if __name__ == "__main__":
    build(sys.argv[1], sys.argv[2], workers=int(sys.argv[3]), tell=tell)
"""


class Builder:
    """A build in a process of its own, which stops after 20 signals and waits."""

    def __init__(self, script: Path, address: str, workers: int) -> None:
        script.write_text(_BUILDER, encoding="utf-8")
        words = [sys.executable, str(script), str(SMALL), address, str(workers)]
        self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        assert any(line == "20\n" for line in self.process.stdout)

    def end(self, number: signal.Signals) -> None:
        """Send a signal and wait for the end."""
        self.process.send_signal(number)
        self.process.communicate(timeout=_START_S)


@pytest.fixture
def builder(bucket: str, tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Builder]:
    made = Builder(tmp_path / "builder.py", f"{bucket}/sets/a", request.param)
    yield made
    made.process.kill()
    made.process.communicate()


@pytest.mark.parametrize("builder", [1, 2], indirect=True)
@pytest.mark.slow
def test_on_s3_a_build_is_alone_and_a_killed_one_blocks_nobody(
    builder: Builder, bucket: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(StoreError, match=f"Another build is writing to {bucket}/sets/a: process {builder.process.pid}"):
        build(SMALL, f"{bucket}/sets/a", workers=1)
    builder.end(signal.SIGKILL)
    folder = folder_of(f"{bucket}/sets/a")
    assert folder.read(LEASE) is not None
    # Whoever waits for the end of this life does not pass.
    monkeypatch.setattr(store_lease, "LIFE_S", 1e6)
    said: list[str] = []
    seen: list[Progress] = []
    build(SMALL, f"{bucket}/sets/a", workers=1, tell=seen.append, say=said.append)
    assert [f"took over from process {builder.process.pid} on" in line for line in said] == [True]
    assert (seen[0].signals, seen[-1].signals) == (20, 60)
    assert folder.read(LEASE) is None


@pytest.mark.parametrize("builder", [1], indirect=True)
def test_on_s3_an_interrupted_build_takes_its_lease_away(builder: Builder, bucket: str) -> None:
    builder.end(signal.SIGINT)
    folder = folder_of(f"{bucket}/sets/a")
    assert folder.read(LEASE) is None
    assert b" of 60 signals so far" in (folder.read("card.md") or b"")

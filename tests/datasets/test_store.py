"""The store: nothing lost, doubled or half-written, whatever happens; nobody else's files touched."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from multiprocessing import active_children
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from rotorwise.datasets import recipe_parts
from rotorwise.datasets.errors import BuildError, InvalidValueError
from rotorwise.datasets.generate import Progress, build, summary_of
from rotorwise.datasets.recipe_file import load_recipe
from rotorwise.datasets.store import Store, open_store
from rotorwise.datasets.store_folder import LocalFolder, StoreError, folder_of

SMALL = Path(__file__).with_name("recipe_small.toml")
KILLS = 20


def content(folder: Path) -> dict[str, bytes]:
    """Return the bytes of every file among the data."""
    return {path.name: path.read_bytes() for path in sorted((folder / "data").iterdir())}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the small dataset, built without interruption."""
    return Path(build(SMALL, tmp_path_factory.mktemp("whole") / "set", workers=1).folder.name)


#: Builds in forked processes, which have everything imported, and kills each after a while; tells how far each came.
_KILLER = """
import os, random, signal, sys, time
from pathlib import Path
from rotorwise.datasets.generate import build
from rotorwise.datasets.recipe_file import load_recipe
from rotorwise.datasets import generate_part, recipe_parts
recipe_parts.MOST_RUNS = 2
recipe, folder, kills = load_recipe(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])
generate_part.make_part(recipe.source, 0)
random.seed(3)
data = folder / "data"
def parts():
    return len(list(data.iterdir())) if data.is_dir() else 0
for kill in range(kills):
    wanted = parts() + random.choice((0, 0, 1, 1))
    child = os.fork()
    if child == 0:
        build(recipe, folder, workers=1)
        os._exit(0)
    # At a random point on the way to the next part, on a busy computer too.
    while parts() < wanted and os.waitpid(child, os.WNOHANG) == (0, 0):
        time.sleep(0.001)
    time.sleep(random.uniform(0.0, 0.1))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    print(parts(), flush=True)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.slow
def test_killed_at_random_it_loses_doubles_and_halves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Many small parts, so that a kill comes between any two steps.
    monkeypatch.setattr(recipe_parts, "MOST_RUNS", 2)
    reference = content(Path(build(SMALL, tmp_path / "whole", workers=1).folder.name))
    assert len(reference) == 30
    folder = tmp_path / "set"
    words = [sys.executable, "-c", _KILLER, str(SMALL), str(folder), str(KILLS)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=250, check=True)
    came = [int(line) for line in done.stdout.split()]
    assert len(came) == KILLS
    assert came == sorted(came), "a part was lost"
    # Otherwise the kills came all before the first part or after the last one.
    assert len({count for count in came if 0 < count < len(reference)}) > 4
    assert all(reference[name] == raw for name, raw in content(folder).items())
    build(SMALL, folder, workers=1)
    assert content(folder) == reference
    assert sorted(path.name for path in folder.rglob("*") if path.is_file() and path.parent.name != "data") == sorted(
        ["dataset.json", "manifest.json", "card.md", ".lock"]
    )


#: Where a build can end between two instructions: before a draft, half-way in it, before and after the renaming.
_CRASHES = {
    "no draft yet": "os.fsync = lambda number: None\nPath.open = end",
    "draft half written": "import io\nwrite = io.BufferedWriter.write\nos.fsync = end_cut",
    "draft written, not renamed": "Path.replace = end",
    "renamed, folder not flushed": "folders._flush_folder = end",
}
_CRASHER = """
import os, sys
from pathlib import Path
from rotorwise.datasets import store_folder as folders
from rotorwise.datasets.generate import build
def end(*_words, **_options):
    os._exit(9)
def end_cut(number):
    os.ftruncate(number, os.fstat(number).st_size // 2)
    os._exit(9)
def tell(now):
    if now.signals == 20:
        {crash}
        pass
build(sys.argv[1], sys.argv[2], workers=1, tell=tell)
"""


@pytest.mark.parametrize("name", _CRASHES)
def test_it_goes_on_after_an_end_at_any_step_of_a_writing(name: str, whole: Path, tmp_path: Path) -> None:
    script = _CRASHER.format(crash=_CRASHES[name].replace("\n", "\n        "))
    ended = subprocess.run([sys.executable, "-c", script, str(SMALL), str(tmp_path)], timeout=100, check=False)
    assert ended.returncode == 9
    found = content(tmp_path)
    assert len(found) == 3 if name.startswith("renamed") else len(found) == 2
    assert all(content(whole)[part] == raw for part, raw in found.items())
    seen: list[Progress] = []
    build(SMALL, tmp_path, workers=1, tell=seen.append)
    assert seen[0].signals == 10 * len(found)
    assert content(tmp_path) == content(whole)
    assert not list((tmp_path / ".unfinished").iterdir())


_BUILD = """
from rotorwise.datasets.generate import build
if __name__ == "__main__":
    {call}
"""


@pytest.mark.slow
def test_the_workers_of_a_killed_build_end_and_the_next_one_goes_on(whole: Path, tmp_path: Path) -> None:
    psutil = pytest.importorskip("psutil", reason="needs psutil, which dask brings")
    script = tmp_path.with_suffix(".py")
    script.write_text(_BUILD.format(call=f"build({str(SMALL)!r}, {str(tmp_path)!r}, workers=2)"), encoding="utf-8")
    parent = subprocess.Popen([sys.executable, str(script)])
    workers = []
    for _ in range(600):
        time.sleep(0.1)
        workers = psutil.Process(parent.pid).children(recursive=True)
        if (tmp_path / "data").is_dir() and any((tmp_path / "data").iterdir()):
            break
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    assert workers
    _, alive = psutil.wait_procs(workers, timeout=30)
    assert not alive
    build(SMALL, tmp_path, workers=2)
    assert content(tmp_path) == content(whole)


def test_a_worker_that_is_killed_is_told_and_nothing_is_lost(whole: Path, tmp_path: Path) -> None:
    before = set(active_children())

    def tell(now: Progress) -> None:
        if now.signals == 10:
            for process in set(active_children()) - before:
                process.kill()

    with pytest.raises(BuildError, match="was killed, most likely for lack of memory"):
        build(SMALL, tmp_path, workers=2, tell=tell)
    found = content(tmp_path)
    assert found
    assert all(content(whole)[name] == raw for name, raw in found.items())
    assert " of 60 signals so far" in (tmp_path / "card.md").read_text(encoding="utf-8")
    build(SMALL, tmp_path, workers=1)
    assert content(tmp_path) == content(whole)


def test_a_script_without_its_guard_is_told_what_to_do(tmp_path: Path) -> None:
    script = tmp_path / "plain.py"
    script.write_text(
        f"from rotorwise.datasets.generate import build\nbuild({str(SMALL)!r}, {str(tmp_path / 'set')!r}, workers=2)\n",
        encoding="utf-8",
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode != 0
    assert "BuildError: The first process ended" in done.stderr.replace("rotorwise.datasets.errors.", "")
    assert 'if __name__ == "__main__"' in done.stderr


_HOLDER = """
import sys, time
from rotorwise.datasets.store_folder import folder_of
with folder_of(sys.argv[1]).alone():
    print("in", flush=True)
    time.sleep(60)
"""


def test_a_second_build_in_the_same_folder_is_refused(tmp_path: Path) -> None:
    other = subprocess.Popen([sys.executable, "-c", _HOLDER, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    try:
        assert other.stdout is not None
        assert other.stdout.readline() == "in\n"
        with pytest.raises(StoreError, match="Another process is building"):
            build(SMALL, tmp_path, workers=1)
        assert not (tmp_path / "data").exists()
    finally:
        other.kill()
        other.communicate()
    # The lock ends with the process, however that ended.
    assert summary_of(build(SMALL, tmp_path, workers=1, limit=1))["rows"] == 1


def test_another_recipe_or_version_leaves_a_dataset_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    build(SMALL, tmp_path, workers=1, limit=10)
    before = content(tmp_path)
    text = SMALL.read_text(encoding="utf-8").replace("seed = 7", "seed = 8")
    (tmp_path.parent / "other.toml").write_text(text, encoding="utf-8")
    with pytest.raises(StoreError, match="of another recipe"):
        build(tmp_path.parent / "other.toml", tmp_path, workers=1)
    given = json.loads((tmp_path / "dataset.json").read_text(encoding="utf-8"))
    for change, words in (({"version": "0.0.1"}, "begun with rotorwise 0.0.1"), ({"content": 99}, "another format")):
        (tmp_path / "dataset.json").write_text(json.dumps({**given, **change}), encoding="utf-8")
        with pytest.raises(StoreError, match=words):
            build(SMALL, tmp_path, workers=1)
    (tmp_path / "dataset.json").write_text("{", encoding="utf-8")
    with pytest.raises(StoreError, match="is damaged"):
        open_store(tmp_path)
    assert content(tmp_path) == before


def test_a_dataset_without_a_part_may_be_begun_with_another_recipe(tmp_path: Path, whole: Path) -> None:
    def stop(_now: Progress) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        build("tiny", tmp_path, workers=1, tell=stop)
    build(SMALL, tmp_path, workers=1)
    assert content(tmp_path) == content(whole)
    assert open_store(tmp_path).recipe == load_recipe(SMALL)


def test_a_folder_of_somebody_else_is_not_touched(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("years of work", encoding="utf-8")
    with pytest.raises(StoreError, match="holds files, but no dataset"):
        build(SMALL, tmp_path, workers=1)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]
    with pytest.raises(StoreError, match="is a file"):
        build(SMALL, tmp_path / "thesis.txt", workers=1)
    with pytest.raises(StoreError, match="holds no dataset"):
        open_store(tmp_path)


@pytest.mark.parametrize("damage", ["cut", "empty", "text", "of another dataset"])
def test_a_damaged_part_is_noticed_and_made_again(damage: str, whole: Path, tmp_path: Path) -> None:
    build(SMALL, tmp_path, workers=1, limit=20)
    part = tmp_path / "data" / "part-000001.parquet"
    raw = part.read_bytes()
    other = (whole / "data" / "part-000002.parquet").read_bytes()
    part.write_bytes({"cut": raw[:-100], "empty": b"", "text": b"PAR1 hello", "of another dataset": other}[damage])
    store = open_store(tmp_path)
    assert list(store.parts()) == [0]
    assert summary_of(store)["unreadable"] == ["part-000001.parquet"]
    with pytest.raises(StoreError, match=r"part-000001\.parquet is damaged"):
        list(store.batches(["signal"]))
    build(SMALL, tmp_path, workers=1, limit=20)
    assert part.read_bytes() == raw


_FULL = """
import resource, sys
from rotorwise.datasets.generate import build
from rotorwise.datasets.store_folder import StoreError
def tell(now):
    if now.signals == 20:
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
if __name__ == "__main__":
    try:
        build(sys.argv[1], sys.argv[2], workers=int(sys.argv[3]), tell=tell)
    except StoreError as problem:
        print(problem)
        sys.exit(4)
"""


@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_full_disk_is_one_message_and_leaves_the_store_readable(workers: str, whole: Path, tmp_path: Path) -> None:
    pytest.importorskip("resource", reason="needs a limit on the size of files")
    script = tmp_path / "full.py"
    script.write_text(_FULL, encoding="utf-8")
    words = [sys.executable, str(script), str(SMALL), str(tmp_path / "set"), workers]
    done = subprocess.run(words, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == 4, done.stderr
    assert "cannot be written to: File too large" in done.stdout
    assert "it goes on there" in done.stdout
    store = open_store(tmp_path / "set")
    assert summary_of(store)["rows"] == 20
    assert pq.read_table(tmp_path / "set" / "data").num_rows == 20
    assert not list((tmp_path / "set" / ".unfinished").iterdir())
    build(SMALL, tmp_path / "set", workers=1)
    assert content(tmp_path / "set") == content(whole)


@pytest.mark.skipif(os.name == "nt", reason="rights of folders")
def test_a_folder_without_rights_is_an_error_that_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_words: Any, **_options: Any) -> None:
        raise PermissionError(13, "Permission denied")

    # The tests may run as root, whom no right stops.
    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(StoreError, match="cannot be written to: Permission denied"):
        build(SMALL, tmp_path / "set", workers=1)


# Other locations


def test_a_file_address_is_a_folder(whole: Path) -> None:
    folder = folder_of(whole.as_uri())
    assert isinstance(folder, LocalFolder)
    assert summary_of(open_store(whole.as_uri()))["rows"] == 60
    assert isinstance(folder_of(str(whole)), LocalFolder)


def stored(store: Store) -> dict[str, bytes]:
    """Return the parts at any location."""
    return {name: store.folder.read(f"data/{name}") or b"" for name in store.folder.sizes("data")}


def test_memory_is_a_location(whole: Path) -> None:
    fsspec = pytest.importorskip("fsspec", reason="needs fsspec (pip install fsspec)")
    with pytest.raises(StoreError, match="holds no dataset"):
        open_store("memory://rotorwise/a")
    build(SMALL, "memory://rotorwise/a", workers=1, limit=20)
    seen: list[Progress] = []
    store = build(SMALL, "memory://rotorwise/a", workers=2, tell=seen.append)
    assert seen[0].signals == 20
    assert stored(store) == content(whole)
    fsspec.filesystem("memory").pipe_file("/rotorwise/b/letter", b"mine")
    with pytest.raises(StoreError, match="holds files, but no dataset"):
        build(SMALL, "memory://rotorwise/b", workers=1)


@pytest.mark.slow
def test_s3_is_a_location(bucket: str, whole: Path) -> None:
    build(SMALL, f"{bucket}/sets/a", workers=1, limit=25)
    store = build(SMALL, f"{bucket}/sets/a", workers=2)
    assert stored(store) == content(whole)
    assert summary_of(open_store(f"{bucket}/sets/a")) == summary_of(open_store(whole))
    with pytest.raises(StoreError, match="cannot be written to"):
        build(SMALL, "s3://nobodys-bucket/a", workers=1, limit=1)
    # As the console makes an empty folder.
    boto3 = pytest.importorskip("boto3")
    boto3.client("s3").put_object(Bucket=bucket.removeprefix("s3://"), Key="sets/b/", Body=b"")
    assert summary_of(build(SMALL, f"{bucket}/sets/b/", workers=1, limit=5))["rows"] == 5


def test_an_empty_text_is_no_location(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # "$FOLDER" of a variable that is not set; the working folder is not meant.
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InvalidValueError, match="an empty text"):
        build(SMALL, "", workers=1)
    assert not list(tmp_path.iterdir())


def test_an_address_of_an_unknown_kind_is_refused() -> None:
    pytest.importorskip("fsspec", reason="needs fsspec (pip install fsspec)")
    with pytest.raises(InvalidValueError, match="fsspec knows"):
        build(SMALL, "telegraph://a/b", workers=1)


def test_the_recipe_of_a_dataset_is_in_the_dataset(whole: Path) -> None:
    assert open_store(whole).recipe == load_recipe(SMALL)


def test_damage_among_the_signals_is_told_when_they_are_read(tmp_path: Path) -> None:
    store = build(SMALL, tmp_path, workers=1, limit=10)
    part = tmp_path / "data" / "part-000000.parquet"
    raw = bytearray(part.read_bytes())
    raw[200:2000] = bytes(1800)
    part.write_bytes(raw)
    assert list(store.parts()) == [0]
    with pytest.raises(StoreError, match=r"part-000000\.parquet is damaged"):
        list(store.batches())


def test_a_store_that_does_not_answer_has_no_damaged_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("fsspec", reason="needs fsspec (pip install fsspec)")
    store = build(SMALL, "memory://rotorwise/unsteady", workers=1, limit=10)
    assert list(store.parts()) == [0]

    def refuse(*_words: Any, **_options: Any) -> None:
        raise TimeoutError("no answer")

    monkeypatch.setattr(store.folder.system, "cat_file", refuse)  # type: ignore[attr-defined]
    with pytest.raises(StoreError, match="cannot be read: TimeoutError"):
        store.parts()


def test_a_part_that_says_much_of_itself_is_read(monkeypatch: pytest.MonkeyPatch, whole: Path) -> None:
    usual = open_store(whole).parts()
    monkeypatch.setattr("rotorwise.datasets.store._TAIL", 16)
    assert open_store(whole).parts() == usual

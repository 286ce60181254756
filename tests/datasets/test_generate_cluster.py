"""The same dataset from a Dask cluster of separate processes, one of which is killed on the way."""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from rotorwise.datasets.errors import InvalidValueError
from rotorwise.datasets.generate import build
from rotorwise.datasets.recipe_file import load_recipe, recipe_from_json

pytest.importorskip("distributed", reason="needs dask (pip install 'dask[distributed]')")
SMALL = Path(__file__).with_name("recipe_small.toml")
_START_S = 90


def content(folder: Path) -> dict[str, bytes]:
    """Return the bytes of every part."""
    return {path.name: path.read_bytes() for path in sorted((folder / "data").iterdir())}


class Cluster:
    """A scheduler and two workers, each a process of its own."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "scheduler.json"
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
        words = ["--scheduler-file", str(self.file)]
        run = [sys.executable, "-m", "distributed.cli.dask_scheduler", *words, "--port", "0", "--host", "127.0.0.1"]
        self.scheduler = subprocess.Popen([*run, "--no-dashboard"], **quiet)
        run = [sys.executable, "-m", "distributed.cli.dask_worker", *words, "--no-nanny", "--nthreads", "1"]
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        self.workers = [subprocess.Popen([*run, "--no-dashboard"], env=environment, **quiet) for _ in range(2)]

    @property
    def address(self) -> str:
        """Address of the scheduler, once it is there."""
        for _ in range(10 * _START_S):
            if self.file.exists() and self.file.stat().st_size:
                return json.loads(self.file.read_text(encoding="utf-8"))["address"]
            time.sleep(0.1)
        raise TimeoutError("the scheduler did not start")

    def wait_for_workers(self) -> None:
        """Return when both workers have joined."""
        from distributed import Client

        with Client(self.address, timeout=_START_S) as client:
            client.wait_for_workers(2, timeout=_START_S)

    def stop(self) -> None:
        """End all processes."""
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    made = Cluster(tmp_path)
    yield made
    made.stop()


@pytest.mark.slow
def test_a_cluster_gives_the_same_dataset_though_a_worker_is_killed(cluster: Cluster, tmp_path: Path) -> None:
    source = json.loads(load_recipe(SMALL).source)
    recipe = recipe_from_json(json.dumps({**source, "draws": 12}, sort_keys=True))
    killed: list[int] = []

    def tell(now: object) -> None:
        done = len(list((tmp_path / "set" / "data").glob("*"))) if (tmp_path / "set" / "data").is_dir() else 0
        if done >= 3 and not killed:
            cluster.workers[0].kill()
            killed.append(done)

    cluster.wait_for_workers()
    build(recipe, tmp_path / "set", cluster=cluster.address, tell=tell)
    assert killed
    assert killed[0] < 12
    assert cluster.workers[0].wait(10) == -9
    assert cluster.workers[1].poll() is None
    build(recipe, tmp_path / "alone", workers=1)
    assert content(tmp_path / "set") == content(tmp_path / "alone")
    assert len(content(tmp_path / "set")) == 12


class _Talker(BaseHTTPRequestHandler):
    """Says something else than a scheduler would."""

    def handle_one_request(self) -> None:
        self.wfile.write(b"HTTP/1.1 400 Bad Request\r\n\r\n" * 4)
        self.close_connection = True


def test_something_else_that_answers_is_no_scheduler(tmp_path: Path) -> None:
    server = ThreadingHTTPServer(("127.0.0.1", 0), _Talker)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"tcp://127.0.0.1:{server.server_port}"
    with pytest.raises(InvalidValueError, match=f"No Dask scheduler answers at {address}"):
        build(SMALL, tmp_path / "set", cluster=address)
    server.shutdown()
    server.server_close()


def test_no_scheduler_is_an_error_that_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from rotorwise.datasets import generate_cluster

    monkeypatch.setattr(generate_cluster, "_CONNECT_S", 1)
    with pytest.raises(InvalidValueError, match=r"No Dask scheduler answers at tcp://127\.0\.0\.1:9"):
        build(SMALL, tmp_path / "set", cluster="tcp://127.0.0.1:9")
    # Nothing is left of the failed client: collected while the next one starts, it would wait for itself.
    from distributed import Client

    assert not [one for one in gc.get_objects() if type(one) is Client]

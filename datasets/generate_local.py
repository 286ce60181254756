"""Parts computed by processes of this computer."""

from __future__ import annotations

import os
import signal
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import active_children, get_context
from typing import Any

from .errors import BuildError
from .generate_part import Part, make_part, warm_up
from .store import Store


def computed_by_processes(
    store: Store, missing: Sequence[int], limit: int | None, *, workers: int, ahead: int
) -> Generator[Part, None, None]:
    """Yield parts as they are finished; the order does not matter, the content of each is its own.

    Parameters
    ----------
    store : Store
    missing : sequence of int
        Numbers of the parts to compute.
    limit : int or None
    workers : int
    ahead : int
        Parts under way or finished for each worker.

    Raises
    ------
    BuildError
        When a process died.
    """
    before = set(active_children())
    workers, source = min(workers, len(missing)), store.recipe.source
    # A forked process would inherit locks of numba and BLAS in any state.
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_begin) as pool:
        waiting: set[Future[Any]] = set()
        left = iter(missing)
        try:
            # One process compiles what is not yet compiled; the others find it on the disk.
            with _interrupts_held():
                warming = pool.submit(warm_up, source)
            waiting.add(warming)
            _check_begun(warming)
            waiting.clear()
            while True:
                for number in left:
                    with _interrupts_held():
                        waiting.add(pool.submit(make_part, source, number, limit=limit))
                    if len(waiting) >= ahead * workers:
                        break
                if not waiting:
                    return
                done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
                for future in done:
                    yield future.result()
        except (BrokenProcessPool, MemoryError):
            raise BuildError(
                f"A process that computed parts of {store.folder.name} was killed, most likely for lack of memory. "
                f"What has been built is whole: build again, with fewer than {workers} workers (--workers)."
            ) from None
        finally:
            if waiting:
                # Nobody wants their parts any more: a computed part would only delay the end.
                pool.shutdown(wait=False, cancel_futures=True)
                for process in set(active_children()) - before:
                    process.terminate()


def _check_begun(warming: Future[None]) -> None:
    try:
        warming.result()
    except BrokenProcessPool:
        raise BuildError(
            "The first process ended before it had begun. A script of your own must call build(...) below "
            'if __name__ == "__main__": as processes read the script again; or give workers=1.'
        ) from None


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Keep Ctrl-C waiting while a process is started, and from that process: it cannot ignore it before `_begin`."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin() -> None:
    """Make a worker ready: one thread, nothing on interruption, an end when its parent ends."""
    import threading

    import scipy.linalg
    from threadpoolctl import threadpool_limits

    # The other cores have parts of their own. Each BLAS must be loaded to be found.
    del scipy
    threadpool_limits(1)
    # Ctrl-C reaches the whole group; the parent says what happens.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process when its parent has ended: a killed parent cannot say so."""
    from multiprocessing import parent_process

    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)

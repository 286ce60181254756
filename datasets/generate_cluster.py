"""Parts computed by the workers of a Dask cluster. Dask gives the work of a worker that dies to another one."""

from __future__ import annotations

import gc
from collections.abc import Generator, Sequence
from typing import Any

from .errors import BuildError, InvalidValueError
from .generate_part import Part, make_part
from .store import DATA, Store
from .store_folder import folder_of

#: A part fails for good when so many workers died while they had it.
RETRIES = 5
_CONNECT_S = 15
_AHEAD = 2


def computed_on_cluster(
    store: Store, missing: Sequence[int], limit: int | None, *, address: str
) -> Generator[Part, None, None]:
    """Yield parts as workers finish them.

    Parameters
    ----------
    store : Store
    missing : sequence of int
        Numbers of the parts to compute.
    limit : int or None
    address : str
        Of the Dask scheduler, such as ``tcp://host:8786``.

    Raises
    ------
    InvalidValueError
        When Dask is not installed or the scheduler does not answer.
    BuildError
        When a part could not be computed.
    """
    client = _client(address)
    try:
        yield from _computed(client, store, missing, limit)
    finally:
        client.close()


def _computed(client: Any, store: Store, missing: Sequence[int], limit: int | None) -> Generator[Part, None, None]:
    from distributed import as_completed

    target = store.folder.name if store.folder.is_shared else None
    left = iter(missing)

    def submit() -> list[Any]:
        number = next(left, None)
        if number is None:
            return []
        words = store.recipe.source, number, limit, target
        return [client.submit(make_and_write, *words, pure=False, retries=RETRIES, key=f"part-{number}-{id(store)}")]

    threads = sum(client.nthreads().values()) or 1
    running = as_completed([one for _ in range(_AHEAD * threads) for one in submit()])
    for future in running:
        try:
            part = future.result()
        except Exception as problem:
            raise BuildError(
                f"The cluster could not compute {future.key}: {type(problem).__name__}: {problem}. What has been built "
                "is whole: build again. The workers need the same version of rotorwise."
            ) from problem
        for one in submit():
            running.add(one)
        yield part


def make_and_write(source: str, number: int, limit: int | None, target: str | None) -> Part:
    """Compute a part; write it where this worker reaches the store, else return its content."""
    part = make_part(source, number, limit=limit)
    if target is None:
        return part
    folder_of(target).write(f"{DATA}/{part.name}", part.content)
    return Part(part.number, part.name, part.facts, b"")


def _client(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise InvalidValueError(
            f'--cluster {address} needs Dask, which is not installed. Run: pip install "rotorwise[cluster]"'
        ) from None
    try:
        return Client(address, timeout=_CONNECT_S)
    except Exception as problem:
        # What answers may be no scheduler; Dask then fails in many ways.
        said = str(problem)
    # A failed client closes itself when it is collected; while the next one starts, that would wait for ever.
    gc.collect()
    raise InvalidValueError(
        f"No Dask scheduler answers at {address}: {said}. Start one (dask scheduler) or correct the address."
    )

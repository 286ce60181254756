"""From a dataset to a table: one row a signal, features and labels; what classifiers and estimators learn from."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from ...datasets.store import Store, open_store
from ...simulators.errors import InvalidValueError, RotorwiseError
from .fault_names import fault_of
from .machine_noise import MachineNoise, with_machine_noise
from .store_rows import RowGroup, channels_of, recording_of, row_groups, rows

KINDS = ("relative", "levels", "absolute", "rules")
#: What every row says of itself besides the severities and the machine's and faults' values.
LABELS = ("signal", "machine", "group", "split", "case", "fault", "record", "speed_rpm", "load", "rate_hz", "label")
_VALUES = ("severity.", "effect.", "machine.")
#: Pieces under way for each process.
_AHEAD = 2
_TOO_SHORT = "not turning or no speed found"

Tell = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class FeatureTable:
    """Features of many recordings with what is known of each.

    Attributes
    ----------
    values : numpy.ndarray, shape (rows, features)
        NaN where a recording cannot say.
    names : tuple of str
        Of the features; absolute ones (SI units) begin with ``absolute.``.
    labels : numpy.ndarray of str, shape (rows,)
        Fault as the diagnosis calls it, or "healthy".
    columns : dict of str to numpy.ndarray
        ``signal``, ``machine``, ``group`` (machine draw: split by it), ``split``, ``case``, ``speed_rpm``, ``load``,
        ``rate_hz``, ``severity.*``, ``effect.*``, ``machine.*``; NaN where a row has none.
    left_out : tuple of str
        Why rows are missing, one reason a row.
    """

    values: np.ndarray
    names: tuple[str, ...]
    labels: np.ndarray
    columns: Mapping[str, np.ndarray]
    left_out: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.labels)

    @property
    def groups(self) -> np.ndarray:
        """Machine draw of each row: two rows of one group never stand on both sides of a split."""
        return self.columns["group"]

    def where(self, mask: np.ndarray) -> FeatureTable:
        """Return the rows that a mask or an index chooses."""
        columns = {name: column[mask] for name, column in self.columns.items()}
        return replace(self, values=self.values[mask], labels=self.labels[mask], columns=columns)

    def only(self, names: Sequence[str]) -> FeatureTable:
        """Return the table with these features only, in this order.

        Raises
        ------
        InvalidValueError
            For a feature that the table does not have.
        """
        missing = [name for name in names if name not in self.names]
        if missing:
            raise InvalidValueError(f"No feature {missing[0]!r} in the table; allowed: {', '.join(self.names)}.")
        index = [self.names.index(name) for name in names]
        return replace(self, values=self.values[:, index], names=tuple(names))


def feature_table(
    store: Store | str | Path,
    *,
    kinds: Sequence[str] = ("relative", "levels", "absolute"),
    workers: int = 1,
    limit: int | None = None,
    hint_error: float = 0.0,
    tacho: bool = True,
    noise: MachineNoise | None = None,
    tell: Tell = lambda _done, _all: None,
) -> FeatureTable:
    """Return the features of every signal of a dataset.

    Memory holds one row group (16 MB of signals) a process, however large the dataset. More than one worker means new
    processes, which read the script that calls this again: call it below ``if __name__ == "__main__":``.

    Parameters
    ----------
    store : Store, str or Path
    kinds : sequence of str
        ``"relative"``: independent of gain, rate and record (`relative_features`); ``"levels"``: what is compared with
        a baseline (`levels`); ``"absolute"``: in SI units (`absolute_features`), names with ``absolute.`` before them;
        ``"rules"``: what the evidence rules state without a baseline, ``rules.FAULT``.
    workers : int
        Processes.
    limit : int, optional
        Only the first so many row groups.
    hint_error : float
        Relative error of the nominal speed, drawn evenly within plus and minus it.
    tacho : bool
        False hides the tacho: most measured files have none.
    noise : MachineNoise, optional
        Added to the simulated signals; see `machine_noise`.
    tell : callable
        Called with row groups done and in all.

    Raises
    ------
    InvalidValueError
        For an option that is not allowed, or a dataset without a usable row.
    StoreError
        When there is no dataset.
    """
    for name in kinds:
        if name not in KINDS:
            raise InvalidValueError(f"Kind of features {name!r}; allowed: {', '.join(KINDS)}. Correct it.")
    if workers < 1 or not 0.0 <= hint_error < 0.08:
        raise InvalidValueError(f"workers = {workers}, hint_error = {hint_error}; allowed: 1 or more, 0 to 0.08.")
    store = store if isinstance(store, Store) else open_store(store)
    pieces = row_groups(store)[:limit]
    task = _Task(store.folder.name, tuple(kinds), hint_error, tacho, noise)
    found: dict[int, list[_Row]] = {}
    for number, block in _computed(task, store, pieces, workers):
        found[number] = block
        tell(len(found), len(pieces))
    return table_of([row for number in sorted(found) for row in found[number]], where=store.folder.name)


@dataclass(frozen=True)
class _Task:
    location: str
    kinds: tuple[str, ...]
    hint_error: float
    tacho: bool
    noise: MachineNoise | None


@dataclass(frozen=True)
class _Row:
    """One signal: features by name (None where it was refused, for a reason) and labels by name."""

    features: dict[str, float] | None
    about: dict[str, Any]
    effects: tuple[str, ...]
    reason: str = ""


def table_of(found: Sequence[_Row], *, where: str) -> FeatureTable:
    """Return the rows as one table; features and columns that a row lacks are NaN."""
    kept = [row for row in found if row.features is not None]
    if not kept:
        reasons = "; ".join(dict.fromkeys(row.reason for row in found)) or "it is empty"
        raise InvalidValueError(f"{where} has no usable signal ({reasons}). Build it first, or look at its card.")
    names = list(dict.fromkeys(name for row in kept for name in row.features or {}))
    keys = list(dict.fromkeys(name for row in kept for name in row.about))
    values = np.array([[(row.features or {}).get(name, np.nan) for name in names] for row in kept], dtype=float)
    return FeatureTable(
        values,
        tuple(names),
        np.array([fault_of(row.effects) for row in kept]),
        {key: _column([row.about.get(key) for row in kept]) for key in keys},
        tuple(row.reason for row in found if row.features is None),
    )


def _column(values: Sequence[Any]) -> np.ndarray:
    if any(isinstance(value, str) for value in values):
        return np.array(["" if value is None else value for value in values])
    return np.array([np.nan if value is None else value for value in values])


def _computed(task: _Task, store: Store, pieces: Sequence[RowGroup], workers: int) -> Iterator[tuple[int, list[_Row]]]:
    if workers == 1 or len(pieces) < 2:
        for number, piece in enumerate(pieces):
            yield number, _block(task, piece, store)
        return
    with ProcessPoolExecutor(min(workers, len(pieces)), mp_context=get_context("spawn"), initializer=_begin) as pool:
        waiting: dict[Future[list[_Row]], int] = {}
        left = iter(enumerate(pieces))
        try:
            while True:
                for number, piece in left:
                    waiting[pool.submit(_block, task, piece)] = number
                    if len(waiting) >= _AHEAD * workers:
                        break
                if not waiting:
                    return
                for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                    yield waiting.pop(future), future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _begin() -> None:
    """Let each process use one core: the others have pieces of their own."""
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)


def _block(task: _Task, piece: RowGroup, store: Store | None = None) -> list[_Row]:
    store = open_store(task.location) if store is None else store
    channels = channels_of(store.recipe)
    return [_row(task, row, channels) for row in rows(store, piece)]


def _row(task: _Task, row: Mapping[str, Any], channels: Mapping[str, Mapping[str, str]]) -> _Row:
    about = {name: row[name] for name in LABELS}
    about |= {name: value for name, value in row.items() if name.startswith(_VALUES) and name != "machine_toml"}
    effects = tuple(row["effects"])
    try:
        recording = recording_of(row, channels, hint_error=task.hint_error, tacho=task.tacho)
        if task.noise is not None:
            recording = with_machine_noise(recording, row, task.noise)
        features = _features(recording, task.kinds)
    except RotorwiseError as problem:
        return _Row(None, about, effects, str(problem))
    return _Row(features, about, effects, "" if features is not None else _TOO_SHORT)


def _features(recording: Any, kinds: Sequence[str]) -> dict[str, float] | None:
    from ..evidence import judge
    from ..observe import observe
    from ..result import FAULTS
    from .absolute_features import absolute_features
    from .relative_features import levels, relative_features

    now = observe(recording)
    if now.speed is None or not now.turning:
        return None
    values: dict[str, float] = {}
    if "relative" in kinds:
        values |= relative_features(now)
    if "levels" in kinds:
        values |= levels(now)
    if "absolute" in kinds:
        values |= {f"absolute.{name}": value for name, value in absolute_features(now).items()}
    if "rules" in kinds:
        stated = {one.fault: one.probability for one in judge(now)}
        values |= {f"rules.{fault}": stated.get(fault, 0.0) for fault in FAULTS}
    return values

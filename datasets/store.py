"""The store of a dataset: what it is, which parts are whole, what they hold.

    dataset.json               what it is: recipe, fingerprint, version; written first
    data/part-000000.parquet   the signals; each part is whole or absent
    card.md, manifest.json     for people and programs; made anew from the parts at the end of a build

All that is known of the progress is which parts are there: nothing can be out of step with them.
"""

from __future__ import annotations

import io
import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from .errors import InvalidValueError
from .recipe import CONTENT, Recipe
from .recipe_file import recipe_from_json
from .recipe_parts import part_name
from .store_folder import Folder, StoreError, folder_of

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as pq

Found = TypeVar("Found")
FORMAT = 1
IDENTITY, DATA, MANIFEST, CARD = "dataset.json", "data", "manifest.json", "card.md"
#: Facts of parts are read by so many threads: on an object store each is a wait.
_READERS = 8
#: Bytes at the end of a part that hold what it says of itself, as a rule and at most.
_TAIL, _LONGEST_TAIL = 2**17, 2**26


@dataclass(frozen=True)
class Store:
    """A dataset in a folder or at another location.

    Parameters
    ----------
    folder : Folder
    recipe : Recipe
    version : str
        Of rotorwise, when the dataset was begun.
    """

    folder: Folder
    recipe: Recipe
    version: str

    def parts(self) -> dict[int, dict[str, Any]]:
        """Return the facts of every readable part of this dataset, by number, as its file's metadata say them."""
        numbers = {part_name(number): number for number in _numbers(self.folder.sizes(DATA))}
        with ThreadPoolExecutor(_READERS) as pool:
            facts = pool.map(self._facts, numbers)
            found = dict(zip(numbers.values(), facts, strict=True))
        return {number: found[number] for number in sorted(found) if found[number] is not None}  # type: ignore[misc]

    def _facts(self, name: str) -> dict[str, Any] | None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        from .generate_table import KEY

        # Read here and understood there: a store that does not answer is no damaged part.
        tail = self.folder.end(f"{DATA}/{name}", _TAIL)
        length = int.from_bytes(tail[-8:-4], "little") + 8
        if len(tail) < length <= _LONGEST_TAIL:
            tail = self.folder.end(f"{DATA}/{name}", length)
        try:
            said = pq.read_schema(io.BytesIO(tail)).metadata
            facts = json.loads(said[KEY])
        except (pa.ArrowException, OSError, KeyError, TypeError, ValueError):
            return None
        ours = facts.get("fingerprint") == self.recipe.fingerprint and part_name(facts["part"]) == name
        return facts if ours else None

    def write_part(self, name: str, content: bytes) -> None:
        """Write a part."""
        self.folder.write(f"{DATA}/{name}", content)

    def numbers(self) -> list[int]:
        """Return the numbers of all parts that are there.

        Raises
        ------
        StoreError
            When one of them is damaged: its rows would be missing without a word.
        """
        whole = list(self.parts())
        for number in _numbers(self.folder.sizes(DATA)):
            if number not in whole:
                raise self._damaged(number)
        return whole

    def batches(self, columns: Iterable[str] | None = None) -> Iterator[pa.RecordBatch]:
        """Yield the rows, one row group after the other, so that memory never holds more than one.

        Parameters
        ----------
        columns : iterable of str, optional
            Only these.

        Raises
        ------
        StoreError
            When a part is damaged.
        """
        wanted = None if columns is None else list(columns)
        for number in self.numbers():
            for group in range(self.groups(number)):
                yield from self.group(number, group, wanted).to_batches()

    def groups(self, number: int) -> int:
        """Return how many row groups a part has."""
        return self._of_part(number, lambda file: file.num_row_groups)

    def group(self, number: int, group: int, columns: Sequence[str] | None = None) -> pa.Table:
        """Return a row group of a part.

        Raises
        ------
        StoreError
            When the part is damaged.
        """
        return self._of_part(number, lambda file: file.read_row_group(group, columns=columns))

    def _of_part(self, number: int, asked: Callable[[pq.ParquetFile], Found]) -> Found:
        import pyarrow as pa
        import pyarrow.parquet as pq

        with self.folder.open(f"{DATA}/{part_name(number)}") as file:
            try:
                return asked(pq.ParquetFile(file))
            except (pa.ArrowException, OSError) as problem:
                raise self._damaged(number) from problem

    def _damaged(self, number: int) -> StoreError:
        return StoreError(
            f"{self.folder.name}/{DATA}/{part_name(number)} is damaged, or no part of this dataset. Remove it and "
            "build again: what is missing is made anew."
        )


def _numbers(names: Iterable[str]) -> list[int]:
    found = [(name.removeprefix("part-").removesuffix(".parquet"), name) for name in names]
    return sorted(int(text) for text, name in found if text.isdigit() and part_name(int(text)) == name)


def open_store(location: str | Path) -> Store:
    """Return the dataset at a location.

    Raises
    ------
    StoreError
        When there is none, or this version cannot read it.
    """
    folder = folder_of(location)
    said = folder.read(IDENTITY)
    if said is None:
        raise StoreError(f"{folder.name} holds no dataset. Make one: rotorwise dataset build RECIPE -o {folder.name}")
    return _store(folder, said)


def _store(folder: Folder, said: bytes) -> Store:
    try:
        given = json.loads(said)
        if given["format"] != FORMAT or given["content"] != CONTENT:
            raise StoreError(
                f"{folder.name} holds a dataset of rotorwise {given['version']}, in another format. Use that version, "
                "or another folder."
            )
        recipe = recipe_from_json(json.dumps(given["recipe"], sort_keys=True))
        store = Store(folder, recipe, str(given["version"]))
        fingerprint = str(given["fingerprint"])
    except (ValueError, KeyError, TypeError) as problem:
        if isinstance(problem, InvalidValueError):
            raise StoreError(f"{folder.name}: its recipe is not understood by this version: {problem}") from None
        raise StoreError(f"{folder.name}/{IDENTITY} is damaged: {problem!r}. Restore it from a copy.") from None
    if recipe.fingerprint != fingerprint:
        raise StoreError(
            f"{folder.name}: this version of rotorwise makes other machines from its recipe than {store.version} did. "
            "Read its data/*.parquet with any program; go on building with that version."
        )
    return store


def check_free(folder: Folder) -> None:
    """Raise StoreError where a dataset would come between files of somebody else."""
    if folder.read(IDENTITY) is None and not folder.is_empty():
        raise StoreError(f"{folder.name} holds files, but no dataset. Choose another folder, or an empty one.")


def create_store(folder: Folder, recipe: Recipe) -> Store:
    """Return the dataset in a folder, begun there if the folder is empty or holds no part yet.

    Raises
    ------
    StoreError
        When something else is there, or a dataset of another recipe or version.
    """
    from importlib.metadata import version

    here = version("rotorwise")
    said = folder.read(IDENTITY)
    if said is None:
        check_free(folder)
        return _begun(folder, recipe, here)
    store = _store(folder, said)
    is_same = store.recipe.fingerprint == recipe.fingerprint and store.version == here
    if not is_same and not folder.sizes(DATA):
        # A build that ended before its first part: nothing would be lost.
        return _begun(folder, recipe, here)
    if store.recipe.fingerprint != recipe.fingerprint:
        raise StoreError(
            f"{folder.name} holds dataset {store.recipe.name!r} of another recipe (fingerprint "
            f"{store.recipe.fingerprint}, yours {recipe.fingerprint}). Nothing was changed. Choose another folder, or "
            "take back the change of the recipe."
        )
    if store.version != here:
        raise StoreError(
            f"{folder.name} was begun with rotorwise {store.version}, this is {here}: its signals may differ. Nothing "
            "was changed. Go on with that version, or choose another folder."
        )
    return store


def _begun(folder: Folder, recipe: Recipe, version: str) -> Store:
    given = {
        "format": FORMAT,
        "content": CONTENT,
        "name": recipe.name,
        "fingerprint": recipe.fingerprint,
        "seed": recipe.seed,
        "version": version,
        "recipe": json.loads(recipe.source),
    }
    folder.write(IDENTITY, (json.dumps(given, indent=2) + "\n").encode())
    return Store(folder, recipe, version)


def totals(parts: Iterable[dict[str, Any]]) -> dict[str, Any]:
    """Return what the facts of parts add up to: signals, rows, counts by machine, case and split, refused draws."""
    counts: Counter[tuple[str, str, str]] = Counter()
    versions: dict[str, set[str]] = {}
    found: dict[str, Any] = {"parts": 0, "signals": 0, "rows": 0, "refused": []}
    for facts in parts:
        found["parts"] += 1
        found["signals"] += facts["signals"]
        found["rows"] += facts["rows"]
        found["refused"] += facts["refused"]
        for machine, case, split, count in facts["counts"]:
            counts[machine, case, split] += count
        for package, text in facts["versions"].items():
            versions.setdefault(package, set()).add(text)
    found["counts"] = [[*kind, count] for kind, count in sorted(counts.items())]
    found["versions"] = {package: sorted(texts) for package, texts in versions.items()}
    return found

"""How the signals of a recipe are divided into parts: consecutive numbers, computed together, written to one file."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

from .recipe import MachineRecipe, Recipe

#: Runs side by side are four times cheaper; more than this bring nothing.
MOST_RUNS = 64
#: Of the motion at all probes of a part, in bytes; a worker needs about three times as much.
MOST_BYTES = 280_000_000
#: Small datasets are divided into this many parts all the same, so that every core has work.
FEWEST_PARTS = 16


@dataclass(frozen=True)
class Parts:
    """The parts of a recipe.

    Parameters
    ----------
    recipe : Recipe
    limit : int or None
        Only the first so many signals; the last part is then a shorter one.
    """

    recipe: Recipe
    limit: int | None = None

    @property
    def signals(self) -> int:
        """Number of signals in all parts."""
        return self.recipe.signals if self.limit is None else min(self.limit, self.recipe.signals)

    @cached_property
    def rounds(self) -> int:
        """How many machine draws of every kind make one part; 0 where one of them makes several parts."""
        fitting = min(_fitting(one) for one in self.recipe.machines) // self.recipe.per_round
        return min(fitting, max(1, self.recipe.draws // FEWEST_PARTS))

    @cached_property
    def starts(self) -> list[int]:
        """First signal of each part within one machine draw of every kind, and the end of the last."""
        sizes = []
        for one in self.recipe.machines:
            runs = one.per_draw // one.records
            count = math.ceil(runs / (_fitting(one) // one.records))
            sizes += [one.records * (runs * (i + 1) // count - runs * i // count) for i in range(count)]
        return list(accumulate(sizes, initial=0))

    @property
    def count(self) -> int:
        """Number of parts."""
        if not self.signals:
            return 0
        last = self.signals - 1
        if self.rounds:
            return last // (self.rounds * self.recipe.per_round) + 1
        rounds, rest = divmod(last, self.recipe.per_round)
        starts = self.starts
        return rounds * (len(starts) - 1) + sum(start <= rest for start in starts[:-1])

    def numbers(self, part: int) -> range:
        """Return the numbers of the signals in one part."""
        if self.rounds:
            size = self.rounds * self.recipe.per_round
            first, stop = part * size, (part + 1) * size
        else:
            starts = self.starts
            draw, own = divmod(part, len(starts) - 1)
            first, stop = (draw * self.recipe.per_round + starts[own + i] for i in (0, 1))
        return range(first, min(stop, self.signals))


def _fitting(one: MachineRecipe) -> int:
    """Return how many signals of a machine fit into one part: whole runs."""
    probes = len(one.machine.bare_assembly().probes)
    return one.records * max(1, min(MOST_RUNS, MOST_BYTES // (8 * probes * one.samples * one.records)))


def part_name(part: int) -> str:
    """Return the file name of a part.

    Examples
    --------
    >>> part_name(12)
    'part-000012.parquet'
    """
    return f"part-{part:06d}.parquet"

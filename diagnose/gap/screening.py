"""What every candidate could do, in the few conditions that show most: which are worth following."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .evidence import Comparison
from .hypotheses import Candidate
from .screen import Atom, Start, starts

#: Parts and variants of one effect that are followed.
PLACES = 2
#: Effects that were put aside and are looked at beside another one, and what each must be able to explain of half a
#: squared residual.
TAKEN_UP, LEAST_SHARE = 2, 10.0
#: Hypotheses that are simulated in time and further behind the best in the first look than this, and than this share of
#: what the best explains, are not followed: a fifth beside the right size leaves such a share.
FAR_BEHIND, BEHIND_ON_GRID = 300.0, 0.05
#: Nor finished, where after the first steps they leave so many times what the best leaves, and as much again.
TIMES_WORSE = 10.0


@dataclass(frozen=True, eq=False)
class Screening:
    """The conditions in which candidates are screened: those that show most.

    Attributes
    ----------
    chosen : tuple of int
        Numbers of the problem's conditions.
    compared : Comparison
        Without any effect, in these conditions.
    atoms : mapping of Candidate to sequence of Atom
        Responses in these conditions.
    further : callable, optional
        Returns such a mapping on a finer grid; none where the grid is as fine as it gets.
    aside : mapping of Candidate to callable
        Those that explain least of all lines, each with what returns its responses.
    explains : callable, optional
        Returns how much of a comparison's squared residual one of them can explain at most.
    """

    chosen: tuple[int, ...]
    compared: Comparison
    atoms: Mapping[Candidate, Sequence[Atom]]
    further: Callable[[], Mapping[Candidate, Sequence[Atom]]] | None = field(default=None, repr=False)
    aside: Mapping[Candidate, Callable[[], Sequence[Atom]]] = field(default_factory=dict, repr=False)
    explains: Callable[[Candidate, Comparison], float] | None = field(default=None, repr=False)

    def taking_up(self, left: Comparison) -> Screening:
        """Return the screening with those put aside that can explain most of what something else has left.

        Beside a strong effect a weak one explains next to nothing of all lines, and may be all that is left.
        """
        if self.explains is None or not self.aside:
            return self
        share = {one: self.explains(one, left) for one in self.aside}
        best = sorted((one for one in share if share[one] > 2 * LEAST_SHARE), key=lambda one: -share[one])[:TAKEN_UP]
        return replace(self, atoms={**self.atoms, **{one: self.aside[one]() for one in best}})

    def about(self, compared: Comparison) -> Screening:
        """Return the screening against another comparison of the problem's conditions; the responses stay."""
        return replace(self, compared=compared.select(self.chosen))

    def finer(self) -> Screening:
        """Return the screening on the finer grid, with what the coarse one has seen as well."""
        if self.further is None:
            return self
        atoms = {}
        for one, own in self.further().items():
            every = {(atom.position.tobytes(), atom.moving): atom for atom in (*self.atoms.get(one, ()), *own)}
            atoms[one] = tuple(every.values())
        return replace(self, atoms=atoms, further=None)

    def best(self, response: np.ndarray | None = None) -> list[list[Start]]:
        """Return each candidate's starts, the best candidate first.

        ``response`` (problem's conditions, probes, orders), if any, is taken off first.
        """
        if response is None:
            return self.against(self.compared)
        left = self.compared.residual - self.compared.whitened(response[list(self.chosen)])
        return self.against(replace(self.compared, residual=left))

    def against(self, compared: Comparison) -> list[list[Start]]:
        """Return each candidate's starts against another comparison of these conditions, the best candidate first."""
        found = [starts(one, own, compared) for one, own in self.atoms.items() if own]
        return sorted([options for options in found if options], key=lambda options: -options[0].score)


def telling_conditions(compared: Comparison, count: int) -> tuple[int, ...]:
    """Return the numbers of the conditions with the largest residual, in order."""
    residual = compared.factor @ compared.residual
    scale = np.sqrt(np.diag(compared.covariance))
    condition = np.concatenate([np.nonzero(part)[0] for part in compared.lines.parts])
    power = np.bincount(condition, weights=(residual / scale) ** 2, minlength=compared.seen.shape[0])
    return tuple(sorted(int(i) for i in np.argsort(power)[::-1][:count]))


def few_of_each(screened: list[list[Start]]) -> list[list[Start]]:
    """Return the list with at most `PLACES` parts or variants of one effect.

    The best part with all strengths of an effect together is kept beside them: its first look, on a coarse grid of many
    strengths, says least.
    """
    counts: dict[str, int] = {}
    most: dict[str, int] = {}
    for options in screened:
        one = options[0].candidate
        most[one.name] = max(most.get(one.name, 0), len(one.strengths))
    kept, whole = [], set()
    for options in screened:
        one = options[0].candidate
        counts[one.name] = counts.get(one.name, 0) + 1
        together = 1 < most[one.name] == len(one.strengths) and one.name not in whole
        if together:
            whole.add(one.name)
        if together or counts[one.name] <= PLACES:
            kept.append(options)
    return kept

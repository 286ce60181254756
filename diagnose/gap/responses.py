"""What effects add to a machine's lines, and how that changes with their values."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from ...simulators.machine import Machine
from .hypotheses import Candidate
from .predict import Predictor, UnpredictableError

#: Steps of the slopes in standard coordinates: of periodic motions, and of motions simulated in time.
STEP, STEP_IN_TIME = 2e-3, 0.05


class Responses:
    """What effects add to a machine's lines, by the position of their coordinates."""

    def __init__(self, chosen: Sequence[Candidate], machine: Machine, predictor: Predictor) -> None:
        self.chosen, self._machine, self._predictor = tuple(chosen), machine, predictor
        self._base = predictor.amplitudes(machine)
        self.orders = predictor.phase_orders

    def __call__(self, position: np.ndarray) -> np.ndarray:
        """Return the response, shape (conditions, probes, orders)."""
        return self._predictor.amplitudes(self.machine(position)) - self._base

    def machine(self, position: np.ndarray) -> Machine:
        """Return the machine with the effects."""
        return with_candidates(self._machine, self.chosen, position)

    def prepare(
        self,
        positions: Sequence[np.ndarray],
        *,
        most_in_time: int | None = None,
        near: np.ndarray | None = None,
        lasting: bool = False,
    ) -> list[bool]:
        """Compute several responses, side by side, sought from that at ``near``; return which: `Predictor.prepare`."""
        machines = [self.machine(position) for position in positions]
        beside = None if near is None else self.machine(near)
        return self._predictor.prepare(machines, most_in_time=most_in_time, near=beside, lasting=lasting)

    def repeats(self, position: np.ndarray) -> bool:
        """Return whether the motion with the effects repeats with the shaft."""
        return self._predictor.repeats(self.machine(position))

    def steps(self, position: np.ndarray) -> bool:
        """Return whether the response there, which is known, costs a simulation in time."""
        return self._predictor.steps(self.machine(position))

    def own(self, position: np.ndarray, added: np.ndarray) -> list[np.ndarray]:
        """Return what each effect adds beside the others, at a position where together they add ``added``.

        Where the others alone have no motion that can be computed, all of it.
        """
        if len(self.chosen) < 2:
            return [added] * len(self.chosen)
        edges = np.cumsum([0, *(len(candidate.coordinates) for candidate in self.chosen)])
        rest = []
        for number, (start, stop) in enumerate(itertools.pairwise(edges.tolist())):
            others = [*self.chosen[:number], *self.chosen[number + 1 :]]
            rest.append(with_candidates(self._machine, others, np.delete(position, slice(start, stop))))
        self._predictor.prepare(rest, near=self.machine(position))
        found = []
        for machine in rest:
            try:
                found.append(added - (self._predictor.amplitudes(machine) - self._base))
            except UnpredictableError:
                found.append(added)
        return found

    def slopes(self, position: np.ndarray, added: np.ndarray, alive: np.ndarray) -> np.ndarray:
        """Return the derivatives in the coordinates at a position where the response is ``added``.

        Only in the coordinates that are ``alive`` (coordinates,); the others are taken as 0, and so are those in angles
        that choose one part of several.
        """
        step = STEP if self.repeats(position) else STEP_IN_TIME
        choose = [one.parameter.chooses for candidate in self.chosen for one in candidate.coordinates]
        wanted = np.flatnonzero(alive & ~np.array(choose, dtype=bool))
        moved = {int(i): position + step * np.eye(position.size)[i] for i in wanted}
        self.prepare(list(moved.values()), near=position, lasting=True)
        found = np.zeros((position.size, *added.shape), dtype=complex)
        for i, one in moved.items():
            found[i] = (self(one) - added) / step
        return found


def with_candidates(machine: Machine, chosen: Sequence[Candidate], position: np.ndarray) -> Machine:
    """Return the machine with the candidates' effects at a position of their joint coordinates."""
    start = 0
    for candidate in chosen:
        stop = start + len(candidate.coordinates)
        machine = candidate.on(machine, position[start:stop])
        start = stop
    return machine

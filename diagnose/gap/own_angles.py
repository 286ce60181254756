"""Effects of many strengths, each with an angle of its own: those that the lines ask for, in closed form.

What they make adds up, and a strength with its angle is a combination of two responses, a quarter of its period apart.
So all are solved for together, and one that explains next to nothing beside the others is left out: a surface need not
have every harmonic, nor a misaligned coupling every force.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .evidence import Comparison, Widened, law_columns, log_density
from .first_look import moved_to
from .hypotheses import ADDING_UP, Candidate

if TYPE_CHECKING:
    from .screen import Atom

#: Half a squared residual that a strength and its angle have to explain beside the others.
LEAST_GAIN = 6.0
#: Share of its power below which a combination of responses is rounding, so that no size of it is wanted.
ROUNDING = 1e-9
#: Share of what a strength makes beyond which it makes one order.
MOSTLY = 0.5
#: Coordinate of a strength that is small, not nothing.
WEAK = -3.0


@dataclass(frozen=True, eq=False)
class Pair:
    """Responses of one strength at two angles, a quarter of the angle's period apart."""

    strength: int
    angle: int
    position: np.ndarray
    responses: tuple[np.ndarray, np.ndarray]


def have_own_angles(candidate: Candidate) -> bool:
    """Return whether a candidate has several strengths that add up, each with an angle of its own, and nothing else."""
    strengths = candidate.strength_names
    angles = {c.parameter.only_with for c in candidate.coordinates if c.is_angle}
    alone = len(candidate.coordinates) == 2 * len(strengths)
    return candidate.effect.STAGE in ADDING_UP and len(strengths) > 1 and strengths == angles and alone


def quarter_turns(
    candidate: Candidate, centre: np.ndarray, angles: Sequence[int], *, weakly: Sequence[int] = ()
) -> list[np.ndarray]:
    """Return a position, and that a quarter of its period further on for each of some angles.

    The strengths in ``weakly`` are far below the middle of their priors: what they make is not in proportion to them,
    as where the phase of a probe that they move is that of all others, but for small ones it is.
    """
    centre = moved_to(centre, weakly, [WEAK] * len(weakly))
    return [centre, *(moved_to(centre, [i], [centre[i] + quarter_of(candidate, i)]) for i in angles)]


def at_own_angles(
    candidate: Candidate, atoms: Sequence[Atom], compared: Comparison
) -> tuple[Candidate, np.ndarray, np.ndarray] | None:
    """Return the candidate with the strengths that the lines ask for, where they explain most, and the response there.

    None where they ask for fewer than two, which is a candidate by itself.

    Parameters
    ----------
    candidate : Candidate
        That `have_own_angles`.
    atoms : sequence of Atom
        Of each strength alone, at the positions that `quarter_turns` gives, or at one where its angle only turns it.
    compared : Comparison
        Its residual may be what something else has left.
    """
    pairs = _pairs(candidate, atoms, compared.lines.phase_orders)
    if len(pairs) < 2:
        return None
    every = np.array([one for pair in pairs for one in pair.responses])
    white = np.array([compared.whitened(one) for one in every])
    alone = [not candidate.coordinates[pair.strength].parameter.accompanies for pair in pairs]
    plain = Solution(white @ white.T, white @ compared.residual)
    chosen = asked_for(plain, alone)
    found = _Solved.of(chosen, plain, every, white, compared, candidate) if len(chosen) > 1 else None
    while found is not None and len(found.chosen) > 1:
        # What noise alone asks for may be no more than an error of the law, which is that of all of them together.
        fewer = found.widened.without_least(found.chosen)
        if not any(alone[i] for i in fewer):
            break
        less = _Solved.of(fewer, plain, every, white, compared, candidate)
        if less.density < found.density - LEAST_GAIN:
            break
        found = less
    if found is None or len(found.chosen) < 2:
        return None
    places: dict[str, float] = {}
    for pair, (along, across) in zip([pairs[i] for i in found.chosen], found.sizes.reshape(-1, 2), strict=True):
        places |= place_of(candidate, pair, float(along), float(across))
    few = candidate.with_only(frozenset(candidate.coordinates[pairs[i].strength].parameter.name for i in found.chosen))
    return few, np.array([places[one.parameter.name] for one in few.coordinates]), found.response


def that_make(
    order: int, candidate: Candidate, position: np.ndarray, slopes: np.ndarray
) -> tuple[Candidate, np.ndarray]:
    """Return the candidate with the strengths that mostly make one order, and its position; all where none does.

    Parameters
    ----------
    order : int
        Its number.
    candidate : Candidate
        That `have_own_angles`.
    position : ndarray (coordinates,)
    slopes : ndarray (coordinates, conditions, probes, orders), complex
        Of a strength, in proportion to what it makes.
    """
    names, power = [one.parameter.name for one in candidate.coordinates], (np.abs(slopes) ** 2).sum(axis=(1, 2))
    kept = frozenset(names[i] for i in candidate.strengths if power[i, order] > MOSTLY * power[i].sum())
    few = candidate.with_only(kept) if kept else candidate
    return few, np.array([position[names.index(one.parameter.name)] for one in few.coordinates])


def _pairs(candidate: Candidate, atoms: Sequence[Atom], orders: np.ndarray) -> list[Pair]:
    """Return the two responses of each strength that moves the lines."""
    angles = {c.parameter.only_with: i for i, c in enumerate(candidate.coordinates) if c.is_angle}
    found = []
    for strength in candidate.strengths:
        own = [atom for atom in atoms if atom.moving == (strength,)]
        angle = angles[candidate.coordinates[strength].parameter.name]
        quarter = quarter_of(candidate, angle)
        for atom in own[:1]:
            turned = [atom.response * np.exp(1j * orders * quarter)] if atom.turning == angle else []
            away = [other.position[angle] - atom.position[angle] - quarter for other in own]
            turned += [other.response for other, gap in zip(own, away, strict=True) if abs(gap) < 1e-9]
            # Of a line without phase there is a size only, whatever the angle.
            turns = turned and not np.allclose(turned[0], atom.response, rtol=1e-6, atol=0.0)
            across = turned[0] if turns else np.zeros_like(atom.response)
            found.append(Pair(strength, angle, atom.position, (atom.response, across)))
    return found


def quarter_of(candidate: Candidate, angle: int) -> float:
    """Return a quarter of the period of an angle, by the number of its coordinate."""
    return candidate.coordinates[angle].parameter.period / 4


def place_of(candidate: Candidate, pair: Pair, along: float, across: float) -> dict[str, float]:
    """Return the coordinates of a strength and its angle by name, from the sizes of the two responses."""
    strength, angle = candidate.coordinates[pair.strength], candidate.coordinates[pair.angle]
    zero = strength.parameter.zero or 0.0
    size = zero + math.hypot(along, across) * (strength.value(float(pair.position[pair.strength])) - zero)
    turned = (
        float(pair.position[pair.angle]) + math.atan2(across, along) * 4 * quarter_of(candidate, pair.angle) / math.tau
    )
    return {strength.parameter.name: strength.coordinate(size), angle.parameter.name: turned}


@dataclass(frozen=True, eq=False)
class Solution:
    """Least squares over pairs of responses, by their products with each other and with the residual."""

    power: np.ndarray
    along: np.ndarray

    def sizes(self, chosen: Sequence[int]) -> np.ndarray:
        """Return the best sizes of some pairs, (2 x pairs,)."""
        at = columns_of(chosen)
        power = self.power[np.ix_(at, at)]
        return np.linalg.solve(power + np.diag(ROUNDING * np.diag(power) + 1e-300), self.along[at])

    def without_least(self, chosen: Sequence[int]) -> list[int]:
        """Return the pairs without that which explains least beside the others."""
        left = [[j for j in chosen if j != i] for i in chosen]
        return max(left, key=self.gain)

    def gain(self, chosen: Sequence[int]) -> float:
        """Return half the squared residual that they explain."""
        return 0.5 * float(self.along[columns_of(chosen)] @ self.sizes(chosen)) if chosen else 0.0


def columns_of(chosen: Sequence[int]) -> np.ndarray:
    """Return the numbers of the responses of some pairs."""
    return np.array([2 * i + k for i in chosen for k in (0, 1)], dtype=int)


@dataclass(frozen=True, eq=False)
class _Solved:
    """Some pairs at their best sizes, and the logarithm of the density of the lines there, the law's error included."""

    chosen: Sequence[int]
    widened: Solution
    sizes: np.ndarray
    response: np.ndarray
    density: float

    @classmethod
    def of(
        cls,
        chosen: Sequence[int],
        plain: Solution,
        every: np.ndarray,
        white: np.ndarray,
        compared: Comparison,
        candidate: Candidate,
    ) -> _Solved:
        """Solve for some pairs, with the error of the law of what they make without it."""
        at = columns_of(chosen)
        made = np.tensordot(plain.sizes(chosen), every[at], 1)
        law = Widened(law_columns(compared, made, idealised=candidate.effect.IDEALISED))
        solved = law.solve(white)
        widened = Solution(solved @ white.T, solved @ compared.residual)
        sizes = widened.sizes(chosen)
        density = log_density(compared, compared.residual - sizes @ white[at], law)
        return cls(chosen, widened, sizes, np.tensordot(sizes, every[at], 1), density)


def asked_for(solution: Solution, alone: Sequence[bool]) -> list[int]:
    """Return which pairs explain enough beside the others; none where no pair that may be ``alone`` does."""
    chosen: list[int] = []
    while len(chosen) < len(alone):
        left = [i for i, may in enumerate(alone) if i not in chosen and (chosen or may)]
        gains = {i: solution.gain([*chosen, i]) for i in left}
        best = max(gains, key=lambda i: gains[i], default=-1)
        if best < 0 or gains[best] < solution.gain(chosen) + LEAST_GAIN:
            break
        chosen.append(best)
    while chosen:
        fewer = solution.without_least(chosen)
        if solution.gain(chosen) - solution.gain(fewer) >= LEAST_GAIN:
            break
        chosen = fewer
    return chosen if any(alone[i] for i in chosen) else []

"""A first look at every candidate: its responses on a coarse grid, its best strength and angle in closed form.

Two properties, tested for each candidate on this machine, save most evaluations. A response that doubles with its
strength needs one strength only. A response of a part that turns with the shaft only shifts the phase of order k by k
times its angle, and needs one angle only.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...simulators.machine import Machine
from .coordinates import log_prior
from .evidence import Comparison, Widened, law_columns, log_density
from .first_look import is_invisible, moved_to
from .hypotheses import Candidate
from .own_angles import at_own_angles, have_own_angles, quarter_turns
from .predict import Predictor, UnpredictableError
from .response_shape import SHAPE_LEVELS, ResponseShape, scaled_strengths
from .responses import Responses
from .together import together

FINE_ANGLES = 360
#: Levels of a strength that is not proportional, of a free angle that does not only turn, of any other parameter.
STRENGTH_LEVELS, ANGLE_LEVELS = 5, 8
#: So many levels of strengths and others together where motions repeat: a strength that moves a resonance past the
#: measured speeds has a hill of the likelihood between any two of them.
MOST_LEVELS = 24
MOST_SHAPES = 24
#: More responses than this are not computed for one candidate; fewer where each is a simulation in time.
MOST_ATOMS, MOST_IN_TIME = 128, 4
#: The same of motions that repeat, where that in the middle of the prior does not.
MOST_REPEATING = 64
#: At the first look a grid that is larger than the least is so many times coarser.
COARSER, LEAST_ATOMS = 4, 16
#: Factor over which a response that is not proportional is followed from where it was computed.
NEAR = 1.5
#: Factor over which one that is proportional is followed.
FAR = 1e3
#: Share of a strength's prior below it where several strengths are computed to be added up: the smaller, the better
#: they do.
SMALL_SHARE = 0.25
#: Logarithmic shares of the way from an atom's strength to the likeliest one that are tried.
PRIOR_SHARES = (1.0, 0.5, 0.1, 0.0)
#: Atoms of a candidate whose evidence is computed with the law's tolerance.
FINALISTS = 3
#: Coordinate below which a strength counts as absent, and coordinate of one that is present but small.
ABSENT, SMALL = 6.0, 2.0


@dataclass(frozen=True, eq=False)
class Atom:
    """A response of a candidate at one position of its coordinates.

    Attributes
    ----------
    position : ndarray (coordinates,)
    response : ndarray (conditions, probes, orders), complex
    moving : tuple of int
        Coordinates of the strengths that are not at zero.
    proportional : bool
        Whether the response is proportional to them.
    turning : int
        Coordinate whose angle only turns the response; -1 for none.
    """

    position: np.ndarray
    response: np.ndarray
    moving: tuple[int, ...]
    proportional: bool
    turning: int


@dataclass(frozen=True, eq=False)
class Start:
    """Where the search for a candidate's best values begins, and a rough evidence there.

    Attributes
    ----------
    candidate : Candidate
    position : ndarray (coordinates,)
    score : float
        Logarithm of the likelihood and the prior, the law's tolerance included.
    """

    candidate: Candidate
    position: np.ndarray
    score: float


def atoms_of(
    candidate: Candidate,
    machine: Machine,
    predictor: Predictor,
    *,
    deviations: np.ndarray | None = None,
    coarsely: bool = False,
) -> tuple[Atom, ...]:
    """Return the responses of one candidate on a coarse grid; none where its motion cannot be computed.

    Parameters
    ----------
    candidate : Candidate
    machine : Machine
    predictor : Predictor
    deviations : ndarray (conditions, probes, orders), optional
        Of the lines' noise; a candidate that stays far below it at any likely strength has no responses.
    coarsely : bool
        A quarter of the grid, where it has many places.
    """
    response = Responses([candidate], machine, predictor)
    found: list[Atom] = []
    sets = _strength_sets(candidate)
    for moving in sets:
        try:
            found += _atoms(candidate, response, moving, deviations, most=MOST_ATOMS // len(sets), coarsely=coarsely)
        except UnpredictableError:
            continue
    return tuple(found)


def _strength_sets(candidate: Candidate) -> list[tuple[int, ...]]:
    """Return which strengths act together: each alone; `starts` puts them together."""
    return [(one,) for one in candidate.strengths] or [()]


def _atoms(
    candidate: Candidate,
    response: Responses,
    moving: tuple[int, ...],
    deviations: np.ndarray | None,
    *,
    most: int,
    coarsely: bool,
) -> list[Atom]:
    coordinates = candidate.coordinates
    centre = np.zeros(len(coordinates))
    for i in candidate.strengths:
        if i not in moving:
            centre[i] = coordinates[i].coordinate(coordinates[i].parameter.zero or 0.0)
    first = response(centre)
    in_time = not response.repeats(centre)
    if not np.abs(first).max() > 0:
        return []
    if in_time:
        most = min(most, MOST_IN_TIME)
    elif is_invisible(response, centre, first, moving, deviations):
        return []
    shape = ResponseShape(candidate, response, centre, first, deviations)
    turning = next((i for i, c in enumerate(coordinates) if c.is_angle and shape.only_turns(i)), -1)
    proportional = bool(moving) and shape.is_proportional(moving)
    acting = {coordinates[i].parameter.name for i in moving} | {""}
    others = [i for i, c in enumerate(coordinates) if i not in candidate.strengths and c.parameter.only_with in acting]
    others = [i for i in others if i != turning]
    if not in_time:
        others = [i for i in others if shape.matters(i)]
    bent = moving if not proportional else ()
    most, repeating = (_coarser(count) if coarsely else count for count in (most, MOST_REPEATING))
    if have_own_angles(candidate):
        few = quarter_turns(candidate, centre, others, weakly=bent)
    else:
        few = _spread(candidate, centre, others, bent, most=most if bent else min(most, MOST_SHAPES))
    # Beside motions that repeat, the few that do not cost more than all others.
    computed = response.prepare(few, most_in_time=MOST_IN_TIME)
    positions = list(itertools.compress(few, computed))
    if in_time and candidate.effect.IDEALISED:
        # A contact that chatters in the middle of its prior may repeat elsewhere.
        many = _spread(candidate, centre, others, bent, most=repeating)
        positions += itertools.compress(many, response.prepare(many, most_in_time=0))
    found = []
    for position in positions:
        try:
            found.append(Atom(position, response(position), moving, proportional, turning))
        except UnpredictableError:
            continue
    return found


def _coarser(count: int) -> int:
    return max(count // COARSER, min(count, LEAST_ATOMS))


def _spread(
    candidate: Candidate, centre: np.ndarray, others: Sequence[int], bent: Sequence[int], *, most: int
) -> list[np.ndarray]:
    """Return positions over strengths that do not only scale, and over other coordinates.

    All combinations of a few levels where these are not too many. Else, where several strengths share an angle, small
    ones all round the circle, to be added up; or points that fill the space evenly (Sobol'), so that no direction is
    left out.
    """
    coordinates, moved = candidate.coordinates, (*bent, *others)
    if not moved:
        return [centre]
    of_others = [ANGLE_LEVELS if coordinates[i].is_angle else SHAPE_LEVELS for i in others]
    fine = int((min(MOST_LEVELS, most) / math.prod(of_others)) ** (1 / max(len(bent), 1)) + 1e-9)
    counts = [max(STRENGTH_LEVELS, fine)] * len(bent) + of_others
    if math.prod(counts) <= most:
        levels = [coordinates[i].quantiles(count) for i, count in zip(moved, counts, strict=True)]
        return [moved_to(centre, moved, values) for values in itertools.product(*levels)]
    shared = _shared_angle(candidate, others)
    if shared >= 0:
        small = [coordinates[i].at_share(SMALL_SHARE) for i in bent]
        return [moved_to(centre, [*bent, shared], [*small, at]) for at in coordinates[shared].quantiles(ANGLE_LEVELS)]
    from scipy.stats.qmc import Sobol

    power = int(math.log2(most))
    # From the corners of the small cubes, which the points are, to their middles.
    shares = Sobol(len(moved), scramble=False).random_base2(power) + 0.5 / 2**power
    return [
        moved_to(centre, moved, [coordinates[i].at_share(share) for i, share in zip(moved, point, strict=True)])
        for point in shares.tolist()
    ]


def _shared_angle(candidate: Candidate, others: Sequence[int]) -> int:
    """Return the only angle among some coordinates, where several strengths have it in common; else -1."""
    angles = [i for i in others if candidate.coordinates[i].is_angle]
    if len(candidate.strengths) < 2 or len(angles) != 1 or candidate.coordinates[angles[0]].parameter.only_with:
        return -1
    return angles[0]


def _all_at_one_angle(
    candidate: Candidate, atoms: Sequence[Atom], compared: Comparison
) -> tuple[float, np.ndarray, np.ndarray] | None:
    """Return all strengths at the angle where they explain most together, as `_pursued` does for others.

    None where they were not computed for that. No gain is told: it is that of the whole, computed by the caller.
    """
    shared = _shared_angle(candidate, [i for i in range(len(candidate.coordinates)) if i not in candidate.strengths])
    if shared < 0:
        return None
    one = candidate.coordinates[shared]
    by_place = {(atom.moving[0], float(atom.position[shared])): atom for atom in atoms if atom.turning < 0}
    grid = [[by_place.get((i, at)) for i in candidate.strengths] for at in one.quantiles(ANGLE_LEVELS)]
    rows = [[atom for atom in row if atom] for row in grid]
    if any(len(row) < len(candidate.strengths) for row in rows):
        return None
    responses = np.array([[atom.response for atom in row] for row in rows])
    angle, factors, response = together(responses, compared, idealised=candidate.effect.IDEALISED)
    position = rows[0][0].position.copy()
    position[shared] = one.at_share(angle)
    for i, factor, atom in zip(candidate.strengths, factors, rows[0], strict=True):
        strength = candidate.coordinates[i]
        zero = strength.parameter.zero or 0.0
        position[i] = strength.coordinate(zero + factor * (strength.value(float(atom.position[i])) - zero))
    return 0.0, position, response


def starts(candidate: Candidate, atoms: Sequence[Atom], compared: Comparison) -> list[Start]:
    """Return the candidate's best starts, best first.

    Parameters
    ----------
    candidate : Candidate
    atoms : sequence of Atom
    compared : Comparison
        Its residual may be what something else has left.
    """
    wanted = compared.residual
    if have_own_angles(candidate):
        few = at_own_angles(candidate, atoms, compared)
        return [_start(few[0], few[1], few[2], compared)] if few else []
    orders = compared.lines.phase_orders
    rated: list[tuple[float, np.ndarray, np.ndarray]] = []
    for atom in atoms:
        rated += _rated(candidate, atom, compared, orders, wanted)
    rated.sort(key=lambda item: -item[0])
    found = []
    best = _different(rated)
    if len(candidate.strengths) > 1 and best:
        at_one_angle = _all_at_one_angle(candidate, atoms, compared)
        best.insert(0, at_one_angle or _pursued(candidate, atoms, compared, orders, wanted, best[0]))
    for _, position, response in best:
        bounded = np.maximum(position, -SMALL) if len(candidate.strengths) > 1 else position
        found.append(_start(candidate, bounded, response, compared))
    return sorted(found, key=lambda one: -one.score)


def _start(candidate: Candidate, position: np.ndarray, response: np.ndarray, compared: Comparison) -> Start:
    law = Widened(law_columns(compared, response, idealised=candidate.effect.IDEALISED, directed=candidate.is_directed))
    value = log_density(compared, compared.residual - compared.whitened(response), law)
    return Start(candidate, position, value + log_prior(candidate.coordinates, position))


def _rated(
    candidate: Candidate, atom: Atom, compared: Comparison, orders: np.ndarray, wanted: np.ndarray
) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Return gain of likelihood and prior, position and response of an atom at its best strength and best angles."""
    found = []
    reach = FAR if atom.proportional else NEAR
    parts = compared.whitening.of_orders(atom.response)
    for angle in _best_angles(parts, orders, wanted) if atom.turning >= 0 else [0.0]:
        white = _at_angle(parts, orders, angle)
        power = float(white @ white)
        if power < 1e-9:
            continue
        along = float(white @ wanted)
        # Of a strength to both sides only one is in the grid, where the response is proportional to it.
        turned = along < 0 and atom.proportional and _turns_about(candidate, atom)
        likeliest = min(max(abs(along) / power if turned or along > 0 else 0.0, 1 / reach), reach)
        options = []
        # Where the prior is narrow the best strength lies between the likeliest one and the prior's middle.
        for share in PRIOR_SHARES:
            scale = -(likeliest**share) if turned else likeliest**share
            position = _scaled(candidate, atom, scale)
            if atom.turning >= 0:
                position[atom.turning] += angle
            gain = scale * along - 0.5 * scale**2 * power + _present_prior(candidate, atom, position)
            options.append((gain, position, scale * atom.response * np.exp(1j * orders * angle)))
        found.append(max(options, key=lambda option: option[0]))
    return found


def _present_prior(candidate: Candidate, atom: Atom, position: np.ndarray) -> float:
    """Return the logarithm of the prior density, without the strengths that the atom leaves at zero."""
    kept = [i for i in range(len(candidate.coordinates)) if i not in candidate.strengths or i in atom.moving]
    return log_prior([candidate.coordinates[i] for i in kept], position[kept])


def _pursued(
    candidate: Candidate,
    atoms: Sequence[Atom],
    compared: Comparison,
    orders: np.ndarray,
    wanted: np.ndarray,
    first: tuple[float, np.ndarray, np.ndarray],
) -> tuple[float, np.ndarray, np.ndarray]:
    """Return all strengths together: each in turn explains best what those before it have left."""
    gain, position, response = first
    position = position.copy()
    present = [i for i in candidate.strengths if position[i] > -ABSENT]
    while len(present) < len(candidate.strengths):
        left = wanted - compared.whitened(response)
        options = []
        for atom in atoms:
            if atom.moving[0] not in present:
                options += [(atom, *one) for one in _rated(candidate, atom, compared, orders, left)]
        if not options:
            break
        atom, further, where, added = max(options, key=lambda option: option[1])
        moved = [atom.moving[0]] + ([atom.turning] if atom.turning >= 0 else [])
        position[moved] = where[moved]
        present.append(atom.moving[0])
        if further > 0:
            gain, response = gain + further, response + added
        else:
            # Small, but not gone: a strength of nothing has no slope to climb.
            position[atom.moving[0]] = -SMALL
    for i in candidate.strengths:
        position[i] = max(position[i], -SMALL) if i not in present else position[i]
    return gain, position, response


def _different(rated: list[tuple[float, np.ndarray, np.ndarray]]) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Return the best few that do not lie side by side."""
    chosen: list[tuple[float, np.ndarray, np.ndarray]] = []
    for one in rated:
        if all(np.abs(one[1] - other[1]).max() > 0.3 for other in chosen):
            chosen.append(one)
        if len(chosen) == FINALISTS:
            break
    return chosen


def _scaled(candidate: Candidate, atom: Atom, scale: float) -> np.ndarray:
    """Return the position of the scaled atom, as near as its bounds allow."""
    for share in (1.0, 0.5, 0.0):
        found = scaled_strengths(candidate, atom.position, atom.moving, math.copysign(abs(scale) ** share, scale))
        if found is not None:
            return found
    return atom.position.copy()


def _turns_about(candidate: Candidate, atom: Atom) -> bool:
    """Return whether the atom's strengths may be as large to the other side."""
    return bool(atom.moving) and scaled_strengths(candidate, atom.position, atom.moving, -1.0) is not None


def _at_angle(parts: np.ndarray, orders: np.ndarray, angle: float) -> np.ndarray:
    return np.cos(orders * angle) @ parts[0] + np.sin(orders * angle) @ parts[1]


def _best_angles(parts: np.ndarray, orders: np.ndarray, wanted: np.ndarray) -> list[float]:
    """Return the angles at which the turned response, at its best strength, explains most: local bests of a grid."""
    rows = parts.reshape(-1, parts.shape[-1])
    angles = 2 * np.pi * np.arange(FINE_ANGLES) / FINE_ANGLES
    waves = np.concatenate([np.cos(np.outer(angles, orders)), np.sin(np.outer(angles, orders))], axis=1)
    projected = np.maximum(waves @ (rows @ wanted), 0.0)
    power = ((waves @ (rows @ rows.T)) * waves).sum(axis=1)
    gain = projected**2 / np.maximum(power, 1e-300)
    peaks = [i for i in range(FINE_ANGLES) if gain[i] >= gain[i - 1] and gain[i] >= gain[(i + 1) % FINE_ANGLES]]
    return [float(angles[i]) for i in sorted(peaks, key=lambda i: -gain[i])[:FINALISTS]]

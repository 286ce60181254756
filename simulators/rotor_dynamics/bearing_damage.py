"""Damage of a ball bearing: pits in the races, a spot on a ball, an uneven cage, and the slip of the cage.

A pit of length s along the race lets a ball sink by the difference of the two sagittas, h0 = s^2 / (8 R), R being the
relative radius of ball and race along the rolling direction, d/2 (1 -+ d/D). The contact of a ball that is an angle a
away from the pit's middle is relieved by

    h = h0 (1 - q^2)^2,   q = sin a / sin a0,   a0 = s / (D -+ d)          for |q| < 1,

inner race above, outer race below the sign. A spot on a ball does the same when its spin brings it to the outer race
(b = 0) and to the inner race (b = pi), with q = sin b / sin(s / d). Load zone and modulation (inner race +- 1X, ball
+- cage) need nothing more: a ball without load has nothing to lose.

The cage turns by (1 - slip) of its ideal angle plus a wander, a few sines with random orders below half a cage turn,
so that their rate has the wanted standard deviation; balls and their spin follow the cage.

Two kinds of contacts: K approach^1.5 (Hertz, the spring in the linear core taken off again), and for a linear bearing
of stiffness k unilateral springs 4 k / Z, whose sum is k; there only what a relieved or shifted ball loses is a force.
The load of such a bearing presses its balls by tenths of a micrometre, far less than h0, so that the law above would
cut it off at the very edge. The patch of contact is some tenths of a millimetre long and crosses the edge gradually: a
ball pressed by a loses the share (1 - q^2)^2 h0 / (h0 + a) of its load.

Left out: mass of the balls (no impact of the ball itself on the far edge), growth and roughness of the pit's floor,
lubricant film, wandering of a ball's spin axis, skidding outside the load zone.

Sources: R. B. Randall and J. Antoni, "Rolling element bearing diagnostics - a tutorial", Mech. Syst. Signal Process. 25
(2011) 485-520, section 2 (kinematics, slip of 1-2 %, modulation); N. Sawalhi and R. B. Randall, "Simulating gear and
bearing interactions in the presence of faults", Mech. Syst. Signal Process. 22 (2008) 1924-1951 (pit as an added
clearance of the ball).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..errors import InvalidValueError
from ..law import Direction, InterfaceForce, Law, Timeline, compiled_force
from .hertz import raceway_radii_m
from .rolling_bearing import BearingGeometry

# Parameters of the laws: these, then cosine and sine of each ball, the pits that a ball in its place may meet, the pits
# that a shifted ball may meet, the spots, the shifted balls, the sines of the wander.
_STIFFNESS, _CLEARANCE, _CORE, _ROUNDING, _CAGE, _FIRST_BALL, _BALLS, _PITS, _MET, _SPOTS, _SHIFTS, _SINES, _FIRST = (
    range(13)
)
_PIT, _SPOT, _SHIFT, _SINE = 6, 6, 3, 3
#: Signals of the laws: cosine and sine of the cage, then for each pit and spot ball, relief and deepest relief.
_CAGE_SIGNALS, _RELIEF = 2, 3
_COUNTS = (_BALLS, _PITS, _MET, _SPOTS, _SHIFTS, _SINES)
#: A linear bearing's balls lose contact within this approach, as if preloaded by a light fit; a sharp corner would cost
#: the solver its order.
ROUNDING_M = 5e-8
#: Sines of one wander, and the range of their orders over the cage's.
_WANDER_SINES, _WANDER_ORDERS = 3, (1 / 40, 1 / 2)


def _damage_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    """Return cosine and sine of the cage, then for each pit and spot (ball, relief, deepest relief), 0 while none.

    Which ball is in a pit does not depend on the motion: to find it here spares the compiled laws the search.
    """
    balls, pits, met, spots, shifts = (int(parameters[row, 0]) for row in (_BALLS, _PITS, _MET, _SPOTS, _SHIFTS))
    blocks, at = [], _FIRST + 2 * balls
    for count, width in ((pits, _PIT), (met, _PIT), (spots, _SPOT), (shifts, _SHIFT)):
        blocks.append(parameters[at : at + width * count].reshape(count, width, parameters.shape[1]))
        at += width * count
    cage = parameters[_CAGE] * timeline.phase_rad
    for order, amplitude, phase in parameters[at:].reshape(-1, _SINE, parameters.shape[1]):
        cage = cage + amplitude * np.sin(order * timeline.phase_rad + phase)
    signals = np.zeros((_CAGE_SIGNALS + _RELIEF * (pits + met + spots), *timeline.phase_rad.shape))
    signals[0], signals[1] = np.cos(cage), np.sin(cage)
    rows = iter(signals[_CAGE_SIGNALS:].reshape(-1, _RELIEF, timeline.phase_rad.size))
    for order, angle, sharpness, deep, _, neighbour in blocks[0]:
        away = order * timeline.phase_rad + (angle - parameters[_FIRST_BALL]) - cage
        where, lane, number, share = _passes(away, 2 * math.pi / balls, sharpness, neighbour)
        ball = np.mod(number, balls)
        in_place = np.all(ball != blocks[3][:, 0, lane], axis=0)
        _write(next(rows), where, ball, share * deep[lane] * in_place, deep[lane])
    for order, angle, sharpness, deep, ball, place in blocks[1]:
        away = order * timeline.phase_rad + (angle - place) - cage
        where, lane, _, share = _passes(away, 2 * math.pi, sharpness)
        _write(next(rows), where, ball[lane], share * deep[lane], deep[lane])
    for ball, spin, angle, sharpness, outer, inner in blocks[2]:
        where, lane, number, share = _passes(spin * cage + angle, math.pi, sharpness)
        deep = np.where(np.mod(number, 2) == 0, outer[lane], inner[lane])
        _write(next(rows), where, ball[lane], share * deep, deep)
    return signals


def _passes(
    angle: np.ndarray, spacing: float, sharpness: np.ndarray, further: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return where (as in a flat array) and in which lane ``angle`` is close to a multiple of ``spacing``.

    Also the number of the multiple, the nearest one or so many ``further``, and (1 - q^2)^2.
    """
    multiple = angle / spacing
    number = np.rint(multiple)
    if further is not None and further.any():
        number += further
    away = multiple - number
    away *= spacing
    half = np.arcsin(np.minimum(sharpness**-0.5, 1.0))
    where = np.flatnonzero(np.abs(away) < half)
    lane = where % angle.shape[1]
    inside = 1.0 - np.sin(away.ravel()[where]) ** 2 * sharpness[lane]
    return where, lane, number.ravel()[where], np.maximum(inside, 0.0) ** 2


def _write(row: np.ndarray, where: np.ndarray, *values: np.ndarray) -> None:
    for own, value in zip(row, values, strict=True):
        own[where] = value


@compiled_force
def _hertz_force(signals, parameters, x, inputs, outputs, u):  # type: ignore[no-untyped-def]
    for lane in range(u.shape[1]):
        right, up = x[inputs[0], lane], x[inputs[1], lane]
        cage_cos, cage_sin = signals[0, lane], signals[1, lane]
        sum_x, sum_y = parameters[_CORE, lane] * right, parameters[_CORE, lane] * up
        for ball in range(int(parameters[_BALLS, lane])):
            a, b = parameters[_FIRST + 2 * ball, lane], parameters[_FIRST + 2 * ball + 1, lane]
            cos, sin = cage_cos * a - cage_sin * b, cage_sin * a + cage_cos * b
            approach = right * cos + up * sin - parameters[_CLEARANCE, lane]
            if approach <= 0.0:
                continue
            for row in range(_CAGE_SIGNALS, signals.shape[0], _RELIEF):
                if signals[row, lane] == ball:
                    approach -= signals[row + 1, lane]
            if approach > 0.0:
                load = parameters[_STIFFNESS, lane] * approach * math.sqrt(approach)
                sum_x -= load * cos
                sum_y -= load * sin
        u[outputs[0], lane] += sum_x
        u[outputs[1], lane] += sum_y


@compiled_force
def _relief_force(signals, parameters, x, inputs, outputs, u):  # type: ignore[no-untyped-def]
    # Only balls in a pit, with a spot or out of place are looked at: the spring holds the others' share already.
    for lane in range(u.shape[1]):
        right, up = x[inputs[0], lane], x[inputs[1], lane]
        half, square = 0.5 * parameters[_STIFFNESS, lane], parameters[_ROUNDING, lane] ** 2
        for row in range(_CAGE_SIGNALS, signals.shape[0], _RELIEF):
            if signals[row + 1, lane] <= 0.0:
                continue
            own = _FIRST + 2 * int(signals[row, lane])
            a, b = parameters[own, lane], parameters[own + 1, lane]
            cos = signals[0, lane] * a - signals[1, lane] * b
            sin = signals[1, lane] * a + signals[0, lane] * b
            approach = right * cos + up * sin
            # What several pits and spots take off one ball is at most its load: the first of them does it for all.
            share, done = 0.0, False
            for other in range(_CAGE_SIGNALS, signals.shape[0], _RELIEF):
                if signals[other, lane] == signals[row, lane] and signals[other + 1, lane] > 0.0:
                    done = done or other < row
                    share += signals[other + 1, lane] / (signals[other + 2, lane] + max(approach, 0.0))
            if not done:
                lost = half * (approach + math.sqrt(approach * approach + square)) * min(share, 1.0)
                u[outputs[0], lane] += lost * cos
                u[outputs[1], lane] += lost * sin
        shifts = _FIRST + 2 * int(parameters[_BALLS, lane])
        shifts += _PIT * int(parameters[_PITS, lane] + parameters[_MET, lane]) + _SPOT * int(parameters[_SPOTS, lane])
        for at in range(shifts, shifts + _SHIFT * int(parameters[_SHIFTS, lane]), _SHIFT):
            for place in range(2):
                # The load where the ball is goes, the one where the spring has it comes back.
                own = at + 1 if place else _FIRST + 2 * int(parameters[at, lane])
                a, b = parameters[own, lane], parameters[own + 1, lane]
                cos = signals[0, lane] * a - signals[1, lane] * b
                sin = signals[1, lane] * a + signals[0, lane] * b
                approach = right * cos + up * sin
                load = half * (approach + math.sqrt(approach * approach + square)) * (1.0 if place else -1.0)
                u[outputs[0], lane] += load * cos
                u[outputs[1], lane] += load * sin


DAMAGED_BALLS = Law("Hertz contacts of a damaged ball bearing", _damage_signals, _hertz_force, counts=_COUNTS)
RELIEVED_BALLS = Law(
    "load that damage takes off the balls of a linear bearing", _damage_signals, _relief_force, counts=_COUNTS
)


@dataclass
class BearingDamage:
    """What is wrong with a bearing; effects add to it. See the module for the laws.

    Attributes
    ----------
    slip : float
        Share by which the cage lags behind pure rolling; the largest asked for.
    """

    slip: float = 0.0
    _pits: list[tuple[bool, float, float]] = field(default_factory=list)
    _spots: list[tuple[int, float, float]] = field(default_factory=list)
    _shifts: list[tuple[int, float]] = field(default_factory=list)
    _wanders: list[tuple[float, int]] = field(default_factory=list)

    @property
    def is_present(self) -> bool:
        """Whether anything differs from a sound bearing without slip."""
        return bool(self._pits or self._spots or self._shifts or self._wanders or self.slip)

    def add_pit(self, *, inner: bool, size_m: float, angle_rad: float) -> None:
        """Add a pit of ``size_m`` along a race, its middle at ``angle_rad`` from x at shaft angle 0."""
        if size_m > 0:
            self._pits.append((inner, size_m, angle_rad))

    def add_spot(self, *, ball: int, size_m: float, angle_rad: float) -> None:
        """Add a spot to a ball; ``angle_rad`` from the outer race at shaft angle 0, in the sense of its spin."""
        if size_m > 0:
            self._spots.append((ball, size_m, angle_rad))

    def shift_ball(self, *, ball: int, distance_m: float) -> None:
        """Let a ball run behind its place in the cage by ``distance_m`` along the pitch circle."""
        if distance_m:
            self._shifts.append((ball, distance_m))

    def add_slip(self, *, slip: float, wander: float, seed: int) -> None:
        """Let the cage slip.

        Parameters
        ----------
        slip : float
            Mean share, 0 to below 1. The largest of several holds.
        wander : float
            Standard deviation of the cage's speed over its mean; several add as independent ones.
        seed : int
            Of the wander.
        """
        if not (0 <= slip < 1 and 0 <= wander < 1):
            raise InvalidValueError(f"Slip {slip:g} with wander {wander:g}; allowed: 0 to below 1. 0.01 is 1 %.")
        self.slip = max(self.slip, slip)
        if wander > 0:
            self._wanders.append((wander, seed))

    def cage_order(self, geometry: BearingGeometry, shaft_ratio: float) -> float:
        """Return turns of the cage for each turn of the reference shaft, slip included."""
        return geometry.defect_orders().cage * shaft_ratio * (1 - self.slip)

    def interface_force(
        self,
        name: str,
        geometry: BearingGeometry,
        along: tuple[Direction, Direction],
        *,
        contact_stiffness: float,
        hertz: bool,
        clearance_m: float,
        core_stiffness_n_m: float,
        first_ball_rad: float,
        shaft_ratio: float,
    ) -> InterfaceForce:
        """Return what the linear core leaves out.

        With ``hertz`` the contacts of the damaged bearing less the core's spring, else what damage takes off its balls.

        Parameters
        ----------
        name : str
        geometry : BearingGeometry
        along : pair of Direction
            x and y of the inner ring less those of the outer ring.
        contact_stiffness : float
            Of one ball, N/m^1.5 with ``hertz``, else N/m.
        hertz : bool
        clearance_m, core_stiffness_n_m, first_ball_rad, shaft_ratio : float
        """
        cage = self.cage_order(geometry, shaft_ratio)
        turns = np.arange(geometry.balls) / geometry.balls
        angles = first_ball_rad + 2 * math.pi * turns
        balls = sorted({ball % geometry.balls for ball, _ in self._shifts})
        even = [value for ball in balls for value in (float(ball), math.cos(angles[ball]), math.sin(angles[ball]))]
        for ball, distance in sorted(self._shifts):
            angles[ball % geometry.balls] -= 2 * distance / geometry.pitch_diameter_m
        pairs = np.stack([np.cos(angles), np.sin(angles)], axis=1).ravel().tolist()
        spin = geometry.defect_orders().ball_spin / geometry.defect_orders().cage
        rows = [_pit_row(geometry, shaft_ratio, *pit) for pit in sorted(self._pits)]
        pits = [(*row, -1.0, further) for row in rows for further in _neighbours(row[2], geometry.balls)]
        met = [(*row, float(ball), angles[ball]) for row in rows for ball in balls]
        spots = [value for spot in sorted(self._spots) for value in _spot_row(geometry, spin, *spot)]
        sines = [value for own in sorted(self._wanders) for value in _wander_rows(cage, *own)]
        head = [contact_stiffness, clearance_m, core_stiffness_n_m, ROUNDING_M, cage, first_ball_rad]
        counts = [geometry.balls, len(pits), len(met), len(self._spots), len(balls), len(sines) // _SINE]
        places = [value for row in (*pits, *met) for value in row]
        parameters = (*head, *map(float, counts), *pairs, *places, *spots, *even, *sines)
        return InterfaceForce(name, DAMAGED_BALLS if hertz else RELIEVED_BALLS, parameters, along, along)


def relief_m(geometry: BearingGeometry, *, size_m: float, inner: bool) -> float:
    """Return how far a ball sinks into a pit of ``size_m`` along a race, s^2 / (8 R), in m."""
    radius, _ = raceway_radii_m(
        ball_diameter_m=geometry.ball_diameter_m,
        pitch_diameter_m=geometry.pitch_diameter_m,
        race_conformity=0.52,
        contact_angle_rad=geometry.contact_angle_rad,
        inner=inner,
    )
    return size_m**2 / (8 * radius)


def pit_half_angle_rad(geometry: BearingGeometry, *, size_m: float, inner: bool) -> float:
    """Return half of the angle that a pit takes on its race, seen from the bearing's centre: s / (D -+ d)."""
    ball = geometry.ball_diameter_m * math.cos(geometry.contact_angle_rad)
    return size_m / (geometry.pitch_diameter_m + (-ball if inner else ball))


def _sharpness(half_angle_rad: float) -> float:
    return 1 / math.sin(min(half_angle_rad, math.pi / 2)) ** 2


def _neighbours(sharpness: float, balls: int) -> list[float]:
    """Return which balls a pit can hold, counted from the one nearest to its middle: itself unless the pit is wide."""
    reach = math.asin(min(sharpness**-0.5, 1.0)) * balls / (2 * math.pi)
    most = min(math.floor(reach + 0.5), (balls - 1) // 2)
    return [float(number) for number in range(-most, most + 1)]


def _pit_row(
    geometry: BearingGeometry, shaft_ratio: float, inner: bool, size_m: float, angle_rad: float
) -> tuple[float, ...]:
    half = pit_half_angle_rad(geometry, size_m=size_m, inner=inner)
    order = shaft_ratio if inner else 0.0
    return order, angle_rad, _sharpness(half), relief_m(geometry, size_m=size_m, inner=inner)


def _spot_row(geometry: BearingGeometry, spin: float, ball: int, size_m: float, angle_rad: float) -> tuple[float, ...]:
    deep = [relief_m(geometry, size_m=size_m, inner=inner) for inner in (False, True)]
    return float(ball % geometry.balls), spin, angle_rad, _sharpness(size_m / geometry.ball_diameter_m), *deep


def _wander_rows(cage_order: float, wander: float, seed: int) -> list[float]:
    """Return order, amplitude and phase of sines whose sum has a rate of the wanted deviation."""
    generator = np.random.default_rng(seed)
    low, high = (math.log(share) for share in _WANDER_ORDERS)
    bands = low + (high - low) * (np.arange(_WANDER_SINES) + generator.uniform(size=_WANDER_SINES)) / _WANDER_SINES
    orders = np.exp(bands)
    # Over the cage's order, which cancels: each sine carries an equal share of the rate's variance.
    amplitudes = wander * math.sqrt(2 / _WANDER_SINES) / orders
    phases = generator.uniform(0, 2 * math.pi, _WANDER_SINES)
    return np.stack([cage_order * orders, amplitudes, phases], axis=1).ravel().tolist()

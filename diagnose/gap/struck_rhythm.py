"""Whose rhythm the envelope beats: of the effects that strike in one part, which cannot be what is heard.

A line's size is read in a band, as bearings slip. Where balls pass the outer race three times a turn and the inner race
five times, nearly, the bands of one hold sidebands of the other, and sizes alone may name the wrong race. The lines of
one effect keep their places to each other, whatever the slip: on the envelope's spectrum only one fits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...simulators.effect import Effect
from ...simulators.errors import RotorwiseError
from ...simulators.machine import Machine
from .envelope_lines import NARROW, NARROW_BINS, Spectrum
from .wanted_lines import STRUCK

#: Slips of the cage that are tried: under thrust balls roll at an angle, which looks like a negative one.
SLIPS = np.arange(-0.025, 0.0351, 0.0005)
#: Lines of an effect that are looked at, its strongest first.
LINES = 12
#: An effect that makes this share of what stands out excludes those of the same part that make less than a part of it.
MOST, FAINT = 0.4, 0.5
#: Where no effect makes that share of many lines, so many in a record, something else strikes: those that make less
#: than this are not it. Of 29 races and balls on the test rig, in noise of 20 and 30 dB, slips that wander by up to
#: 1 %, each made 0.11 or more, all but one 0.39; of 75 others of their bearing 63 made less than 0.05.
MANY_LINES, NOT_IT = 10, 0.05
#: Nor are those whose lines would hold as much elsewhere, their first one moved by these shares of it, each tried at
#: all slips. Of races and balls that were struck (100, with so many lines) all but two balls of 0.68 and 0.88 held most
#: at their own place; of others of their bearing none but cages beside a ball and one inner race of 0.50.
ELSEWHERE = np.concatenate([np.arange(-0.45, -0.07, 0.06), np.arange(0.07, 0.8, 0.06)])
#: Multiples of a rhythm's strongest line, and of the distance to the next on both sides, at which it may lie outside
#: the envelope, and how near to one, as a share.
HARMONICS, SIDEBANDS, WANDERS = 4, 4, 0.004


@dataclass(frozen=True)
class Rhythm:
    """Which share of what stands out of the envelope an effect's lines hold, and the slip at which they do."""

    share: float
    slip: float


def not_heard(effects: Sequence[Effect], machine: Machine, envelopes: Sequence[Spectrum]) -> frozenset[Effect]:
    """Return the effects that cannot be what strikes, as another one in the same part, or none of them, clearly is.

    Parameters
    ----------
    effects : sequence of Effect
        Those that compete, at their places.
    machine : Machine
    envelopes : sequence of Spectrum
        As of `envelopes_of`.
    """
    struck = that_strike(effects)
    heard = {one: rhythm(one, machine, envelopes).share for one in struck}
    most = {one: max(share for rival, share in heard.items() if rival.at == one.at) for one in heard}
    many = len(envelopes) and np.mean([one.orders.size for one in envelopes]) >= MANY_LINES
    stranger = many and max(heard.values(), default=MOST) < MOST
    least = {one: FAINT * most[one] if most[one] >= MOST else NOT_IT * stranger for one in heard}
    silent = frozenset(one for one, share in heard.items() if share < least[one])
    left = [one for one in heard if one not in silent] if stranger else []
    return silent | {one for one in left if heard[one] <= elsewhere(one, machine, envelopes)}


def of_a_rhythm(
    orders: np.ndarray, effects: Sequence[Effect], machine: Machine, envelopes: Sequence[Spectrum]
) -> np.ndarray:
    """Return which lines belong to the rhythm that the envelope clearly beats in, bool.

    They are no further lines beside it. Where exactly they lie follows from a slip that wanders, and with it what a
    narrow band about them holds: the rhythm's sizes are looked at in the envelope.

    Parameters
    ----------
    orders : ndarray of any shape
    effects, machine, envelopes
        As in `not_heard`.
    """
    struck = that_strike(effects)
    found = [(rhythm(one, machine, envelopes), one) for one in struck]
    own, effect = max(found, key=lambda one: one[0].share, default=(Rhythm(0.0, 0.0), None))
    stated = None if effect is None or own.share < MOST else _places(effect, machine)
    if stated is None:
        return np.zeros(orders.shape, dtype=bool)
    lines = stated[int(np.argmin(np.abs(SLIPS - own.slip)))]
    apart = lines[1 % lines.size] - lines[0]
    places = lines[0] * np.arange(HARMONICS + 1)[:, None] + apart * np.arange(-SIDEBANDS, SIDEBANDS + 1)
    places = np.abs(places).ravel()
    # Whole orders are the shaft's.
    places = places[np.abs(places - np.rint(places)) > WANDERS * places]
    return np.any(np.abs(orders[..., None] - places) <= WANDERS * places, axis=-1)


def that_strike(effects: Sequence[Effect]) -> list[Effect]:
    """Return those of effects that strike in a bearing, in a rhythm that its slip moves."""
    return [one for one in effects if one.ROLE in STRUCK and "slip" in one.values()]


def rhythm(effect: Effect, machine: Machine, spectra: Sequence[Spectrum]) -> Rhythm:
    """Return which share of what stands out of envelopes an effect's lines hold, at the slip that fits all best."""
    places = _places(effect, machine)
    if places is None or not spectra:
        return Rhythm(0.0, 0.0)
    shares = np.mean([_held(one, places) for one in spectra], axis=0)
    best = int(np.argmax(shares))
    return Rhythm(float(shares[best]), float(SLIPS[best]))


def strongest_order(effect: Effect, machine: Machine, slip: float) -> float:
    """Return the order of an effect's strongest line at one of `SLIPS`; NaN where it states none."""
    places = _places(effect, machine)
    return math.nan if places is None else float(places[int(np.argmin(np.abs(SLIPS - slip))), 0])


def elsewhere(effect: Effect, machine: Machine, spectra: Sequence[Spectrum]) -> float:
    """Return the largest share that an effect's lines would hold if its rhythm were another one.

    Its first line and the multiples of that are moved, the distances of the sidebands from these kept.
    """
    places = _places(effect, machine)
    if places is None or not spectra:
        return 0.0
    multiples = np.rint(places / places[:, :1])
    moved = [places + multiples * (share * places[:, :1]) for share in ELSEWHERE]
    return max(float(np.mean([_held(one, rows) for one in spectra], axis=0).max()) for rows in moved)


def taken_by(effect: Effect, machine: Machine, spectra: Sequence[Spectrum]) -> tuple[tuple[Spectrum, ...], list[int]]:
    """Return spectra without the lines that an effect holds at the slip that fits all best, and how many these are."""
    places = _places(effect, machine)
    if places is None or not spectra:
        return tuple(spectra), [0] * len(spectra)
    row = int(np.argmin(np.abs(SLIPS - rhythm(effect, machine, spectra).slip)))
    own = places[row : row + 1]
    taken = [_near(one, own)[0].any(axis=0) & (_held(one, own)[0] > 0) for one in spectra]
    left = tuple(one.taken(lines) for one, lines in zip(spectra, taken, strict=True))
    return left, [int(lines.sum()) for lines in taken]


def _places(effect: Effect, machine: Machine) -> np.ndarray | None:
    """Return the orders of an effect's strongest lines at each slip, shape (slips, lines)."""
    try:
        rows = [
            np.array([abs(line.order) for line in effect.with_values(slip=slip).signature(machine)[:LINES]])
            for slip in (0.0, 0.02)
        ]
    except RotorwiseError:
        return None
    count = min(row.size for row in rows)
    if not count:
        return None
    first, second = (row[:count] for row in rows)
    return first + np.outer(SLIPS / 0.02, second - first)


def _held(spectrum: Spectrum, places: np.ndarray) -> np.ndarray:
    """Return the share of the power that stands out that lies near each row of places; 0 with nothing near its first.

    The first line is the effect's strongest: without it the others are those of something else, as the cage's are,
    which a ball has as well.
    """
    if not spectrum.orders.size:
        return np.zeros(len(places))
    near = _near(spectrum, places)
    shares = near.any(axis=1) @ spectrum.power / spectrum.power.sum()
    return np.where(near[:, 0].any(axis=1), shares, 0.0)


def _near(spectrum: Spectrum, places: np.ndarray) -> np.ndarray:
    """Return which lines of a spectrum lie at which of each row of places, shape (rows, places, lines)."""
    away = np.abs(spectrum.orders - places[:, :, None])
    return away <= np.maximum(NARROW * places, NARROW_BINS * spectrum.resolution)[:, :, None]

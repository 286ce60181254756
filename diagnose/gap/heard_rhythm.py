"""Races and balls that are named by the rhythm of the envelope, where the sizes of its lines are not the model's.

How loud a defect strikes at a sensor no model of a real machine tells well, so that its lines stay unexplained. That it
strikes is told all the same, as an analyst tells it: what is new in the envelope beats in the rhythm of one part of a
bearing, and would not in another rhythm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...simulators.effect import Effect
from ...simulators.machine import Machine
from .envelope_lines import Spectrum
from .lines import OrderLines
from .result import Cause
from .size_scale import from_scale
from .struck_rhythm import FAINT, MOST, elsewhere, rhythm, strongest_order, taken_by, that_strike

#: Lines that a rhythm must hold at least, on the mean over the records in which it is heard.
LEAST_LINES = 3.0
#: Power over the floor that its strongest line must have: the sound bearing of a measured bench reaches 42 at some
#: speeds and not at others, the defects of three measured rigs 339 and more.
LOUD = 100.0
#: A ball beats with its cage as well, so that one that holds this share of what the cage does goes before it.
AS_MUCH = 0.9
#: Distance, as a share of its order, within which a line that was observed is the rhythm's strongest, and the factor by
#: which it is larger at the probe that is told.
NEAR, CLEARLY_LOUDER = 0.03, 2.0
#: Probability of what is named by its rhythm: see "Named by its rhythm" in README.md.
HEARD = 0.95


@dataclass(frozen=True)
class Heard:
    """The effect whose rhythm the envelope beats in.

    Attributes
    ----------
    effect : Effect
        At the first of its places.
    places : tuple of str
        Where it may be: bearings of the same kind beat alike.
    share, slip : float
        What its lines hold of what stands out, and the slip of the cage at which they do.
    is_sure : bool
        Whether it is named by that alone.
    loudest : str
        The probe at which its strongest line is clearly the largest; empty without one.
    """

    effect: Effect
    places: tuple[str, ...]
    share: float
    slip: float
    is_sure: bool
    loudest: str = ""

    @property
    def cause(self) -> Cause:
        """Return it as a cause, none of its values told."""
        return Cause(self.effect.NAME, " or ".join(self.places), HEARD, {}, self.effect.CHECK)

    @property
    def words(self) -> str:
        """Return what is heard, as a remark."""
        places = " or ".join(self.places).replace("_", " ")
        said = (
            f"The envelope beats in the rhythm of {self.effect.NAME.replace('_', ' ')} at {places}: at a slip of "
            f"{100 * self.slip:.1f} % its lines hold {self.share:.0%} of what stands out. Their sizes are not those "
            "that the model makes."
        )
        said += f" They are loudest at {self.loudest}." if self.loudest else ""
        return f"{said} It is named by its rhythm alone; the extended machine has none of it." if self.is_sure else said

    def added(
        self, kind: str, causes: tuple[Cause, ...], probabilities: Mapping[tuple[str, ...], float]
    ) -> tuple[str, tuple[Cause, ...], dict[tuple[str, ...], float]]:
        """Return a verdict's kind, causes and hypotheses with this acting beside something unknown.

        As they are where it is not sure, or where other causes explain all lines.
        """
        if not self.is_sure or kind not in ("none", "cannot tell", "unknown"):
            return kind, causes, dict(probabilities)
        total: dict[tuple[str, ...], float] = {}
        for names, share in probabilities.items():
            others = {name for name in names if name != "unknown"}
            key = (*sorted({*others, self.effect.NAME}), "unknown")
            total[key] = total.get(key, 0.0) + HEARD * share
            total[names] = total.get(names, 0.0) + (1 - HEARD) * share
        ranked = dict(sorted(total.items(), key=lambda item: -item[1]))
        return "unknown", (*causes, self.cause), ranked


def heard_rhythm(
    effects: Sequence[Effect], machine: Machine, envelopes: Sequence[Spectrum], lines: OrderLines | None = None
) -> Heard | None:
    """Return the effect whose rhythm holds most of what stands out of the envelopes; None where none does.

    It is named by that where in half of the records or more only what is new since the healthy ones counts, and these
    hold lines enough, one of them loud, where the same lines would hold less than half of it at any other place, and no
    other effect holds half as much of what it leaves. The cage, which turns in a sound bearing as well and stands by
    the lines of its races and balls, is not.

    Parameters
    ----------
    effects : sequence of Effect
        Those that compete, at their places.
    machine : Machine
    envelopes : sequence of Spectrum
        As of `envelopes_of`.
    lines : OrderLines, optional
        Of the same recordings: they say at which probe it is loudest.
    """
    found = [(rhythm(one, machine, envelopes), one) for one in that_strike(effects)]
    most = max((own.share for own, _ in found), default=0.0)
    if most < MOST:
        return None
    slow = {one for _, one in found if _is_slow(one, machine)}
    first = [own.share for own, one in found if one not in slow and own.share > AS_MUCH * most]
    best = max(first, default=most)
    own, effect = next(one for one in found if one[0].share == best)
    alike = [one.at for other, one in found if one.NAME == effect.NAME and other.share > 0.99 * best]
    rivals = [one for _, one in found if one.NAME != effect.NAME and one not in slow]
    new = [one for one in envelopes if one.news]
    among_new = rhythm(effect, machine, new).share
    sure = 2 * len(new) >= len(envelopes) and effect not in slow and among_new >= MOST
    sure = sure and _is_alone(effect, among_new, rivals, machine, new)
    where = _loudest(strongest_order(effect, machine, own.slip), lines) if lines else ""
    return Heard(effect, tuple(dict.fromkeys(alike)), own.share, own.slip, sure, where)


def _loudest(order: float, lines: OrderLines) -> str:
    """Return the probe at which a line of the envelope is larger than at all others by `CLEARLY_LOUDER`, or nothing."""
    heard = [k for k, kind in enumerate(lines.kinds) if kind.envelope and abs(lines.orders[k] - order) < NEAR * order]
    sizes = np.abs(np.where(lines.seen, from_scale(lines.amplitudes, lines.knees), 0.0))[..., heard]
    total = sizes.max(axis=2, initial=0.0).sum(axis=0)
    first, *others = np.argsort(-total)
    return lines.probes[first] if others and total[first] > CLEARLY_LOUDER * total[others[0]] else ""


def _is_slow(effect: Effect, machine: Machine) -> bool:
    """Return whether an effect beats less than once a turn of the shaft, as only what the cage does."""
    lines = effect.signature(machine)
    return bool(lines) and abs(lines[0].order) < 1


def _is_alone(
    effect: Effect, share: float, rivals: Sequence[Effect], machine: Machine, envelopes: Sequence[Spectrum]
) -> bool:
    """Return whether only this effect, and that at its own place only, holds what stands out."""
    left, lines = taken_by(effect, machine, envelopes)
    heard_in = [count for count in lines if count]
    if not heard_in or np.mean(heard_in) < LEAST_LINES:
        return False
    taken = [(one, np.isnan(rest.orders)) for one, rest in zip(envelopes, left, strict=True)]
    if max(float(one.power[held].max(initial=0.0)) for one, held in taken) < LOUD:
        return False
    others = [elsewhere(effect, machine, left), *(rhythm(one, machine, left).share for one in rivals)]
    return max(others) < FAINT * share

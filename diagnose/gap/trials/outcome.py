"""What came of one trial: the truth, the verdict and the time, as one line of JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from ....simulators.effect import effect_catalogue
from ..result import GapResult
from ..waveform import ONLY_IN_WAVEFORM
from .cases import TrialCase

#: Keys of the hypotheses without effects.
NOTHING, UNKNOWN = "nothing", "unknown"
TOLD_CAUSE = ("one cause", "several causes")


@dataclass(frozen=True)
class Truth:
    """An effect that was hidden: its name, part, values, and the d2 of its change."""

    effect: str
    at: str
    values: Mapping[str, float]
    d2: float


@dataclass(frozen=True)
class Named:
    """An effect that the engine named: parameters as [value, low, high] of the 90 % interval."""

    effect: str
    at: str
    probability: float
    parameters: Mapping[str, list[float]]


@dataclass(frozen=True)
class Outcome:
    """One trial's outcome.

    Attributes
    ----------
    number : int
    kind : str
        Of the case: "none", "one", "two" or "unknown".
    hidden : tuple of Truth
    d2 : float
        Of everything hidden together.
    imperfection : Truth, optional
    drift_d2 : float
    same_speeds : bool
    verdict : str
        Kind of the result; "error" when there is none.
    named : tuple of Named
    probabilities : mapping of str to float
        By hypothesis: names joined by "+", or `NOTHING`, or `UNKNOWN`.
    together : tuple of tuple of str
        Hypotheses that the result declares indistinguishable, written alike.
    gain_db, oracle_gain_db : float
        Held-out gain; NaN where there is none.
    seconds : float
        Of the engine, without the oracle.
    error : str
        Message of the error; empty without.
    """

    number: int
    kind: str
    hidden: tuple[Truth, ...]
    d2: float
    imperfection: Truth | None
    drift_d2: float
    same_speeds: bool
    verdict: str
    named: tuple[Named, ...] = ()
    probabilities: Mapping[str, float] = field(default_factory=dict)
    together: tuple[tuple[str, ...], ...] = ()
    gain_db: float = math.nan
    oracle_gain_db: float = math.nan
    seconds: float = math.nan
    error: str = ""

    @property
    def truth(self) -> str:
        """The right hypothesis: names joined by "+", `NOTHING` or `UNKNOWN`."""
        if self.kind == "unknown":
            return UNKNOWN
        return hypothesis(tuple(one.effect for one in self.hidden))

    @property
    def answer(self) -> str:
        """The hypothesis that the verdict states; "cannot tell" or "error" when it states none."""
        if self.verdict in TOLD_CAUSE:
            return hypothesis(tuple({one.effect for one in self.named}))
        return {"none": NOTHING, "unknown": UNKNOWN}.get(self.verdict, self.verdict)

    @property
    def declared(self) -> frozenset[str]:
        """The answer, and the hypotheses that the result cannot tell from it."""
        sets = [set(one) for one in self.together if self.answer in one]
        return frozenset({self.answer}.union(*sets))

    @property
    def is_right(self) -> bool:
        """Whether the truth is what was stated, or is in the declared set of a verdict that names a cause."""
        return self.truth == self.answer or (self.verdict in TOLD_CAUSE and self.truth in self.declared)


def hypothesis(names: tuple[str, ...]) -> str:
    """Return a hypothesis in words: its effects' names, sorted, joined by "+".

    Examples
    --------
    >>> hypothesis(("unbalance", "rub")), hypothesis(())
    ('rub+unbalance', 'nothing')
    """
    return "+".join(sorted(names)) or NOTHING


def outcome_of(
    case: TrialCase,
    result: GapResult | None,
    *,
    seconds: float,
    oracle_gain_db: float = math.nan,
    error: str = "",
) -> Outcome:
    """Return what came of a case; ``result`` is None when the engine failed with the message ``error``."""
    hidden = tuple(_truth(one) for one in case.hidden)
    weak = _truth(case.imperfection) if case.imperfection else None
    known = (case.number, case.kind, hidden, case.d2, weak, case.drift_d2, case.same_speeds)
    if result is None:
        return Outcome(*known, "error", seconds=seconds, error=error)
    named = tuple(
        Named(c.effect, c.at, c.probability, {k: [e.value, e.low, e.high] for k, e in c.parameters.items()})
        for c in result.causes
    )
    return Outcome(
        *known,
        result.kind,
        named,
        {hypothesis(names): p for names, p in result.probabilities.items()},
        _together(result),
        result.gain.held_out_db,
        oracle_gain_db,
        seconds,
    )


def _together(result: GapResult) -> tuple[tuple[str, ...], ...]:
    """Return what the result cannot tell apart; what the waveform shows beside the lines belongs to each of it."""
    shown = {cause.effect for cause in result.causes} & ONLY_IN_WAVEFORM
    return tuple(
        tuple(hypothesis(tuple((shown | set(one.split("+"))) - {NOTHING})) for one in together)
        for together in result.indistinguishable
    )


def _truth(hidden: Any) -> Truth:
    effect = hidden.effect
    return Truth(effect.NAME, effect.at, effect.values(), hidden.d2)


def to_line(outcome: Outcome) -> str:
    """Return an outcome as one line of JSON, without the newline."""
    return json.dumps(asdict(outcome))


def from_line(line: str) -> Outcome:
    """Return the outcome of a line that `to_line` made."""
    data = json.loads(line)
    weak = data["imperfection"]
    return Outcome(
        **{
            **data,
            "hidden": tuple(Truth(**one) for one in data["hidden"]),
            "imperfection": Truth(**weak) if weak else None,
            "named": tuple(Named(**one) for one in data["named"]),
            "together": tuple(tuple(one) for one in data["together"]),
        }
    )


def period_of(effect: str, parameter: str) -> float:
    """Return by how much a parameter of an effect can be changed without changing anything; infinity for no angle."""
    declared = {one.name: one for one in effect_catalogue()[effect].parameters()}
    is_angle = parameter in declared and declared[parameter].unit == "rad"
    return declared[parameter].period if is_angle else math.inf

"""How well causes were found: scores of a list of trial outcomes.

A trial is *right* when the verdict states the truth, or names a cause and declares the truth indistinguishable from it.
Trials in which the engine failed count as not right and as naming nothing.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from .outcome import NOTHING, TOLD_CAUSE, Outcome, period_of

#: Classes of detectability, by their lower ends.
CLASSES = (("below 20", 0.0, 20.0), ("20 to 100", 20.0, 100.0), ("100 and more", 100.0, math.inf))
#: A hidden effect below this changes nothing that could be seen; "nothing" is then right in the calibration.
INVISIBLE = 1.0
DETECTABLE = 20.0
STATED = 0.5
BINS = 10


@dataclass(frozen=True)
class Bin:
    """Top hypotheses of about equal probability: how many, what they stated on average, what share was right."""

    low: float
    high: float
    count: int
    stated: float
    right: float


@dataclass(frozen=True)
class Scores:
    """Scores of trials. Shares of nothing are NaN.

    Attributes
    ----------
    n : int
    top1 : float
        Share of single hidden effects rightly named.
    top1_by_d2 : dict
        The same by class of d2, as (count, share).
    named_wrong : float
        Share of trials with something hidden in which a wrong effect is named with a probability of 0.5 or more and
        the truth is not declared indistinguishable. The imperfection is not wrong.
    null_false_alarm : float
        Share of trials with nothing hidden whose verdict is a cause, or unknown.
    unknown_recall : float
        Share of trials with an effect outside the catalogue whose verdict is unknown.
    unknown_by_d2 : dict
    pair_exact, pair_any : float
        Share of pairs of which both effects are rightly named, and at least one.
    pair_by_d2 : dict
        Exact pairs, by the d2 of the weaker effect.
    calibration_error : float
        Sum over ten bins of the top hypothesis' probability of share of trials x |share right - mean probability|.
        Where what is hidden has a d2 below 1, "nothing" is right as well.
    reliability : tuple of Bin
    coverage90 : float
        Share of true values inside their 90 % intervals, of rightly named effects at the right part; angles count
        modulo their period.
    gain_db, oracle_gain_db : float
        Median held-out gain of trials with one or two hidden effects of d2 20 or more, and that of the engine that
        considers the true effects only.
    seconds_per_trial : float
        Mean.
    errors : int
    by_effect : dict
        For every effect hidden alone: n, top1, n and top1 for d2 of 100 or more, named_wrong, coverage90, gain_db.
    confusion : dict
        Count by (truth, answer).
    """

    n: int
    top1: float
    top1_by_d2: dict[str, tuple[int, float]]
    named_wrong: float
    null_false_alarm: float
    unknown_recall: float
    unknown_by_d2: dict[str, tuple[int, float]]
    pair_exact: float
    pair_any: float
    pair_by_d2: dict[str, tuple[int, float]]
    calibration_error: float
    reliability: tuple[Bin, ...]
    coverage90: float
    gain_db: float
    oracle_gain_db: float
    seconds_per_trial: float
    errors: int
    by_effect: dict[str, dict[str, Any]]
    confusion: dict[tuple[str, str], int]


def score(outcomes: Sequence[Outcome]) -> Scores:
    """Return the scores of trials."""
    single, pairs, nulls, unknown = (_of(outcomes, kind) for kind in ("one", "two", "none", "unknown"))
    bins = reliability(outcomes)
    visible = [one for one in (*single, *pairs) if one.d2 >= DETECTABLE]
    confusion: dict[tuple[str, str], int] = {}
    for one in outcomes:
        key = (one.truth, one.answer)
        confusion[key] = confusion.get(key, 0) + 1
    return Scores(
        n=len(outcomes),
        top1=share(single, lambda one: one.is_right),
        top1_by_d2=_by_class(single),
        named_wrong=share([*single, *pairs, *unknown], names_wrong),
        null_false_alarm=share(nulls, lambda one: one.verdict in (*TOLD_CAUSE, "unknown")),
        unknown_recall=share(unknown, lambda one: one.is_right),
        unknown_by_d2=_by_class(unknown),
        pair_exact=share(pairs, lambda one: one.is_right),
        pair_any=share(pairs, _names_one_of_two),
        pair_by_d2=_by_class(pairs),
        calibration_error=sum(b.count * abs(b.right - b.stated) for b in bins) / max(sum(b.count for b in bins), 1),
        reliability=bins,
        coverage90=coverage(outcomes),
        gain_db=_median([one.gain_db for one in visible]),
        oracle_gain_db=_median([one.oracle_gain_db for one in visible]),
        seconds_per_trial=_mean([one.seconds for one in outcomes]),
        errors=sum(one.verdict == "error" for one in outcomes),
        by_effect=_by_effect(single),
        confusion=confusion,
    )


def _of(outcomes: Sequence[Outcome], kind: str) -> list[Outcome]:
    return [one for one in outcomes if one.kind == kind]


def share(outcomes: Sequence[Outcome], is_so: Callable[[Outcome], bool]) -> float:
    """Return the share of outcomes for which something holds; NaN of none."""
    return sum(map(is_so, outcomes)) / len(outcomes) if outcomes else math.nan


def class_of(outcome: Outcome) -> str:
    """Return the class of an outcome's detectability: that of its weakest hidden effect."""
    d2 = min((one.d2 for one in outcome.hidden), default=0.0)
    return next(name for name, low, high in CLASSES if low <= d2 < high)


def _by_class(outcomes: Sequence[Outcome]) -> dict[str, tuple[int, float]]:
    found = {}
    for name, _, _ in CLASSES:
        own = [one for one in outcomes if class_of(one) == name]
        found[name] = (len(own), share(own, lambda one: one.is_right))
    return found


def names_wrong(outcome: Outcome) -> bool:
    """Return whether a wrong effect is named firmly and the truth is not declared indistinguishable.

    The imperfection acts in the records as well: to name it is no error.
    """
    if outcome.verdict in TOLD_CAUSE and outcome.truth in outcome.declared:
        return False
    right = set() if outcome.kind == "unknown" else {one.effect for one in outcome.hidden}
    right |= {outcome.imperfection.effect} if outcome.imperfection else set()
    return any(one.probability >= STATED and one.effect not in right for one in outcome.named)


def _names_one_of_two(outcome: Outcome) -> bool:
    hidden = {one.effect for one in outcome.hidden}
    stated = {name for one in outcome.declared for name in one.split("+")} if outcome.verdict in TOLD_CAUSE else set()
    return bool(hidden & stated)


def reliability(outcomes: Sequence[Outcome]) -> tuple[Bin, ...]:
    """Return ten bins of the top hypothesis' probability; trials without probabilities do not count."""
    found: list[list[tuple[float, bool]]] = [[] for _ in range(BINS)]
    for one in outcomes:
        if not one.probabilities:
            continue
        top = max(one.probabilities, key=lambda name: one.probabilities[name])
        right = top == one.truth or (top == NOTHING and one.d2 < INVISIBLE)
        stated = one.probabilities[top]
        found[min(int(stated * BINS), BINS - 1)].append((stated, right))
    return tuple(
        Bin(k / BINS, (k + 1) / BINS, len(own), _mean([p for p, _ in own]), _mean([float(r) for _, r in own]))
        if own
        else Bin(k / BINS, (k + 1) / BINS, 0, 0.0, 0.0)
        for k, own in enumerate(found)
    )


def coverage(outcomes: Sequence[Outcome]) -> float:
    """Return the share of true values inside their 90 % intervals; NaN when there is none."""
    inside = []
    for one in outcomes:
        if one.kind not in ("one", "two"):
            continue
        for truth in one.hidden:
            for named in one.named:
                if (named.effect, named.at) == (truth.effect, truth.at):
                    inside += [
                        _lies_in(truth.values[name], low, high, period_of(truth.effect, name))
                        for name, (_, low, high) in named.parameters.items()
                        if name in truth.values
                    ]
    return _mean([float(lies) for lies in inside])


def _lies_in(value: float, low: float, high: float, period: float) -> bool:
    if math.isinf(period):
        return low <= value <= high
    return (value - low) % period <= high - low


def _by_effect(single: Sequence[Outcome]) -> dict[str, dict[str, Any]]:
    found = {}
    for name in sorted({one.hidden[0].effect for one in single}):
        own = [one for one in single if one.hidden[0].effect == name]
        clear = [one for one in own if class_of(one) == CLASSES[-1][0]]
        found[name] = {
            "n": len(own),
            "top1": share(own, lambda one: one.is_right),
            "n_clear": len(clear),
            "top1_clear": share(clear, lambda one: one.is_right),
            "named_wrong": share(own, names_wrong),
            "coverage90": coverage(own),
            "gain_db": _median([one.gain_db for one in own]),
            "seconds_per_trial": _mean([one.seconds for one in own]),
        }
    return found


def _finite(values: Sequence[float]) -> list[float]:
    return [value for value in values if math.isfinite(value)]


def _mean(values: Sequence[float]) -> float:
    return statistics.fmean(_finite(values)) if _finite(values) else math.nan


def _median(values: Sequence[float]) -> float:
    return statistics.median(_finite(values)) if _finite(values) else math.nan


def as_json(scores: Scores) -> dict[str, Any]:
    """Return the scores as JSON data; NaN becomes null, counts and shares by class become objects."""
    data: dict[str, Any] = {name: getattr(scores, name) for name in Scores.__dataclass_fields__}
    for name in ("top1_by_d2", "unknown_by_d2", "pair_by_d2"):
        data[name] = {label: {"n": count, "share": value} for label, (count, value) in data[name].items()}
    data["reliability"] = [vars(one) for one in scores.reliability]
    data["confusion"] = [
        {"truth": truth, "answer": answer, "n": count} for (truth, answer), count in sorted(scores.confusion.items())
    ]
    return _without_nan(data)


def _without_nan(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _without_nan(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_without_nan(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data

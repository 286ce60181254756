"""A result in plain words: the verdict as sentences, values with intervals, and the whole for a terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from .result import AS_GOOD_DB, AddedForce, Cause, Estimate, Gain, GapResult, ResidualLine
from .waveform import ONLY_IN_WAVEFORM

if TYPE_CHECKING:
    from ...simulators.machine import Machine
    from .lines import Condition, OrderLines

#: A line counts as wrong from this many standard deviations on: a few hundred lines are compared at a time.
NOTABLE_SIGMA = 4.0
#: An amplitude that differs by less than this factor is right; what is wrong then is the phase.
ALIKE = 1.2
_WRONG = ("lacks", "has too much", "gets the size wrong of", "gets the phase wrong of")
#: Of an amplitude beside another one: less is what numbers leave.
ROUNDING = 1e-9
#: Orders and conditions that a sentence names.
MOST_NAMED = 4
_NO_LINE = "No line by itself differs from the model"
#: Sidebands of a mesh line are named after it up to this distance.
_MOST_SIDEBANDS = 3
_SCALES = {
    "m": ((1e-3, 1e6, "um"), (1.0, 1e3, "mm")),
    "m/s": ((1.0, 1e3, "mm/s"),),
    "rad": ((1e-3, 1e6, "urad"), (1.0, 1e3, "mrad")),
}


def verdict_words(result: GapResult) -> str:
    """Return the verdict in sentences: the gap, the cause, what stays open, the gain."""
    fitted = [c for i, c in enumerate(result.measured.conditions) if i not in result.gain.held_out]
    said = gap_words(result.residuals, result.measured, result.machine, whole=len(fitted))
    if said.startswith(_NO_LINE) and any(one.effect not in ONLY_IN_WAVEFORM for one in result.causes):
        said += " Together they do."
    parts = [said, headline(result)]
    forces = force_words(result)
    parts.append(f"Added, without a cause: {'; '.join(forces)}." if forces else "")
    parts.append(open_words(result))
    parts.append(gain_words(result.gain) if result.kind not in ("none", "cannot tell") else "")
    return " ".join(filter(None, parts))


def sentence_of(result: GapResult) -> str:
    """Return the verdict that the result states, or the one made from its parts when it states none."""
    return result.sentence or verdict_words(result)


def gap_words(residuals: Sequence[ResidualLine], measured: OrderLines, machine: Machine, *, whole: int) -> str:
    """Return which lines the machine without any effect gets wrong, and where; the clearest lines first.

    Parameters
    ----------
    residuals : sequence of ResidualLine
    measured : OrderLines
        In all conditions.
    machine : Machine
    whole : int
        Number of conditions from which lines can be wrong: those that are not held out.
    """
    wrong = [line for line in residuals if line.sigma >= NOTABLE_SIGMA]
    if not wrong:
        return f"{_NO_LINE} by {NOTABLE_SIGMA:g} standard deviations."
    names_of = line_names(measured, mesh_orders(machine))
    clearest = list(dict.fromkeys(line.column for line in sorted(wrong, key=lambda one: -one.sigma)))
    kinds: dict[str, list[str]] = {name: [] for name in _WRONG}
    for column in clearest[:MOST_NAMED]:
        kinds[_how_wrong([line for line in wrong if line.column == column])].append(names_of[column])
    what = joined_words([f"{verb} {joined_words(names)}" for verb, names in kinds.items() if names])
    more = len(clearest) - MOST_NAMED
    also = f"; {more} more {'lines are' if more > 1 else 'line is'} wrong" if more > 0 else ""
    where = sorted({line.condition for line in wrong})
    return f"{_where_words([measured.conditions[i] for i in where], whole)} the model {what}{also}."


def _how_wrong(lines: Sequence[ResidualLine]) -> str:
    # Each line counts alike: near a resonance one would decide for all.
    sizes = [(abs(line.measured), abs(line.simulated)) for line in lines]
    measured = math.sqrt(sum((own / max(own, other, 1e-300)) ** 2 for own, other in sizes))
    simulated = math.sqrt(sum((other / max(own, other, 1e-300)) ** 2 for own, other in sizes))
    if measured > ALIKE * simulated:
        return "lacks"
    if simulated > ALIKE * measured:
        return "has too much"
    # Too much in one condition and too little in another, or right in size.
    apart = sorted(max(own, other, 1e-300) / max(min(own, other), 1e-300) for own, other in sizes)
    return "gets the size wrong of" if apart[len(apart) // 2] > ALIKE else "gets the phase wrong of"


def _where_words(where: Sequence[Condition], whole: int) -> str:
    if len(where) >= whole > 1:
        return f"In all {len(where)} fitted conditions"
    loaded = len({one.load for one in where}) > 1
    speeds = [f"{one.speed_rpm:.0f}" for one in where]
    if loaded or len(where) > MOST_NAMED:
        named = joined_words([str(one) for one in where]) if len(where) <= MOST_NAMED else ""
        return f"At {named}" if named else f"In {len(where)} of {whole} conditions"
    return f"At {joined_words(list(dict.fromkeys(speeds)))} rpm"


def headline(result: GapResult) -> str:
    """Return the verdict in one sentence."""
    none = probability_words(result.probabilities.get((), math.nan))
    if result.kind == "none":
        return f"The model explains the data, probability {none}: no effect is needed."
    if result.kind == "unknown":
        stated = probability_words(sum(p for names, p in result.probabilities.items() if "unknown" in names))
        where = f", clearest in {_place_words(result)}" if result.residuals else ""
        where = f", seen in the waveform of {joined_words(list(result.flawed))}" if result.flawed else where
        shown = joined_words([cause_words(one) for one in result.causes if one.effect in ONLY_IN_WAVEFORM])
        also = f" The waveform shows {shown} as well." if shown else ""
        fitted = [one for one in result.causes if one.effect not in ONLY_IN_WAVEFORM]
        named = [f"{cause_words(one)}, probability {probability_words(one.probability)}" for one in fitted]
        if named:
            return f"Cause of a part: {'; and '.join(named)}. Beside it something acts that no effect explains.{also}"
        return f"Something acts that no effect of the catalogue explains{where}, probability {stated}.{also}"
    if result.kind == "cannot tell":
        best = [(names, p) for names, p in result.probabilities.items() if p >= 0.01][:3]
        words = [f"{hypothesis_words(names)} {probability_words(p)}" for names, p in best]
        return f"These data cannot tell why: {', '.join(words)}." if words else "These data cannot tell why."
    named = [f"{cause_words(one)}, probability {probability_words(one.probability)}" for one in result.causes]
    return f"{'Cause' if len(named) == 1 else 'Causes'}: {'; and '.join(named)}."


def _place_words(result: GapResult) -> str:
    """Return the line, the probe and the condition of the largest residual."""
    largest = max(result.residuals, key=lambda line: line.sigma)
    line = line_names(result.measured, mesh_orders(result.machine))[largest.column]
    return f"{line} at {largest.probe} and {result.measured.conditions[largest.condition]}"


def force_words(result: GapResult) -> list[str]:
    """Return what was added for what no effect explains, one text for the forces of an order at a place.

    "force at 1X on rotor_2, x 82.5 N (73 to 92) and y 83 N (73 to 93) at 972 rpm, growing as speed^2.0 (1.8 to 2.2)"
    """
    gears = mesh_orders(result.machine)
    groups: dict[tuple[float, str], list[AddedForce]] = {}
    for one in result.empirical:
        groups.setdefault((one.order, one.at), []).append(one)
    return [_group_words(line_words(order, gears), at, forces) for (order, at), forces in groups.items()]


def _group_words(line: str, at: str, forces: Sequence[AddedForce]) -> str:
    first = forces[0]
    what = "torque" if first.direction == "torsion" else "force"
    sizes = joined_words([f"{one.direction} {estimate_words(one.amplitude)}" for one in forces])
    place = f"{at} (or {joined_words(first.or_at, last='or')})" if first.or_at else at
    laws = [_law_words("speed", first.speed_exponent)]
    here = f"{first.reference_speed_rpm:.0f} rpm"
    if first.load_exponent is not None and first.reference_load is not None:
        laws.append(_law_words("load", first.load_exponent))
        here += f" and load {first.reference_load:g}"
    return f"{what} at {line} on {place}, {sizes} at {here}, growing as {joined_words(laws)}"


def _law_words(name: str, exponent: Estimate) -> str:
    value, low, high = (round(one, 1) + 0.0 for one in (exponent.value, exponent.low, exponent.high))
    return f"{name}^{value:.1f} ({low:.1f} to {high:.1f})"


def cause_words(cause: Cause) -> str:
    """Return an effect with its place and the first value that is told: "unbalance at disc, moment 112 um (90 to 130)".

    The name alone where the data tell none.
    """
    name = cause.effect.replace("_", " ") + (f" at {cause.at}" if cause.at else "")
    first = next((item for item in cause.parameters.items() if item[1].is_told), None)
    return f"{name}, {parameter_label(first[0], first[1].unit)} {estimate_words(first[1])}" if first else name


def alternative_words(causes: Sequence[Cause]) -> str:
    """Return a hypothesis that is not told apart from the one in front, with all values that the data tell."""
    said = []
    for one in causes:
        place = f" at {one.at}" if one.at else ""
        told = [(name, own) for name, own in one.parameters.items() if own.is_told]
        values = [f"{parameter_label(name, own.unit)} {estimate_words(own)}" for name, own in told]
        said.append(", ".join([f"{_spaced(one.effect)}{place}", *values]))
    return f"Not told apart: it may as well be {'; and '.join(said)}."


def open_words(result: GapResult) -> str:
    """Return what these data cannot tell apart and what to record next; empty when nothing is open."""
    sets = [joined_words([_spaced(one) for one in names], last="or") for names in result.indistinguishable]
    parts = [f"Not distinguishable here: {'; '.join(sets)}."] if sets else []
    if result.next_measurement:
        parts.append(f"To tell: {_sentence(result.next_measurement)}")
    return " ".join(parts)


def gain_words(gain: Gain) -> str:
    """Return the gain on conditions that were not fitted, against calibration and placebos."""
    if not math.isfinite(gain.held_out_db):
        return "No gain was computed."
    verb = "falls" if gain.held_out_db >= 0 else "rises"
    what = "Held-out error" if gain.held_out else "The error in the fitted conditions (none was held out)"
    words = f"{what} {verb} by {decibel_words(abs(gain.held_out_db))}"
    if math.isfinite(gain.calibration_only_db):
        words += f"; calibration alone gives {decibel_words(gain.calibration_only_db)}"
    rivals = {"calibration alone": gain.calibration_only_db, **placebos(gain)}
    better = [name for name, value in rivals.items() if value >= gain.held_out_db - AS_GOOD_DB]
    if better:
        words += f"; no gain is claimed, as {joined_words(better)} {'do' if len(better) > 1 else 'does'} as well"
    return words + "."


def decibel_words(value: float) -> str:
    """Return a level to a tenth of a decibel, without a minus before zero.

    Examples
    --------
    >>> decibel_words(-0.01)
    '0.0 dB'
    """
    return f"{round(value, 1) + 0.0:.1f} dB"


def placebos(gain: Gain) -> dict[str, float]:
    """Return the gains, in dB, of what should not help, where computed."""
    found = {"the best wrong effect": gain.wrong_effect_db, "a smooth function of speed": gain.smooth_function_db}
    return {name: value for name, value in found.items() if math.isfinite(value)}


def hypothesis_words(names: Sequence[str]) -> str:
    """Return a hypothesis in words.

    Examples
    --------
    >>> hypothesis_words(()), hypothesis_words(("shaft_bow", "unbalance"))
    ('nothing is wrong', 'shaft bow + unbalance')
    """
    said = ["something outside the catalogue" if name == "unknown" else name.replace("_", " ") for name in names]
    return " + ".join(said) or "nothing is wrong"


def line_words(order: float, gears: Sequence[float] = ()) -> str:
    """Return the name of a line: by the shaft's order, or by the tooth mesh that it belongs to.

    Examples
    --------
    >>> line_words(2.0), line_words(0.5), line_words(45.0, [23.0])
    ('2X', '0.5X', '2 mesh - 1X')
    """
    for mesh in gears:
        multiple = round(order / mesh)
        side = order - multiple * mesh
        if multiple >= 1 and mesh > 2 * _MOST_SIDEBANDS and abs(side) <= _MOST_SIDEBANDS + 1e-6:
            name = "mesh" if multiple == 1 else f"{multiple} mesh"
            return name if abs(side) < 1e-6 else f"{name} {'+' if side > 0 else '-'} {abs(side):.4g}X"
    return f"{order:.4g}X"


def line_names(lines: OrderLines, gears: Sequence[float] = ()) -> list[str]:
    """Return the name of each line: "2X", "100 Hz", "1X + 5 Hz", "envelope, 2.95X"."""
    return [
        ("envelope, " if kind.envelope else "") + _place_in_spectrum(order, kind.frequency_hz, gears)
        for order, kind in zip(lines.orders, lines.kinds, strict=True)
    ]


def _place_in_spectrum(order: float, frequency_hz: float, gears: Sequence[float]) -> str:
    if not frequency_hz:
        return line_words(order, gears)
    if not order:
        return f"{abs(frequency_hz):.4g} Hz"
    return f"{line_words(order, gears)} {'+' if frequency_hz > 0 else '-'} {abs(frequency_hz):.4g} Hz"


def mesh_orders(machine: Machine) -> list[float]:
    """Return the tooth-mesh orders of the machine's gear pairs."""
    parts = machine.bare_assembly().components.values()
    return [float(part.mesh_order) for part in parts if hasattr(part, "mesh_order")]  # type: ignore[attr-defined]


def parameter_label(name: str, unit: str) -> str:
    """Return a parameter's name without the unit that it ends in.

    Examples
    --------
    >>> parameter_label("moment_kg_m", "kg.m"), parameter_label("load_share", "")
    ('moment', 'load share')
    """
    suffix = "_" + unit.replace(".", "_").replace("/", "_").replace("^", "").lower() if unit else ""
    bare = name[: -len(suffix)] if suffix and name.lower().endswith(suffix) else name
    return (bare or name).replace("_", " ")


def estimate_words(estimate: Estimate) -> str:
    """Return a value with its unit and 90 % interval in a readable unit.

    Examples
    --------
    >>> estimate_words(Estimate(5e-4, 4e-4, 6.2e-4, "m"))
    '500 um (400 to 620)'
    >>> estimate_words(Estimate(0.01, 0.001, 0.02, "", is_told=False))
    'not told by these data (0.001 to 0.02 possible)'
    """
    factor, unit = _unit_of(estimate)
    ends = f"{factor * estimate.low:.3g} to {factor * estimate.high:.3g}"
    if not estimate.is_told:
        return f"not told by these data ({ends}{' ' + unit if unit else ''} possible)"
    return f"{value_words(estimate.value, estimate)} ({ends})"


def value_words(value: float, estimate: Estimate) -> str:
    """Return a value of the estimated parameter in the unit in which the estimate is printed.

    Examples
    --------
    >>> value_words(4.5e-4, Estimate(5e-4, 4e-4, 6.2e-4, "m"))
    '450 um'
    """
    factor, unit = _unit_of(estimate)
    return f"{factor * value:.3g} {unit}".rstrip()


def _unit_of(estimate: Estimate) -> tuple[float, str]:
    # Parameters in rad are angles between parts; those of probes are small motions.
    if estimate.unit == "rad":
        return 180 / math.pi, "deg"
    return readable_unit(estimate.unit, largest=max(map(abs, (estimate.value, estimate.low, estimate.high))))


def amplitude_words(value: float, unit: str, *, beside: float = 0.0) -> str:
    """Return an amplitude in a readable unit; "0" where it is only rounding beside another one.

    Examples
    --------
    >>> amplitude_words(1.25e-5, "m")
    '12.5 um'
    >>> amplitude_words(1.25e-19, "m", beside=1e-6)
    '0'
    """
    if value < ROUNDING * beside:
        return "0"
    factor, name = readable_unit(unit, largest=abs(value))
    return f"{factor * value:.3g} {name}".rstrip()


def readable_unit(unit: str, *, largest: float) -> tuple[float, str]:
    """Return the factor to the unit in which a quantity of this size is read, and that unit."""
    for limit, factor, name in _SCALES.get(unit, ()):
        if largest < limit:
            return factor, name
    return 1.0, unit


def probability_words(probability: float) -> str:
    """Return a probability that is never rounded to certainty.

    Examples
    --------
    >>> probability_words(0.97), probability_words(0.9999), probability_words(0.0001)
    ('0.97', 'over 0.99', 'below 0.01')
    """
    if not math.isfinite(probability):
        return "unknown"
    if 0 < probability < 0.01:
        return "below 0.01"
    return "over 0.99" if probability > 0.99 else f"{probability:.2f}"


def joined_words(items: Sequence[str], *, last: str = "and") -> str:
    """Return a list in words.

    Examples
    --------
    >>> joined_words(["1X", "2X", "3X"])
    '1X, 2X and 3X'
    """
    return f" {last} ".join(filter(None, [", ".join(items[:-1]), *items[-1:]]))


def not_compared_words(not_compared: Mapping[str, str]) -> list[str]:
    """Return one sentence a reason, with the effects that were left out for it."""
    reasons: dict[str, list[str]] = {}
    for effect, reason in not_compared.items():
        reasons.setdefault(reason.rstrip("."), []).append(effect.replace("_", " "))
    return [f"{', '.join(names)}: {reason}." for reason, names in reasons.items()]


def _spaced(names: str) -> str:
    if names == "unknown":
        return "something outside the catalogue"
    return names.replace("_", " ").replace("+", " + ")


def _sentence(text: str) -> str:
    bare = text.strip()
    return bare if bare.endswith((".", "!", "?")) else f"{bare}."

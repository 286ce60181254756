"""From the posterior to the answer: kind, causes, what cannot be told apart, what to measure next."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...simulators.effect import effect_catalogue
from ...simulators.machine import Machine
from .changed_transfer import changed_words
from .closest import NEARLY_ALL, closest, closest_words
from .coordinates import values_at
from .empirical import AddedForce, as_effect
from .evidence import Comparison
from .form_words import form_words
from .gain import explained
from .judged import judged
from .located import located_words
from .loose_contact import spikes_words
from .mirrored import with_mirror_images
from .model_form import form_of
from .next_measurement import next_measurement
from .one_line import one_line_words, told_by_one_line
from .opposing import not_named_words, opposing_words
from .plateaus import on_plateaus
from .posterior import Posterior
from .prediction import score_of, score_of_unknown
from .refine import Fit
from .result import Cause, Estimate, Gain, GapResult, ResidualLine, Score
from .shown_lines import sigmas
from .size_scale import from_scale, in_units
from .slow_sway import sway_words
from .stretched import stretched_words
from .tuned import SAME, in_band
from .unseen_weight import weight_words
from .unsteady import channels_of, unsteady_words
from .wanted_lines import is_locked
from .waveform import SUSPECTED, accounts_for_lines
from .within_law import loose_law_words
from .words import alternative_words

if TYPE_CHECKING:
    from .heard_rhythm import Heard
    from .prepared import Prepared

MOST_RESIDUALS = 40
#: Probability of an effect that the waveform shows: the data checks' own false alarms are left to it.
SEEN = 0.98


def told(
    machine: Machine,
    prepared: Prepared,
    posterior: Posterior,
    not_compared: Mapping[str, str],
    gain: Gain,
    forces: Sequence[AddedForce],
    remarks: Sequence[str],
    heard: Heard | None = None,
) -> GapResult:
    """Return the whole answer; ``forces`` are added for what is unknown, ``remarks`` say what they leave out."""
    posterior, flawed = _with_flaws(posterior, prepared)
    kind, names, together = judged(posterior.probabilities)
    # A suspicion is a cause only where nothing else is, and the healthy machine's records do not raise it.
    suspects = kind == "none" and prepared.healthy is not None
    shown = {name: own for name, own in prepared.waveform.items() if suspects or name not in SUSPECTED}
    best = _named(posterior, prepared)
    compared = posterior.compared
    calibrated = prepared.baseline.machine
    everything = prepared.problem(range(len(prepared.measured.conditions)))
    expected = everything.plain().expected
    causes = _causes(best, posterior.probabilities, calibrated)
    probabilities = dict(posterior.probabilities)
    if shown:
        kind, causes, probabilities = _seen_as_well(kind, causes, probabilities, shown, prepared)
    if heard and not any(one.effect == heard.effect.NAME for one in causes):
        remarks = (*remarks, heard.words)
        kind, causes, probabilities = heard.added(kind, causes, probabilities)
    causes, probabilities, other, to_tell = told_by_one_line(best, causes, probabilities)
    alike = (*("+".join(one) or "nothing" for one in together), *other)
    rivals = _rivals(posterior, [one for one in together if one != names])
    aside = _on_records(prepared, shown, kind)
    own = _own_remarks(posterior, prepared, best, rivals, nameless=kind == "unknown" and not best.candidates)
    added = tuple(as_effect(one) for one in forces)
    form = form_of(prepared.form) if prepared.form else None
    after = explained(best, everything, further=added)
    return GapResult(
        kind=kind,
        causes=causes,
        probabilities=probabilities,
        indistinguishable=(alike,) if len(alike) > 1 else (),
        next_measurement=next_measurement(kind, best, rivals, prepared) or to_tell,
        sentence="",
        residuals=_residuals(compared, prepared.fitted),
        gain=gain,
        detectability=compared.detectability(best.response) if best.candidates else _size(compared),
        misfit=posterior.misfit,
        measured=in_units(prepared.measured),
        before=from_scale(expected, prepared.measured.knees),
        after=from_scale(after, prepared.measured.knees),
        machine=machine,
        calibrated=calibrated,
        extended=best.machine(best.problem.baseline.machine if best.problem else calibrated).with_effects(*added),
        not_compared=dict(not_compared),
        remarks=(*filter(None, [form_words(form)]), *own, *remarks, *aside),
        empirical=tuple(forces),
        scores=_scores(posterior),
        flawed=flawed,
        form=form,
    )


def _seen_as_well(
    kind: str,
    causes: tuple[Cause, ...],
    probabilities: Mapping[tuple[str, ...], float],
    shown: Mapping[str, tuple[str, ...]],
    prepared: Prepared,
) -> tuple[str, tuple[Cause, ...], dict[tuple[str, ...], float]]:
    """Return kind, causes and hypotheses with what the waveform shows, which may account for unknown lines."""
    causes = (*_shown(shown), *causes)
    accounted = accounts_for_lines(shown, prepared.measured.probes, mended=prepared.mended)
    beyond = kind == "unknown" and not accounted
    if not beyond:
        kind = "one cause" if len(causes) == 1 else "several causes"
    return kind, causes, _with_shown(probabilities, tuple(shown), is_unknown_beside=beyond)


def _with_flaws(posterior: Posterior, prepared: Prepared) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior, and the channels that show what no effect makes; then it is hardly nothing."""
    flawed = prepared.flawed
    if not flawed and judged(posterior.probabilities)[0] in ("none", "cannot tell"):
        flawed = channels_of(prepared.unsteady, prepared.waveform)
        flawed = tuple(dict.fromkeys((*flawed, *(one.channel for one in (*prepared.transfers, *prepared.sways)))))
    if not flawed:
        return posterior, ()
    return replace(posterior, probabilities=_not_nothing(posterior.probabilities)), flawed


def _named(posterior: Posterior, prepared: Prepared) -> Fit:
    """Return the fit that is named, with what its slopes do not tell of its angles."""
    problem = prepared.problem(prepared.fitted)
    return with_mirror_images(on_plateaus(posterior.named, problem), problem)


def _scores(posterior: Posterior) -> dict[tuple[str, ...], Score]:
    """Return the figures of the best fit of each hypothesis."""
    compared = posterior.compared
    found = {("unknown",): score_of_unknown(posterior.unknown, compared), (): score_of(posterior.none, compared)}
    for fit in sorted(posterior.fits, key=lambda one: -one.log_evidence):
        if fit.names not in found:
            found[fit.names] = score_of(fit, compared)
    seen = posterior.held_out
    return {
        names: replace(one, log_held_out=seen[names].log_density) if names in seen else one
        for names, one in found.items()
    }


def _rivals(posterior: Posterior, others: Sequence[tuple[str, ...]]) -> list[Fit]:
    """Return the best fit of each hypothesis, where it was fitted."""
    fitted = {fit.names for fit in (*posterior.fits, posterior.none)}
    return [posterior.best(other) for other in others if other in fitted]


def _own_remarks(
    posterior: Posterior, prepared: Prepared, best: Fit, rivals: Sequence[Fit], *, nameless: bool
) -> list[str]:
    """Return what comes close, what may as well be the cause, and what speaks against the causes in front.

    ``nameless`` says that something unknown is the answer, with no effect beside it.
    """
    here, said = prepared.problem(prepared.fitted), []
    if nameless and posterior.opposed:
        pair = posterior.opposed[0]
        said.append(stretched_words(pair, here) or not_named_words(pair, here))
    elif nameless:
        # Where a known effect explains nearly all, a force at one place would be another story.
        if closest(posterior.fits, posterior.none)[1] <= NEARLY_ALL:
            said += located_words(posterior.compared, posterior.unknown, here.baseline.machine, here.predictor)
        said += closest_words(posterior.fits, posterior.none)
    for rival in rivals:
        if rival.candidates:
            said.append(alternative_words(_causes(rival, posterior.probabilities, prepared.baseline.machine)))
    said += weight_words(best)
    said += loose_law_words(best, posterior.unknown.log_evidence)
    return [*said, *opposing_words(best, here), *one_line_words(best), *_pulse(prepared.pulse_rad)]


def _pulse(angle_rad: float) -> tuple[str, ...]:
    if not angle_rad:
        return ()
    return (
        f"The tacho's pulse comes when the model has turned by {math.degrees(angle_rad):.0f} deg, say the healthy "
        "recordings. Angles on the shaft are counted from the model's zero; add this to count from the pulse.",
    )


def _on_records(prepared: Prepared, shown: Mapping[str, tuple[str, ...]], kind: str) -> list[str]:
    """Return what the records say beside their lines; ``shown`` is told as a cause."""
    said = [_suspicion(name, own) for name, own in prepared.waveform.items() if name not in shown]
    said += unsteady_words(prepared.unsteady) if kind == "unknown" else ()
    return [*said, *changed_words(prepared.transfers), *sway_words(prepared.sways), *spikes_words(prepared.spikes)]


def _suspicion(name: str, channels: Sequence[str]) -> str:
    where = ", ".join(channels)
    return f"{where}: the spectrum is strongest at the end of its band; {name} is possible. Was there a filter?"


def _with_shown(
    probabilities: Mapping[tuple[str, ...], float], shown: tuple[str, ...], *, is_unknown_beside: bool = False
) -> dict[tuple[str, ...], float]:
    """Return the hypotheses with what the waveform shows, which may itself be what leaves lines unexplained."""
    total: dict[tuple[str, ...], float] = {}
    for names, share in probabilities.items():
        key = tuple(sorted((*shown, *(name for name in names if name != "unknown"))))
        if "unknown" in names and is_unknown_beside:
            key = names
        total[key] = total.get(key, 0.0) + share
    return dict(sorted(total.items(), key=lambda item: -item[1]))


def _not_nothing(probabilities: Mapping[tuple[str, ...], float]) -> dict[tuple[str, ...], float]:
    """Return the hypotheses where the waveform shows what none of them makes: nothing is wrong with the lines only."""
    moved = dict(probabilities)
    share = SEEN * moved.get((), 0.0)
    moved[()] = moved.get((), 0.0) - share
    moved["unknown",] = moved.get(("unknown",), 0.0) + share
    return dict(sorted(moved.items(), key=lambda item: -item[1]))


def _shown(waveform: Mapping[str, tuple[str, ...]]) -> tuple[Cause, ...]:
    catalogue = effect_catalogue()
    return tuple(
        Cause(name, channels[0] if channels else "", SEEN, {}, catalogue[name].CHECK)
        for name, channels in waveform.items()
    )


def _causes(best: Fit, probabilities: Mapping[tuple[str, ...], float], machine: Machine) -> tuple[Cause, ...]:
    found, start = [], 0
    for candidate in best.candidates:
        stop = start + len(candidate.coordinates)
        values = values_at(candidate.coordinates, best.position[start:stop])
        # Sizes of lines tell nothing of a phase.
        stated = candidate.at(best.position[start:stop]).signature(machine)
        has_phase = not stated or any(is_locked(line) for line in stated)
        estimates = {}
        for number in range(start, stop):
            parameter = best.coordinates[number].parameter
            anywhere = best.coordinates[number].is_angle and not has_phase
            told = best.tells(number) and not anywhere
            low, high = (-parameter.period / 2, parameter.period / 2) if anywhere else best.interval(number)
            alike = in_band(candidate.at(best.position[start:stop]), machine, parameter.name)
            low, high = (min(low, alike[0]), max(high, alike[1])) if alike else (low, high)
            estimates[parameter.name] = Estimate(values[parameter.name], low, high, parameter.unit, told)
        for one in candidate.effect.parameters():
            if one.name in candidate.placed:
                value = candidate.effect.values()[one.name]
                estimates[one.name] = Estimate(value, (1 - SAME) * value, (1 + SAME) * value, one.unit)
        share = sum(p for names, p in probabilities.items() if candidate.name in names)
        found.append(Cause(candidate.name, candidate.effect.at, share, estimates, candidate.effect.CHECK))
        start = stop
    return tuple(sorted(found, key=lambda cause: -cause.probability))


def _residuals(compared: Comparison, conditions: Sequence[int]) -> tuple[ResidualLine, ...]:
    lines = compared.lines
    size = sigmas(compared)
    measured, simulated = (from_scale(own, lines.knees) for own in (lines.amplitudes, compared.expected))
    found = []
    for flat in np.argsort(size, axis=None)[::-1][:MOST_RESIDUALS]:
        c, p, k = (int(i) for i in np.unravel_index(int(flat), size.shape))
        if not lines.seen[c, p, k]:
            continue
        order = lines.kinds[k].order_at(lines.orders[k], lines.conditions[c].speed_rpm)
        seen = complex(measured[c, p, k]), complex(simulated[c, p, k])
        found.append(ResidualLine(lines.probes[p], order, conditions[c], k, *seen, float(size[c, p, k])))
    return tuple(found)


def _size(compared: Comparison) -> float:
    """Return how much the squared residual exceeds that of noise."""
    return max(float(compared.residual @ compared.residual) - compared.residual.size, 0.0)

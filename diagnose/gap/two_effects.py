"""Two effects together: partners of the best single ones, where the second explains clearly more.

A partner is judged by what the first effect cannot make up for: by its own values and by an error of its law. An effect
that changes the structure acts on what the first one makes as well, so that its responses are computed beside it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from .climb import FIRST_STEPS, climbed, laws_of
from .evidence import Comparison, Problem, Widened
from .first_look import in_the_middle
from .joint_fit import jointly
from .null_distribution import chance_of_residual
from .refine import Fit, nothing, refined
from .responses import Responses
from .screen import Start, atoms_of
from .screening import FAR_BEHIND, TIMES_WORSE, Screening, few_of_each
from .shown_lines import CLEAR
from .struck_rhythm import that_strike
from .within_law import PAIR_MARGIN, pair_level

#: Partners that are tried of the best single effect, and of the second best.
PARTNERS = (6, 3)
#: Of the best one, where the two together are simulated in time.
PARTNERS_IN_TIME = 2
#: The machine's own unknowns are moved so often for hypotheses whose evidence is this close to the best.
MOVES, CLOSE = 5, 30.0
#: Pairs that are compared with the machine re-fitted beside them.
JOINT = 3
#: What leaves more than this share of what differs, where clearly something does, is not followed any further.
LITTLE, CLEARLY = 0.5, 200.0
#: Chance below which what an effect leaves is more than noise.
MISFIT = 1e-3
#: A single effect whose residual has this chance needs no partner, but where one is clearly better.
EXPLAINED = 0.3
#: By so many of its standard deviations what noise leaves of a squared residual may lie below its mean.
LEAST_NOISE = 2.0
#: Beside a single effect that leaves only noise, no pair is built on one with so much less evidence: at best it would
#: explain as much, with more values. Nor are pairs with a contact fitted further that are so far behind something
#: unknown.
OVERTAKEN = 100.0
#: Starts of each pair, and of one that is simulated in time.
STARTS, STARTS_IN_TIME = 2, 1

Tell = Callable[[str], None]


def two_effects(
    singles: Sequence[Fit],
    screening: Screening,
    problem: Problem,
    none: Fit,
    unknown: float,
    tell: Tell = lambda _: None,
) -> list[Fit]:
    """Return the fits of two effects that have clearly more evidence than the best of one.

    ``unknown`` is the evidence for something unknown. Pairs far below it are given up, those in time after a few steps.
    """
    leaders = best_of_each(singles)[: len(PARTNERS)]
    best = leaders[0].log_evidence
    level = pair_level(leaders[0], none, misfit=MISFIT)
    explained, hopeless = chance_of_residual(leaders[0]) > EXPLAINED, hopeless_beside(leaders[0], none, unknown)
    found = []
    for rank, leader in enumerate(leaders):
        # What is left of wide tolerances and floors does not say what a second effect may add: its first look does.
        if leader.log_evidence < best - OVERTAKEN if explained else not may_gain(leader, level):
            continue
        own = _problem_of(leader, problem)
        looked = screening.about(_compared_with(leader, own)) if leader.redrawn else screening
        others = _partners(leader, looked, own, tell, explained=explained)
        for number, options in enumerate(others[: PARTNERS[rank]]):
            in_time = not repeat(leader, options[0], own)
            if in_time and (rank or number >= PARTNERS_IN_TIME):
                continue
            tell(f"{leader.candidates[0]} with {options[0].candidate}")
            begin = options[: STARTS_IN_TIME if in_time else STARTS]
            fit = fitted_pair(leader, begin, own, none, hopeless=hopeless)
            if fit and leader.redrawn:
                fit = replace(fit, problem=own, redrawn=True)
            found += [fit] if fit else []
    return best_jointly(found, problem, level, unknown)


def best_jointly(found: Sequence[Fit], problem: Problem, best: float, unknown: float) -> list[Fit]:
    """Return the pairs with clearly more evidence than ``best``, the machine re-fitted beside those that have most."""
    joint: list[Fit] = []
    level, ranked = -math.inf, best_of_each(found)[:JOINT]
    # The place that a few steps prefer may not be the one that the machine's unknowns do.
    elsewhere = [fit for fit in found if ranked and fit.names == ranked[0].names and fit is not ranked[0]]
    for fit in (*ranked[:1], *sorted(elsewhere, key=lambda fit: -fit.log_evidence)[:1], *ranked[1:]):
        contact = any(one.effect.IDEALISED for one in fit.candidates)
        if contact and fit.log_evidence < unknown - OVERTAKEN:
            # Minutes of simulations for the machine's unknowns, for a pair that something unknown has passed.
            joint.append(fit)
        elif fit.log_evidence > level:
            joint.append(replace(jointly(fit, _problem_of(fit, problem), moves=MOVES), redrawn=fit.redrawn))
            # The machine's unknowns may bring twice as much to one close behind.
            brought = max(joint[-1].log_evidence - fit.log_evidence, 0.0)
            level = max(level, fit.log_evidence - brought - CLOSE)
    return best_of_each([fit for fit in joint if fit.log_evidence > best + PAIR_MARGIN])


def told_by_more_than_one_size(pair: Fit, single: Fit) -> bool:
    """Return whether a pair has clearly more evidence than one effect whatever a single line of one record shows.

    Of lines on the scale (`size_scale.py`), as no model tells their sizes; of all lines of a machine that does not
    repeat, as it shows some line of some record far from any prediction: some second effect makes it. Beside an effect
    that strikes, what all lines of the envelope gain by one that does not strike counts for nothing: it makes none of
    them.
    """
    knees = pair.compared and pair.compared.lines.knees
    if pair.compared is None or knees is None:
        return True
    lines, factor = pair.compared.lines, pair.compared.factor
    left = [Widened(fit.law).standardised(fit.residual, factor) ** 2 / 2 for fit in (single, pair)]
    gained = np.zeros(lines.seen.shape)
    count = int(lines.parts[0].sum())
    for part, own in zip(lines.parts, np.split(left[0] - left[1], [count]), strict=True):
        gained[part] += own
    if not lines.spectrum_on_scale:
        gained = np.where(np.isfinite(knees), gained, 0.0)
    most = 0.0
    if _strikes_with_what_does_not(pair):
        envelope = np.array([kind.envelope for kind in lines.kinds])
        most = max(float(gained[..., envelope].sum()), 0.0)
        gained[..., envelope] = 0.0
    most += float(gained.sum(axis=1).max(initial=0.0))
    return pair.log_evidence - most > single.log_evidence + PAIR_MARGIN


def _strikes_with_what_does_not(pair: Fit) -> bool:
    """Return whether one of two effects strikes and the other makes no line of the envelope, as contacts do."""
    struck = that_strike([one.effect for one in pair.candidates])
    others = [one for one in pair.candidates if one.effect not in struck]
    return bool(struck) and any(not one.effect.IDEALISED for one in others)


def may_gain(leader: Fit, best: float) -> bool:
    """Return whether a second effect may add enough: if it explains what is left beyond noise, at no cost.

    That of all lines together, or about that of those that stand out by themselves: sizes are less certain than they
    scatter, so that a few clear lines may hide in a sum that noise would leave.
    """
    count = leader.residual.size
    factor = leader.compared.factor if leader.compared else np.eye(count)
    apart = Widened(leader.law).standardised(leader.residual, factor)
    beyond = max(leader.power - (count - LEAST_NOISE * math.sqrt(2 * count)), 0.0)
    most = 0.5 * max(beyond, float((apart[np.abs(apart) > CLEAR] ** 2).sum()))
    return leader.log_evidence + most >= best + PAIR_MARGIN


def hopeless_beside(leader: Fit, none: Fit, unknown: float) -> float:
    """Return half a squared residual beyond which a pair is not followed, the best single effect being ``leader``."""
    # With which something unknown is as likely, were there no tolerances and no priors.
    level = none.log_evidence + 0.5 * float(none.residual @ none.residual) - unknown
    return min(TIMES_WORSE * leader.power / 2, max(level, 0.0)) + FAR_BEHIND


def repeat(leader: Fit, partner: Start, problem: Problem) -> bool:
    """Return whether the motion with both repeats with the shaft."""
    machine = leader.machine(problem.baseline.machine)
    return problem.predictor.repeats(partner.candidate.on(machine, partner.position))


def best_of_each(fits: Sequence[Fit], *, place: bool = False) -> list[Fit]:
    """Return the best fit of each set of names, or of each ``place`` and variant of theirs; the best first."""
    kept: dict[tuple[object, ...], Fit] = {}
    for fit in sorted(fits, key=lambda fit: -fit.log_evidence):
        kept.setdefault(fit.candidates if place else fit.names, fit)
    return list(kept.values())


def fitted_pair(leader: Fit, options: Sequence[Start], problem: Problem, none: Fit, *, hopeless: float) -> Fit | None:
    """Return the fit of two effects; None where it explains little, or nothing that the first one does not.

    Nor where they, or simulated ones after a few steps, leave more than ``hopeless``, half a squared residual.
    """
    compared, machine, predictor = _compared_with(leader, problem), problem.baseline.machine, problem.predictor
    both = [leader.candidates[0], options[0].candidate]
    places = [np.concatenate([leader.position, o.position]) for o in options]
    tried = climbed(both, places, compared, machine, predictor, steps=FIRST_STEPS)
    if not tried or explains_little(2 * tried[0].objective, none):
        return None
    if tried[0].objective > hopeless and not Responses(both, machine, predictor).repeats(tried[0].position):
        return None
    alone = compared.residual - compared.whitened(leader.response)
    law = laws_of(compared, leader.candidates, [leader.response])
    left = 0.5 * float(alone @ law.solve(alone))
    if tried[0].objective > left - PAIR_MARGIN:
        return None
    fit = refined(both, tried[0].position, compared, machine, predictor)
    # What the machine is uncertain in may show beside the pair only: one that costs little is told by a joint fit.
    costly = any(one.effect.IDEALISED for one in both) or not predictor.repeats(machine)
    return fit if fit and (not costly or fit.power / 2 < hopeless) else None


def _problem_of(fit: Fit, problem: Problem) -> Problem:
    """Return the problem about the machine that was sought beside an effect, if one was, else the calibrated one."""
    return fit.problem if fit.redrawn and fit.problem else problem


def _compared_with(leader: Fit, problem: Problem) -> Comparison:
    """Return the comparison of pairs with an effect: about the machine that was sought beside it, if one was."""
    return leader.compared if leader.redrawn and leader.compared else problem.plain()


def left_beside(leader: Fit, screening: Screening) -> Comparison:
    """Return the comparison of what an effect leaves, its own values and law being open."""
    chosen, compared = list(screening.chosen), screening.compared
    response, slopes = leader.response[chosen], leader.slopes[:, chosen]
    law = laws_of(compared, leader.candidates, [response])
    directions = np.concatenate([law.directions, compared.whitened(slopes)])
    left = replace(compared, residual=compared.residual - compared.whitened(response))
    open_directions = compared.factor @ directions.T
    return left.widened(open_directions @ open_directions.T)


def _partners(leader: Fit, screening: Screening, problem: Problem, tell: Tell, *, explained: bool) -> list[list[Start]]:
    """Return the starts of every other candidate beside an effect, the best candidate first.

    Where the effects alone explain the data, only of those that can do so clearly better all the same.
    """
    beside, least = left_beside(leader, screening), -math.inf
    screening = screened_beside(leader, screening, problem, ("sensor",) if explained else ("sensor", "structure"), tell)
    if explained:
        least = nothing(beside).log_evidence + PAIR_MARGIN
    else:
        screening = screening.taking_up(beside)
    ranked = few_of_each([options for options in screening.against(beside) if options[0].score > least])
    return [options for options in ranked if options[0].candidate.name not in leader.names]


def screened_beside(
    leader: Fit, screening: Screening, problem: Problem, stages: Sequence[str], tell: Tell = lambda _: None
) -> Screening:
    """Return the screening with the responses of effects of these stages on the machine with the leading effect.

    A structure that changes, and a sensor that was turned, act on what the leading effect makes as well. One on the
    measuring chain leaves the machine's motion as it is, so that nothing changes beside it.
    """
    atoms, few = dict(screening.atoms), problem.predictor.select(screening.chosen)
    machine = leader.machine(problem.baseline.machine)
    if leader.candidates[0].effect.STAGE == "sensor" or not few.repeats(machine):
        return screening
    for one in atoms:
        changes = one.effect.STAGE in stages and one.name not in leader.names
        if changes and few.repeats(in_the_middle(one, machine)):
            tell(f"{one} beside {leader.candidates[0]}")
            atoms[one] = atoms_of(one, machine, few, deviations=screening.compared.lines.deviations)
    return replace(screening, atoms=atoms)


def explains_little(power: float, none: Fit) -> bool:
    """Return whether a squared residual is hardly smaller than without any effect, beyond noise."""
    noise = none.residual.size
    without = float(none.residual @ none.residual) - noise
    return without > CLEARLY and power - noise > LITTLE * without

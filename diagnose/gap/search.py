"""The search over hypotheses: nothing, one effect, two effects, something unknown; and how probable each is."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from .aligned import not_as_two
from .beside_unknown import beside_unknown
from .climb import FIRST_STEPS, Climbed, climbed
from .evidence import Problem
from .force_kernels import ForceKernel
from .further_strengths import with_further_strengths
from .hills import looked_about, with_hills
from .hypotheses import Candidate
from .joint_fit import jointly
from .null_distribution import chance_of_residual
from .open_resonance import at_open_resonances
from .opposing import told_pairs
from .parts_alone import parts_alone
from .posterior import Posterior, posterior_of
from .refine import Fit, density, nothing, refined
from .response_shape import scaled_strengths
from .responses import Responses
from .screen import Start
from .screening import BEHIND_ON_GRID, FAR_BEHIND, TIMES_WORSE, Screening, few_of_each
from .simple_pairs import simple_pairs
from .swapped_pairs import swapped_pairs
from .two_effects import CLOSE, EXPLAINED, MISFIT, MOVES, best_of_each, explains_little, two_effects
from .unknown_force import unexplained
from .within_law import PAIR_MARGIN, pair_level

#: Effects of which a few steps are made, of these the ones followed to the end, and of these the ones compared with the
#: machine re-fitted beside them.
REFINED, FINISHED, JOINT = 8, 4, 3
#: Further ones that are no contact nor crack, which cost little: what explains little alone may be half of a pair.
FURTHER = 3
#: Effects of more strengths are among them whatever the first look, which is a rough one in so many dimensions.
MANY = 3
#: An effect with so much less evidence than nothing at all is not followed.
HOPELESS = 5.0
#: Where nothing at all explains the data with this chance, effects that are no better in the first look are not
#: followed: their evidence is that of the first look.
GOOD = 0.05
#: Where nothing explains the data so well, effects are looked at on a finer grid: starts there that are better by this
#: are followed as well.
BETTER = 1.0
#: Starts of one effect, and of one that is simulated in time; of one whose response bends with its strength each is
#: followed to the end, as a contact that opens in some of the conditions only makes hills between them.
STARTS, STARTS_IN_TIME, STARTS_OF_BENT = 2, 1, 3
#: Of one with many hills, something unknown with so much less evidence is a reason to look for others.
NEXT_TO = 100.0
#: Factors of the strength that are tried where each is a simulation.
SCANNED = (0.5, 0.7, 1.4, 2.0, 3.0)
#: Factor by which the law of an idealised effect may be less exact than usual, and more.
LESS_EXACT, MORE_EXACT = 2.0, 0.5

Tell = Callable[[str], None]


def search(
    problem: Problem,
    screening: Screening,
    kernels: Sequence[ForceKernel],
    *,
    tell: Tell = lambda _: None,
) -> Posterior:
    """Return the posterior over all hypotheses.

    Parameters
    ----------
    problem : Problem
    screening : Screening
    kernels : sequence of ForceKernel
        What unknown forces make.
    """
    compared = problem.plain()
    none = nothing(compared)
    screened, first_look = _worth_following(screening, problem, none)
    unknown = unexplained(compared, kernels)
    others = none, unknown.log_evidence
    singles, pairs = _singles(screened, screening, problem, others, tell), []
    if singles and not _explain([none, *singles], GOOD):
        pairs = simple_pairs(singles, screening, problem, *others, tell)
    if not _explain([none, *singles, *pairs], GOOD):
        screening, seen = screening.finer(), {options[0].candidate: options[0].score for options in screened}
        finer, first_look = _worth_following(screening, problem, none)
        better = [o for o in finer[:FINISHED] if o[0].score > seen.get(o[0].candidate, -math.inf) + BETTER]
        singles = best_of_each([*singles, *_singles(better, screening, problem, others, tell)], place=True)
    # Two effects that explain all, but less well than something unknown, may be one at a resonance that lies elsewhere.
    ahead = bool(pairs) and max(fit.log_evidence for fit in pairs) > unknown.log_evidence
    if singles and not (ahead and _explain(pairs, EXPLAINED)):
        singles = at_open_resonances(singles, problem, unknown.log_evidence, misfit=MISFIT, tell=tell)
        pairs += two_effects(singles, screening, problem, *others, tell)
    if pairs:
        pairs = best_of_each([*pairs, *swapped_pairs(pairs, singles, screening, problem, *others, tell)])
        singles = parts_alone(pairs, singles, problem)
        level = pair_level(singles[0], none, misfit=MISFIT) + PAIR_MARGIN
        pairs = [fit for fit in pairs if fit.log_evidence > level]
    pairs, opposed = told_pairs(pairs, singles, problem)
    fits = tuple(sorted([*singles, *pairs], key=lambda fit: -fit.log_evidence))
    fits = (*(_as_exact_as_told(fit, problem) for fit in fits[:1]), *fits[1:])
    hills = {fit.candidates[0]: fit.hills for fit in singles if fit.hills is not None}
    fits = tuple(with_hills(fit, hills) for fit in fits)
    count = len({candidate.name for candidate in screening.atoms})
    fitted = {candidate for fit in fits for candidate in fit.candidates}
    rest = [(one.name, none.log_evidence + more) for one, more in first_look.items() if one not in fitted]
    posterior = replace(posterior_of(compared, none, fits, unknown, count, rest), opposed=opposed)
    if next(iter(posterior.probabilities)) != ("unknown",) or not unknown.kernels:
        return not_as_two(posterior, problem)
    beside, unlike = beside_unknown(problem, screening, unknown, fits, tell=tell)
    if not beside:
        return posterior
    posterior = posterior_of(compared, none, (*fits, *beside), unknown, count, rest, unlike)
    return replace(posterior, opposed=opposed)


def _explain(fits: list[Fit], chance: float) -> bool:
    """Return whether what the best of some fits leaves is noise with a larger chance."""
    return chance_of_residual(max(fits, key=lambda fit: fit.log_evidence)) > chance


def _worth_following(
    screening: Screening, problem: Problem, none: Fit
) -> tuple[list[list[Start]], dict[Candidate, float]]:
    """Return the starts of effects that are worth steps, and how much more evidence than nothing the others have.

    Others are told only where nothing at all explains the data.
    """
    machine, predictor = problem.baseline.machine, problem.predictor
    every = screening.best()
    plain = nothing(screening.compared).log_evidence
    first_look = {}
    if chance_of_residual(none) > GOOD:
        first_look = {o[0].candidate: o[0].score - plain for o in every if o[0].score <= plain}
    ranked = few_of_each(every)
    screened = ranked[:REFINED] + [one for one in ranked[REFINED:] if len(one[0].candidate.strengths) > MANY]
    screened = [options for options in screened if options[0].candidate not in first_look]
    best = every[0][0].score if every else plain
    least = best - max(FAR_BEHIND, BEHIND_ON_GRID * (best - plain))
    return [
        options
        for options in screened
        if options[0].score > least or predictor.repeats(options[0].candidate.on(machine, options[0].position))
    ], first_look


def _singles(
    screened: list[list[Start]], screening: Screening, problem: Problem, others: tuple[Fit, float], tell: Tell
) -> list[Fit]:
    """Return the fits of single effects that are no worse than none, of the best with the machine's own unknowns.

    ``others`` are that of no effect, and the evidence for something unknown.
    """
    finished = _finished(_begun(screened, screening, problem, tell), problem)
    finished = [with_further_strengths(fit, screening, problem) for fit in finished]
    fits = best_of_each([_scanned(fit, problem) for fit in finished], place=True)
    fits = [looked_about(fit, problem) if _is_rough(fit, *others) else fit for fit in fits[:1]] + fits[1:]
    begun = [fit for fit in fits if fit.log_evidence > others[0].log_evidence - HOPELESS]
    return _jointly_best(begun, problem, others[0]) if begun else []


def _begun(
    screened: list[list[Start]], screening: Screening, problem: Problem, tell: Tell
) -> list[tuple[Candidate, list[Climbed]]]:
    """Return where a few steps with each single effect have got to, the best first."""
    compared, machine, predictor = problem.plain(), problem.baseline.machine, problem.predictor
    begun: list[tuple[Candidate, list[Climbed]]] = []
    for rank, options in enumerate(screened):
        one = options[0].candidate
        tell(f"effect {rank + 1} of {len(screened)}: {one}")
        repeating = [o for o in options if predictor.repeats(one.on(machine, o.position))]
        repeats = options[0] in repeating
        # A candidate with some of its strengths has no responses of its own: these add up, and do not bend.
        bent = any(not atom.proportional for atom in screening.atoms.get(one, ())) and bool(repeating)
        count = STARTS_OF_BENT if bent else STARTS if repeats else STARTS_IN_TIME
        # A contact that chatters at its best start may repeat at others, where steps cost little.
        begin = options if repeats else [options[0], *repeating]
        places = [option.position for option in begin[:count]]
        tried = climbed([one], places[:1], compared, machine, predictor, steps=FIRST_STEPS)
        if not tried or not begun or not _is_worse(tried[0], begun):
            tried += climbed([one], places[1:], compared, machine, predictor, steps=FIRST_STEPS)
            tried.sort(key=lambda found: found.objective)
        begun += [(one, tried if bent else tried[:1])] if tried else []
    return sorted(begun, key=lambda item: item[1][0].objective)


def _is_worse(tried: Climbed, begun: list[tuple[Candidate, list[Climbed]]]) -> bool:
    """Return whether an effect leaves far more than the best one after the same steps."""
    return tried.objective > TIMES_WORSE * min(found[0].objective for _, found in begun) + FAR_BEHIND


def _finished(begun: list[tuple[Candidate, list[Climbed]]], problem: Problem) -> list[Fit]:
    """Return the fits of the best of them, and of further ones that cost little, followed to the end.

    Not of those that cost much and are far worse than the best.
    """
    compared, machine, predictor = problem.plain(), problem.baseline.machine, problem.predictor

    def costs_little(item: tuple[Candidate, list[Climbed]]) -> bool:
        one, tried = item
        return not one.effect.IDEALISED and predictor.repeats(one.on(machine, tried[0].position))

    further = [item for item in begun[FINISHED:] if costs_little(item)][:FURTHER]
    found = []
    for item in [*begun[:FINISHED], *further]:
        one, tried = item
        if _is_worse(tried[0], begun) and not costs_little(item):
            continue
        fits = [refined([one], first.position, compared, machine, predictor) for first in tried]
        found += sorted((fit for fit in fits if fit), key=lambda fit: -fit.log_evidence)[:1]
    return found


def _is_rough(fit: Fit, none: Fit, unknown: float) -> bool:
    """Return whether an effect explains most, but leaves more than noise.

    Or, of one whose likelihood has many hills, whether something unknown has nearly as much evidence as where it is.
    """
    behind = fit.candidates[0].effect.IDEALISED and fit.log_evidence < unknown + NEXT_TO
    return not explains_little(fit.power, none) and (chance_of_residual(fit) <= MISFIT or behind)


def _scanned(fit: Fit, problem: Problem) -> Fit:
    """Return the fit of an effect that is simulated in time, or the one from a better strength far away, if any.

    Sizes are predicted to a factor only, and how wide that factor lets them be grows with the strength: steps that take
    the law of where they stand may end at half the strength.
    """
    compared, machine, predictor = problem.plain(), problem.baseline.machine, problem.predictor
    one = fit.candidates[0]
    if predictor.repeats(fit.machine(machine)) or not one.strengths:
        return fit
    tried = [scaled_strengths(one, fit.position, one.strengths, factor) for factor in SCANNED]
    response, places = Responses([one], machine, predictor), [place for place in tried if place is not None]
    response.prepare(places)
    best, start = density(response, fit.position, compared), fit.position
    for place in places:
        there = density(response, place, compared)
        if there > best:
            best, start = there, place
    found = None if start is fit.position else refined([one], start, compared, machine, predictor)
    return found if found and found.log_evidence > fit.log_evidence else fit


def _as_exact_as_told(fit: Fit, problem: Problem) -> Fit:
    """Return the fit of an effect whose law is an idealisation, with a wider or narrower law where that is likelier.

    How exact it is the data say: wider where it leaves more than noise, narrower where it explains better than its law
    promises, as far as it repeats. The choice is paid for.
    """
    if fit.compared is None or not any(one.effect.IDEALISED for one in fit.candidates):
        return fit
    machine = (fit.problem or problem).baseline.machine
    wider = chance_of_residual(fit) <= MISFIT
    if not wider and not problem.predictor.repeats(fit.machine(machine)):
        return fit
    compared = replace(fit.compared, inexact=LESS_EXACT if wider else MORE_EXACT)
    found = refined(fit.candidates, fit.position, compared, machine, problem.predictor)
    cost = math.log(2)
    if found is None or found.log_evidence - cost < fit.log_evidence:
        return fit
    return replace(found, log_evidence=found.log_evidence - cost, problem=fit.problem)


def _jointly_best(fits: list[Fit], problem: Problem, none: Fit) -> list[Fit]:
    """Return the fits, those that explain most with the machine's own unknowns fitted beside them."""
    little = [fit for fit in fits if explains_little(fit.power, none)]
    ranked = sorted([fit for fit in fits if fit not in little], key=lambda fit: -fit.log_evidence)
    if not ranked:
        return little
    joint: list[Fit] = []
    for count, fit in enumerate(ranked):
        best = max((one.log_evidence for one in joint), default=fit.log_evidence)
        # What is seen of the unknowns costs evidence: a fit that has not paid must not pass one that has.
        far = fit.log_evidence < best - CLOSE
        if far and count >= JOINT:
            break
        in_time = not problem.predictor.repeats(fit.machine(problem.baseline.machine))
        if in_time and any(fit.names == one.names for one in joint):
            # Another variant of an effect that explains more: not worth a simulation for each of the unknowns.
            continue
        joint.append(fit if far and in_time else jointly(fit, problem, moves=0))
    best, seen = max(one.log_evidence for one in joint), {one.names for one in joint}
    rest = [fit for fit in ranked if fit.names not in seen]
    close = [jointly(fit, problem, moves=MOVES) if _may_lead(fit, best) else fit for fit in joint]
    return close + rest + little


def _may_lead(fit: Fit, best: float) -> bool:
    """Return whether a fit with the machine moved beside it may have the most evidence, ``best`` being the most yet.

    One that leaves more than noise may leave nothing about another machine: its lines pass a resonance, which one that
    takes any shape follows as it is.
    """
    left = fit.power / 2 if chance_of_residual(fit) <= MISFIT else 0.0
    return fit.log_evidence + max(left, CLOSE) > best

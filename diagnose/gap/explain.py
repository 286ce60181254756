"""`explain_gap`: from a campaign and a machine to the verdict, the extended machine and the gain."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...datasets.recording import Campaign, Recording
from ...simulators.effect import Effect, effect_catalogue
from ...simulators.machine import Machine
from ...simulators.solvers.blas import single_blas_thread
from .asked import check_machine, dead_words, known_effects, shared_probes
from .changed_transfer import changed_transfers, without_changed
from .detection_limits import detection_limits, limit_words
from .envelope_lines import Spectrum, envelopes_of
from .envelope_noise import noise_of_records, not_of_the_fault
from .evidence import Comparison
from .first_look import explainable, in_the_middle, reach
from .force_kernels import force_kernels
from .found_lines import found_lines
from .gain import measured_gain, useful_forces
from .heard_rhythm import heard_rhythm
from .held_out import checked, with_pulse_elsewhere
from .hypotheses import Candidate, candidates
from .lines import OrderLines, turned_to_reference
from .loose_contact import without_spikes
from .lost_samples import mended
from .met_lines import with_met_lines, with_own_lines
from .observe import observe_orders, shaft_speed_rpm, with_floor, with_reference
from .plausible_sizes import check_alike, check_size_of_machine
from .predict import Predictor
from .prepared import REPEATABILITY, Prepared, put_together
from .probe_ranges import probe_ranges
from .result import GapResult
from .screen import Atom, atoms_of
from .screening import Screening, telling_conditions
from .search import search
from .shown_lines import may_show, standing_out
from .size_scale import knees_of, on_scale
from .slow_sway import slow_sways
from .struck_rhythm import not_heard, of_a_rhythm
from .unseen_weight import beside_weight
from .unsteady import unsteady
from .verdict import told
from .wanted_lines import STRUCK, wanted_lines
from .waveform import (
    ONLY_IN_WAVEFORM,
    SUSPECTED,
    lossy_channels,
    seen_in_waveform,
    variations,
    with_doubt,
    without_hunting,
)

HIGHEST_ORDER = 6.0
#: Conditions in which all candidates are screened; the best are then followed in all of them.
SCREENED_CONDITIONS = 3
#: The same where every response is a simulation in time; candidates that are then followed further, and parts and
#: variants of one effect among them.
SCREENED_IN_TIME, FOLLOWED_IN_TIME, PARTS_IN_TIME = 2, 16, 3
#: Strengths at which a first look is taken at each of them, in standard deviations of their prior.
LEVELS = (0.0, 1.0)

Tell = Callable[[str], None]


@single_blas_thread
def explain_gap(
    campaign: Campaign,
    machine: Machine,
    *,
    without: frozenset[str] = frozenset(),
    only: frozenset[str] | None = None,
    as_given: bool = False,
    tell: Tell = lambda _: None,
) -> GapResult:
    """Return what a simulated machine gets wrong about a measured one, its cause, and the gain of adding it.

    Parameters
    ----------
    campaign : Campaign
        ``recordings`` are explained; ``baseline`` recordings, of the healthy machine, may be empty. Channels are named
        like the machine's probes; others are not looked at.
    machine : Machine
    without : frozenset of str
        Effects that do not compete.
    only : frozenset of str, optional
        The only effects that compete.
    as_given : bool
        Do not add what the healthy recordings say that the model lacks.
    tell : callable
        Called with a few words on what is being done.

    Raises
    ------
    InvalidValueError
        When no channel is a probe of the machine, a recording cannot be used, or an effect is not in the catalogue.
    """
    check_machine(machine)
    without, only = known_effects(without, "without"), only and known_effects(only, "only")
    tell("observing the recordings")
    prepared = prepare(campaign, machine, without=without, as_given=as_given, tell=tell)
    answer = explained(prepared, machine, without, only, tell)
    return replace(answer, remarks=(*answer.remarks, *dead_words(campaign, machine)))


def explained(
    prepared: Prepared, machine: Machine, without: frozenset[str], only: frozenset[str] | None, tell: Tell
) -> GapResult:
    """Return the answer to a calibrated machine and the lines to explain; parameters as of `explain_gap`."""
    problem = prepared.problem(prepared.fitted)
    part = problem.predictor
    compared = problem.plain()
    periodic = part.repeats(problem.baseline.machine)
    chosen = telling_conditions(compared, SCREENED_CONDITIONS if periodic else SCREENED_IN_TIME)
    screened, few = prepared.problem([prepared.fitted[i] for i in chosen]).plain(), part.select(chosen)
    own = problem.baseline.machine
    tell("finding what each effect can do")
    left_out = without if only is None else without | (effect_catalogue().keys() - only)
    lacking = (*prepared.found_lines, *standing_out(compared))
    competing = _competing(machine, left_out, compared, own, few, screened, lacking)
    # Also those of which the model makes too little: how loud a defect is at a sensor it tells to a factor at best.
    rhythms = tuple(dict.fromkeys((*_striking(machine, left_out), *(one.effect for one in competing))))
    unheard = not_heard(rhythms, machine, prepared.envelopes)
    has_healthy = problem.at_healthy is not None
    permanent = [one.name for one in competing if has_healthy and one.effect.PERMANENT]
    competing = [one for one in competing if one.effect not in unheard and one.name not in permanent]
    competing += beside_weight(competing, own, few, screened.lines.deviations)
    competing, rest = _most_explaining(competing, own, few, screened, tell)
    grid = functools.partial(responses, competing, own, few, screened, tell=tell)
    look = functools.partial(atoms_of, machine=own, predictor=few, deviations=screened.lines.deviations, coarsely=True)
    screening = Screening(
        chosen,
        screened,
        grid(coarsely=True),
        functools.partial(grid, coarsely=False),
        {one: functools.partial(look, one) for one in rest},
        lambda one, left: explainable(one, own, few, left),
    )
    not_compared = _silent(screening)
    gone = {one.NAME for one in unheard} - {one.name for one in competing}
    not_compared = dict.fromkeys(sorted(gone), "the envelope beats in another rhythm") | not_compared
    not_compared |= dict.fromkeys(permanent, "acts on the healthy machine as well")
    tied = all(one.tied for one in part.conditions)
    kernels = force_kernels(problem.baseline.machine, part) if tied else ()
    posterior = search(problem, screening, kernels, tell=tell)
    tell("measuring the gain")
    posterior, withdrawn = checked(prepared, posterior)
    posterior, elsewhere = with_pulse_elsewhere(prepared, posterior)
    forces, remarks = useful_forces(prepared, posterior)
    gain = measured_gain(machine, prepared, posterior, forces)
    heard = heard_rhythm(rhythms, machine, prepared.envelopes, prepared.measured)
    remarks = (*withdrawn, *elsewhere, *remarks)
    answer = told(machine, prepared, posterior, not_compared, gain, forces, remarks, heard)
    if answer.kind not in ("none", "cannot tell"):
        return answer
    tell("finding what would have shown")
    # Whether the shaft lies nobody knows: a limit holds in both cases.
    limits = detection_limits([one for one in screening.atoms if not one.beside], problem)
    return replace(answer, detection_limits=limits, remarks=(*answer.remarks, *limit_words(limits)))


def _competing(
    machine: Machine,
    without: frozenset[str],
    compared: Comparison,
    own: Machine,
    few: Predictor,
    screened: Comparison,
    lacking: Sequence[tuple[float, float]],
) -> list[Candidate]:
    """Return the candidates whose lines may show; ``own`` is the calibrated machine, ``few`` for ``screened``."""

    def reached(one: Candidate) -> float:
        return reach(one, own, few, screened.lines.deviations) if may_show(one, own, compared) else 0.0

    asked: list[Candidate] = []

    def noted(one: Candidate) -> float:
        asked.append(one)
        return 1.0

    every = functools.partial(
        candidates,
        machine,
        without=without | ONLY_IN_WAVEFORM,
        probes=compared.lines.probes,
        found_lines=lacking,
    )
    # All that will be asked for at once, as motions go side by side.
    every(reach=noted)
    few.prepare([in_the_middle(one, own) for one in asked if may_show(one, own, compared)])
    return [one for one in every(reach=reached) if may_show(one, own, compared)]


def prepare(
    campaign: Campaign,
    machine: Machine,
    *,
    without: frozenset[str] = frozenset(),
    as_given: bool = False,
    tell: Tell = lambda _: None,
) -> Prepared:
    """Return observed lines and the calibrated baseline; effects of ``without`` are not named from the waveform.

    With ``as_given`` nothing is added that the healthy recordings say that the model lacks.
    """
    channels = shared_probes(campaign, machine)
    check_alike(campaign, list(channels))
    (recordings, spikes), (baseline, earlier) = map(without_spikes, (campaign.recordings, campaign.baseline))
    campaign, spikes = replace(campaign, recordings=recordings, baseline=baseline), (*spikes, *earlier)
    seen = seen_in_waveform(campaign.recordings, campaign.baseline, list(channels))
    lossy, recorded = lossy_channels(seen), campaign.recordings
    put_back = mended(recorded, lossy) if lossy else None
    campaign = replace(campaign, recordings=put_back or recorded)
    measured, healthy, further = observed(campaign, machine, channels)
    raw = _as_recorded(recorded, channels, measured) if put_back else None
    waveform = {name: own for name, own in seen.items() if name not in without}
    beyond = [own for effect, own in seen.items() if effect in without - SUSPECTED]
    # A wandering speed is seen in no channel of its own.
    flawed = tuple(dict.fromkeys(name for own in beyond for name in own or ("the tacho",)))
    measured = with_own_lines(_sure(measured, campaign.recordings), campaign.baseline, healthy, channels)
    probes = machine.bare_assembly().probes
    turning = [one.name for one in probes if (one.direction, one.quantity) == ("torsion", "velocity")]
    measured = with_doubt(measured, seen, variations(campaign.recordings), raw, turning)
    measured = without_hunting(measured, campaign.recordings)
    healthy = without_hunting(healthy, campaign.baseline) if healthy else None
    speeds, before = ([row.speed_rpm for row in one.conditions] if one else [] for one in (measured, healthy))
    envelopes = envelopes_of(campaign.recordings, speeds, campaign.baseline, before)
    restless = unsteady(campaign.recordings, speeds, campaign.baseline, before, list(channels))
    changed = changed_transfers(campaign.recordings, speeds, campaign.baseline, before, list(channels))
    measured = without_changed(_without_rhythm(measured, machine, envelopes, without), changed)
    unseen = {measured.orders[i] for i in np.flatnonzero(~measured.seen.any(axis=(0, 1)))}
    further = tuple(place for place in further if place[1] or place[0] not in unseen)
    healthy = _sure(healthy, campaign.baseline) if healthy else None
    every = (measured, healthy) if healthy else (measured,)
    ranges = probe_ranges((*campaign.recordings, *campaign.baseline), *every)
    predictor = _predictor(measured, campaign.recordings, ranges)
    own = _predictor(healthy, campaign.baseline, ranges) if healthy else None
    if healthy and own and predictor.noise is not None and own.noise is not None:
        predictor = replace(predictor, noise=not_of_the_fault(predictor.noise, measured, own.noise, healthy))
    quantities = {one.name: one.quantity for one in probes if one.name in measured.probes}
    both = [*([(healthy, own)] if healthy and own else []), (measured, predictor)]
    check_size_of_machine(machine, both, quantities)
    repeats = predictor.repeats(machine)
    knees = knees_of(every, envelope_only=repeats)
    if np.isfinite(knees).any():
        measured, predictor = on_scale(measured, knees), replace(predictor, knees=knees)
        healthy, own = healthy and on_scale(healthy, knees), own and replace(own, knees=knees)
    found = put_together(machine, measured, predictor, healthy, own, as_given=as_given, tell=tell)
    found = replace(found, waveform=waveform, flawed=flawed, found_lines=further, envelopes=envelopes)
    drifting = (*seen.get("dc_drift", ()), *(turning if "speed_wander" in seen else ()))
    sways = slow_sways(campaign.recordings, campaign.baseline, [one for one in channels if one not in drifting])
    found = replace(found, unsteady=restless, transfers=changed, sways=sways, spikes=spikes)
    return replace(found, mended=put_back is not None)


def _without_rhythm(
    lines: OrderLines, machine: Machine, envelopes: Sequence[Spectrum], without: frozenset[str]
) -> OrderLines:
    """Return the lines without those beside the shaft's orders that are part of a rhythm which the envelope shows."""
    effects = _striking(machine, without) if envelopes else []
    orders = np.array(
        [
            [kind.order_at(order, condition.speed_rpm) for order, kind in zip(lines.orders, lines.kinds, strict=True)]
            for condition in lines.conditions
        ]
    )
    aside = np.array([not kind.phase and not kind.envelope for kind in lines.kinds])
    told = of_a_rhythm(orders, tuple(effects), machine, envelopes) & aside
    return replace(lines, deviations=np.where(told[:, None, :], np.inf, lines.deviations))


def _striking(machine: Machine, without: frozenset[str]) -> list[Effect]:
    """Return the effects that strike in a bearing of the machine, at each of their places."""
    others = frozenset(name for name, effect in effect_catalogue().items() if effect.ROLE not in STRUCK)
    return list(dict.fromkeys(one.effect for one in candidates(machine, without=without | others)))


def _as_recorded(recordings: Sequence[Recording], channels: Mapping[str, str], like: OrderLines) -> OrderLines:
    """Return the same lines of other recordings of the same conditions; missing samples count as 0."""
    recordings = [replace(one, signals=np.nan_to_num(one.signals)) for one in recordings]
    (found,) = observe_orders(recordings, orders=like.orders, kinds=like.kinds, channels=channels)
    return replace(found, amplitudes=turned_to_reference(found.amplitudes, found.conditions, like.reference))


def _sure(lines: OrderLines, recordings: Sequence[Recording]) -> OrderLines:
    """Return the lines no surer than they repeat, and than a line at a fixed frequency leaves them."""
    return with_met_lines(with_floor(lines, REPEATABILITY), [one.samples / one.rate_hz for one in recordings])


def observed(
    campaign: Campaign, machine: Machine, channels: Mapping[str, str]
) -> tuple[OrderLines, OrderLines | None, tuple[tuple[float, float], ...]]:
    """Return the lines to explain, those of the healthy recordings if any, and the places of those found."""
    speeds = [one.condition.speed_rpm or shaft_speed_rpm(one) for one in campaign.recordings]
    orders, kinds = wanted_lines(machine, highest=HIGHEST_ORDER, speeds_rpm=speeds)
    further = found_lines(campaign.recordings, campaign.baseline, list(channels), (orders, kinds))
    orders, kinds = (*orders, *(one.order for one in further)), (*kinds, *(one.kind for one in further))
    sets = [campaign.recordings, campaign.baseline] if campaign.baseline else [campaign.recordings]
    found = with_reference(*observe_orders(*sets, orders=orders, kinds=kinds, channels=channels))
    places = tuple(place for one in further for place in one.places)
    return found[0], found[1] if len(found) > 1 else None, places


def responses(
    competing: Sequence[Candidate],
    machine: Machine,
    predictor: Predictor,
    screened: Comparison,
    *,
    coarsely: bool,
    tell: Tell = lambda _: None,
) -> dict[Candidate, tuple[Atom, ...]]:
    """Return each candidate's responses on a grid; see `atoms_of`."""
    found = {}
    for number, one in enumerate(competing):
        tell(f"responses {number + 1} of {len(competing)}: {one}")
        found[one] = atoms_of(one, machine, predictor, deviations=screened.lines.deviations, coarsely=coarsely)
    return found


def _silent(screening: Screening) -> dict[str, str]:
    """Return the effects that have no response, with the reason."""
    names = dict.fromkeys(one.name for one in screening.atoms)
    heard = {one.name for one, own in screening.atoms.items() if own}
    return {name: "adds nothing to the lines that are compared here" for name in names if name not in heard}


def _most_explaining(
    competing: Sequence[Candidate], machine: Machine, predictor: Predictor, screened: Comparison, tell: Tell
) -> tuple[list[Candidate], list[Candidate]]:
    """Return the candidates but for those simulated in time that can explain least, where these are many; and these.

    Of one effect not more than a few parts and variants are kept: four bearings would leave no room for others.
    """
    in_time = []
    for one in competing:
        if one.effect.STAGE == "sensor" and predictor.repeats(machine):
            continue
        if not predictor.repeats(in_the_middle(one, machine)):
            in_time.append(one)
    if len(in_time) <= FOLLOWED_IN_TIME:
        return list(competing), []
    tell(f"a first look at {len(in_time)} effects")
    # A crack in the middle of its prior may hardly show, and what it would show then is not told.
    predictor.prepare([in_the_middle(one, machine, level=level) for one in in_time for level in LEVELS])
    share = {one: max(explainable(one, machine, predictor, screened, level=at) for at in LEVELS) for one in in_time}
    kept: list[Candidate] = []
    for one in sorted(in_time, key=lambda one: -share[one]):
        if len(kept) < FOLLOWED_IN_TIME and sum(other.name == one.name for other in kept) < PARTS_IN_TIME:
            kept.append(one)
    rest = [one for one in in_time if one not in kept]
    return [one for one in competing if one not in rest], rest


def _predictor(lines: OrderLines, recordings: Sequence[Recording], ranges: np.ndarray) -> Predictor:
    rates, lengths = tuple(one.rate_hz for one in recordings), tuple(one.samples for one in recordings)
    noise = noise_of_records(lines, recordings) if any(kind.envelope for kind in lines.kinds) else None
    seen = (lines.conditions, lines.probes, lines.orders)
    return Predictor(*seen, rates, lengths, lines.kinds, lines.reference, noise, ranges)

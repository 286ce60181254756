"""One blind trial: a machine that is not quite as declared, its healthy records, and records with a hidden cause.

The generator runs in the time domain and shares nothing with the engine but the description of machines and effects.
Of twenty trials four hide nothing (in two of these the machine has drifted since its healthy records), ten hide one
effect, three hide two, and three hide one that the engine is not told of. Hidden is any effect of the catalogue that
can act on the machine, on the measuring chain as well; many of these leave the lines as they are, so that d2 is what a
trial is judged by. Where two are hidden, or an unknown one, effects are drawn up to four times for a d2 of 20
each: what nobody can see is neither half of a pair nor unknown. A draw that cannot be simulated (it makes the machine
unstable) is drawn again.

Half of the trials carry a further imperfection of another kind, so weak that its d2 is at most 4. It is none that the
waveform shows (`SHOWN_BY_WAVEFORM`): d2 is that of lines, and clipping, say, can be seen without any.

The law of a hidden effect on the machine is wrong by 10 %: at every order k the effect's change of the line is
multiplied by 1 + e_k, e_k complex normal with rms 0.1, the same at all probes and conditions. In a linear machine this
is a force whose harmonics are off by so much; it is done on the difference of the runs with and without the effect.
Effects on the speed and on the measuring chain keep their law.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ....datasets.recording import Campaign
from ....simulators.effect import Effect
from ....simulators.errors import InvalidValueError, RotorwiseError
from ....simulators.machine import Machine, find_machine
from ....simulators.solvers.simulate import Simulation
from .draws import applicable, drawn, drifted, perturbed, turned_anyhow, weakened
from .lines import Lines, detectability, lines_of, orders_of, with_stated
from .ranges import TrialRange, find_range
from .recorder import GAIN_DEVIATION, Setting, clean_record, kept, motions, moves_as, noise_of, recording
from .wrong_form import supports_of, with_wrong_form

FAMILIES = ("tune", "score")
KINDS = ("none", "one", "two", "unknown")
#: Kind and whether the machine drifts, of twenty trials.
_TWENTY = [("none", False)] * 2 + [("none", True)] * 2 + [("one", False)] * 10 + [("two", False)] * 3
_TWENTY += [("unknown", False)] * 3
LAW_ERROR = 0.1
DETECTABLE, DRAWS_FOR_IT, MOST_DRAWS = 20.0, 4, 40
MOST_MACHINES = 5
BELOW_DETECTABILITY, ROUNDS = 4.0, 4
#: Share of trials with a further imperfection, and of those whose healthy records have other speeds.
WITH_IMPERFECTION, OTHER_SPEEDS = 0.5, 0.2
SHOWN_BY_WAVEFORM = frozenset(("aliasing", "clipping", "dc_drift", "dropped_samples", "quantisation", "speed_wander"))
#: Words of the seeds of a wrong form, and of angles that may be any, which change nothing else of a trial.
WRONG_FORM, ANYWHERE = 7, 11


@dataclass(frozen=True)
class Hidden:
    """An effect that acts in the records, and the d2 of what it changes in them."""

    effect: Effect
    d2: float


@dataclass(frozen=True, eq=False)
class TrialCase:
    """A campaign whose truth is known.

    Attributes
    ----------
    number : int
    kind : str
        One of `KINDS`.
    machine : Machine
        As declared; this is what the engine gets.
    campaign : Campaign
    hidden : tuple of Hidden
        What the engine should name (or, for "unknown", call unknown).
    left_out : frozenset of str
        Effects that the engine must not know.
    d2 : float
        Of all hidden effects together.
    imperfection : Hidden, optional
        Too weak to be found.
    drift_d2 : float
        Of the machine's drift since its healthy records; 0 without.
    same_speeds : bool
        The healthy records have the speeds of the others.
    redrawn : int
        Effects refused before these.
    """

    number: int
    kind: str
    machine: Machine
    campaign: Campaign
    hidden: tuple[Hidden, ...]
    left_out: frozenset[str]
    d2: float
    imperfection: Hidden | None
    drift_d2: float
    same_speeds: bool
    redrawn: int


def make_case(
    machine: str,
    *,
    number: int,
    seed: int,
    snr_db: float,
    family: str = "score",
    wrong_form: float = 0.0,
    anywhere: bool = False,
) -> TrialCase:
    """Return one trial; the same arguments give the same trial, to the bit.

    Parameters
    ----------
    machine : str
        Name of a shipped machine.
    number : int
        Of the trial, from 0.
    seed : int
    snr_db : float
        Rms of a record's vibration over rms of its broadband noise.
    family : str
        "tune" or "score"; no trial of one is a trial of the other.
    wrong_form : float
        Share of their stiffness by which the machine's supports are other than its model's.
    anywhere : bool
        The tacho's pulse, and the machine's own unbalance, may be at any angle of the shaft.

    Raises
    ------
    InvalidValueError
        For a value that is not allowed.
    """
    check(machine, seed=seed, snr_db=snr_db, family=family, wrong_form=wrong_form)
    kind, drifts = kind_of(machine, number=number, seed=seed, family=family)
    words = _words(machine, seed, family)
    for attempt in range(MOST_MACHINES):
        # Even last words: the odd one belongs to `kind_of`.
        generator = np.random.default_rng([*words, number, 2 * attempt])
        form = np.random.default_rng([*words, number, 2 * attempt, WRONG_FORM])
        angles = np.random.default_rng([*words, number, 2 * attempt, ANYWHERE]) if anywhere else None
        try:
            return _made(find_machine(machine), kind, drifts, number, snr_db, generator, (wrong_form, form), angles)
        except RotorwiseError:
            # A healthy machine that happens to be unstable is no machine that anybody runs.
            if attempt == MOST_MACHINES - 1:
                raise
    raise AssertionError


def kind_of(machine: str, *, number: int, seed: int, family: str) -> tuple[str, bool]:
    """Return the kind of a trial, and whether the machine drifts between its records."""
    words = _words(machine, seed, family)
    order = np.random.default_rng([*words, number // len(_TWENTY), 1]).permutation(len(_TWENTY))
    return _TWENTY[order[number % len(_TWENTY)]]


def _words(machine: str, seed: int, family: str) -> list[int]:
    return [FAMILIES.index(family), zlib.crc32(machine.encode()), seed]


def check(machine: str, *, seed: int, snr_db: float, family: str, wrong_form: float = 0.0) -> None:
    """Raise InvalidValueError for a value that is not allowed."""
    known = find_machine(machine)
    find_range(machine)
    if not 0 <= wrong_form <= 0.5:
        raise InvalidValueError(f"wrong_form = {wrong_form:g}; allowed: 0 to 0.5 of the stiffness. Correct it.")
    if wrong_form:
        supports_of(known)
    if not 0 <= seed < 2**32:
        raise InvalidValueError(f"seed = {seed}; allowed: 0 to {2**32 - 1}. Correct it.")
    if not (math.isfinite(snr_db) and -20 <= snr_db <= 120):
        raise InvalidValueError(f"snr_db = {snr_db:g}; allowed: -20 to 120. Correct it.")
    if family not in FAMILIES:
        raise InvalidValueError(f"family = {family!r}; allowed: {', '.join(FAMILIES)}. Name one of them.")


@dataclass(frozen=True, eq=False)
class Scene:
    """What all runs of one trial share."""

    how: TrialRange
    settings: tuple[Setting, ...]
    orders: np.ndarray
    turns: float
    snr_db: float
    seed: int
    known: dict[str, list[Simulation]] = field(default_factory=dict)

    def run(self, *machines: Machine) -> list[list[Simulation]]:
        """Return the motion of machines in every setting; of those that move alike once."""
        keys = [moves_as(machine, self.how) for machine in machines]
        new = {key: machine for key, machine in zip(keys, machines, strict=True) if key not in self.known}
        if new:
            self.known.update(zip(new, motions(tuple(new.values()), self.settings, self.how), strict=True))
        return [self.known[key] for key in keys]

    def lines(self, runs: Sequence[Simulation], machine: Machine, orders: Sequence[np.ndarray]) -> list[Lines]:
        """Return the lines of runs behind a chain that has the machine's sensor effects and no flaw else.

        ``orders`` are those of each setting.
        """
        found = []
        for stream, (run, setting) in enumerate(zip(runs, self.settings, strict=True)):
            record = clean_record(run, machine, setting, self.how, turns=self.turns, seed=self.seed, stream=stream)
            found.append(lines_of(record.signals, record.phase_rad, orders[stream], rate_hz=self.how.rate_hz))
        return found

    def d2(
        self,
        runs: Sequence[Simulation],
        machine: Machine,
        before: Sequence[Simulation],
        machine_before: Machine,
        effects: Sequence[Effect] = (),
    ) -> float:
        """Return the detectability of the change from one machine's runs to another's, that these effects make."""
        noise = [noise_of(run, self.snr_db) for run in runs]
        rows = kept(runs[0], self.how)
        orders = [
            with_stated(self.orders, effects, machine, speed_rpm=one.speed_rpm, turns=self.turns)
            for one in self.settings
        ]
        now, then = self.lines(runs, machine, orders), self.lines(before, machine_before, orders)
        return detectability(now, then, noise, rows)


def _made(
    machine: Machine,
    kind: str,
    drifts: bool,
    number: int,
    snr_db: float,
    generator: np.random.Generator,
    wrong_form: tuple[float, np.random.Generator],
    angles: np.random.Generator | None,
) -> TrialCase:
    how = find_range(machine.name)
    catalogue = applicable(machine, probes=how.recorded(machine))
    healthy = perturbed(machine, generator)
    if wrong_form[0]:
        healthy = with_wrong_form(healthy, wrong_form[0], how, wrong_form[1])
    pulse = 0.0
    if angles is not None:
        healthy, pulse = turned_anyhow(healthy, how.any_angle, angles), float(angles.uniform(-math.pi, math.pi))
    count = int(generator.integers(how.conditions[0], how.conditions[1] + 1))
    turns, seed = float(generator.uniform(*how.turns)), int(generator.integers(2**31))
    settings = _settings(how, count, generator)
    same_speeds = bool(generator.uniform() >= OTHER_SPEEDS)
    before = _nearby(settings, generator) if same_speeds else _settings(how, count, generator)
    channels = len(machine.bare_assembly().probes)
    gains = 1 + GAIN_DEVIATION * generator.normal(size=channels)
    scene = Scene(how, settings, orders_of(machine), turns, snr_db, seed)
    now = drifted(healthy, generator) if drifts else healthy
    plain = scene.run(now)[0]
    able = {name: parts for name, parts in catalogue.items() if name not in SHOWN_BY_WAVEFORM}
    weak = _weak(scene, now, plain, able, generator) if generator.uniform() < WITH_IMPERFECTION else None
    base = now.with_effects(weak.effect) if weak else now
    unhidden = scene.run(base)[0] if weak else plain
    runs, truth, hidden, redrawn = _hide(scene, base, unhidden, kind, catalogue, generator)
    acting = [one.effect for one in hidden]
    together = scene.d2(runs, truth, unhidden, base, acting) if hidden else 0.0
    common = {"how": how, "gains": gains, "snr_db": snr_db, "turns": turns, "seed": seed, "pulse_rad": pulse}
    sound = motions([healthy], before, how)[0]
    campaign = Campaign(
        tuple(recording(r, truth, s, stream=i, **common) for i, (r, s) in enumerate(zip(runs, settings, strict=True))),
        tuple(
            recording(r, healthy, s, stream=1000 + i, **common)
            for i, (r, s) in enumerate(zip(sound, before, strict=True))
        ),
        name=f"trial {number}",
    )
    return TrialCase(
        number=number,
        kind=kind,
        machine=machine,
        campaign=campaign,
        hidden=hidden,
        left_out=frozenset(one.effect.NAME for one in hidden) if kind == "unknown" else frozenset(),
        d2=together,
        imperfection=weak,
        drift_d2=scene.d2(plain, now, scene.run(healthy)[0], healthy) if drifts else 0.0,
        same_speeds=same_speeds,
        redrawn=redrawn,
    )


def _settings(how: TrialRange, count: int, generator: np.random.Generator) -> tuple[Setting, ...]:
    speeds, loads = how.draw_speeds(count, generator), how.draw_loads(count, generator)
    starts = generator.uniform(0.0, 0.9, size=count)
    return tuple(Setting(s, load, float(a)) for s, load, a in zip(speeds, loads, starts, strict=True))


def _nearby(settings: Sequence[Setting], generator: np.random.Generator) -> tuple[Setting, ...]:
    """Return settings whose speeds are off by 0.3 %, with the same loads."""
    return tuple(
        replace(
            one,
            speed_rpm=one.speed_rpm * (1 + 0.003 * float(np.clip(generator.normal(), -2, 2))),
            start_turn=float(generator.uniform(0.0, 0.9)),
        )
        for one in settings
    )


def _weak(
    scene: Scene,
    machine: Machine,
    plain: Sequence[Simulation],
    catalogue: dict[str, tuple[Effect, ...]],
    generator: np.random.Generator,
) -> Hidden | None:
    """Return an effect so weak that it cannot be found; None when a few trials find no such strength."""
    effect, wanted, share = drawn(catalogue, generator), float(generator.uniform(0.5, 3.0)), 0.1
    for _ in range(ROUNDS):
        weak = weakened(effect, share)
        changed = machine.with_effects(weak)
        try:
            d2 = scene.d2(scene.run(changed)[0], changed, plain, machine, [weak])
        except RotorwiseError:
            share /= 10
            continue
        if d2 <= BELOW_DETECTABILITY:
            return Hidden(weak, d2)
        share *= math.sqrt(wanted / d2)
    return None


def _hide(
    scene: Scene,
    base: Machine,
    unhidden: list[Simulation],
    kind: str,
    catalogue: dict[str, tuple[Effect, ...]],
    generator: np.random.Generator,
) -> tuple[list[Simulation], Machine, tuple[Hidden, ...], int]:
    """Return runs of the machine with hidden effects, that machine, the effects, and how many draws were refused."""
    if kind == "none":
        return unhidden, base, (), 0
    known = frozenset(effect.NAME for effect in base.effects)
    for redrawn in range(MOST_DRAWS):
        effects = [drawn(catalogue, generator, besides=known)]
        if kind == "two":
            effects.append(drawn(catalogue, generator, besides=known | {effects[0].NAME}))
        truth = base.with_effects(*effects)
        poorer = [base.with_effects(*(other for other in effects if other is not one)) for one in effects]
        try:
            first, *others = scene.run(truth, *(poorer if kind == "two" else ()))
            without = others or [unhidden]
            runs = with_wrong_law(scene.orders, first, without, effects, generator)
            # Of the effect alone: the other one's wrong law does not count.
            alone = zip(without, poorer, effects, strict=True)
            sizes = [scene.d2(first, truth, own, less, [effect]) for own, less, effect in alone]
        except RotorwiseError:
            continue
        if kind == "one" or min(sizes) >= DETECTABLE or redrawn >= DRAWS_FOR_IT - 1:
            hidden = tuple(Hidden(effect, size) for effect, size in zip(effects, sizes, strict=True))
            return runs, truth, hidden, redrawn
    raise InvalidValueError(f"Trial of {base.name}: {MOST_DRAWS} draws of effects could not be simulated; give a seed.")


def with_wrong_law(
    orders: np.ndarray,
    runs: Sequence[Simulation],
    without: Sequence[Sequence[Simulation]],
    effects: Sequence[Effect],
    generator: np.random.Generator,
) -> list[Simulation]:
    """Return runs in which every harmonic of each effect's change is wrong by some share; see the module's docstring.

    ``without`` holds, for each effect, the runs that lack it alone.
    """
    changed = [run.signals.copy() for run in runs]
    for effect, poorer in zip(effects, without, strict=True):
        wrong = LAW_ERROR * generator.normal(size=(orders.size, 2)) @ np.array([1, 1j]) / math.sqrt(2)
        if effect.STAGE not in ("structure", "force"):
            continue
        for signals, run, less in zip(changed, runs, poorer, strict=True):
            both = [lines_of(r.signals, r.phase_rad, orders, rate_hz=r.rate_hz).amplitudes for r in (run, less)]
            turning = np.exp(1j * orders[:, None] * run.phase_rad)
            signals += (((both[0] - both[1]) * wrong) @ turning).real
    return [replace(run, signals=signals) for run, signals in zip(runs, changed, strict=True)]

"""The answer of the gap engine: verdict, causes, what stays open, the gain, and what the pictures need."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...simulators.machine import Machine
from .lines import OrderLines

#: Possible verdicts.
KINDS = ("none", "one cause", "several causes", "unknown", "cannot tell")
#: A gain that is larger by so little is no larger: residuals are told no better.
AS_GOOD_DB = 0.3


@dataclass(frozen=True)
class Estimate:
    """One fitted parameter.

    Attributes
    ----------
    value, low, high : float
        Most probable value, and the ends of the 90 % interval, in ``unit``.
    unit : str
        "" for a pure number.
    is_told : bool
        False where these data hardly tell more than was known before them: the value is then no finding.
    """

    value: float
    low: float
    high: float
    unit: str
    is_told: bool = True


@dataclass(frozen=True)
class Cause:
    """An effect that explains the gap.

    Attributes
    ----------
    effect : str
        Name in the catalogue.
    at : str
        Part of the machine; empty when there is only one.
    probability : float
        That this effect is among the causes.
    parameters : mapping of str to Estimate
    check : str
        What to look at on the machine.
    """

    effect: str
    at: str
    probability: float
    parameters: Mapping[str, Estimate]
    check: str


@dataclass(frozen=True)
class AddedForce:
    """F (speed / reference)^p (load / reference)^q cos(n phi + psi): it describes lines which no effect explains.

    Attributes
    ----------
    order : float
        n, of the reference shaft.
    at, direction : str
        Place of the machine, and "x", "y", "axial" or "torsion".
    amplitude, phase : Estimate
        F in N (torsion: N.m) and psi in rad, at shaft angle 0.
    speed_exponent : Estimate
        p.
    load_exponent : Estimate, optional
        q; None where the load hardly changed: it is then taken as 0.
    reference_speed_rpm : float
    reference_load : float, optional
    or_at : tuple of str
        Other places from which a force explains the lines nearly as well.
    share : float
        Of the unexplained power of the order in the fitted conditions, that the forces of this order take away.
    """

    order: float
    at: str
    direction: str
    amplitude: Estimate
    phase: Estimate
    speed_exponent: Estimate
    load_exponent: Estimate | None
    reference_speed_rpm: float
    reference_load: float | None
    or_at: tuple[str, ...]
    share: float


@dataclass(frozen=True)
class LackingTerm:
    """One strength of something that healthy recordings ask for and the model lacks.

    Attributes
    ----------
    effect : str
        Name of one of those that are fitted to healthy recordings, "residual_unbalance" for example.
    at : str
        Place of the machine.
    strength : str
        Parameter of the effect.
    speed_exponent, reference_speed_rpm : float
        A spring grows with this power of the speed, up to the reference; 0 for what turns with the shaft.
    value : Estimate
        At the reference speed.
    order : float, optional
        Of what has one: periods in a revolution.
    """

    effect: str
    at: str
    strength: str
    speed_exponent: float
    reference_speed_rpm: float
    value: Estimate
    order: float | None = None


@dataclass(frozen=True)
class ModelForm:
    """What was added to the machine on its healthy recordings, before anything was diagnosed.

    Attributes
    ----------
    terms : tuple of LackingTerm
        Empty where the healthy recordings ask for none.
    missed_before, missed : float
        Share of a probe's healthy lines that the calibrated machine misses, without and with them; median of the
        probes.
    """

    terms: tuple[LackingTerm, ...]
    missed_before: float
    missed: float


@dataclass(frozen=True)
class ResidualLine:
    """A line that the calibrated machine without any effect gets wrong.

    Attributes
    ----------
    probe : str
    order : float
        Multiple of the shaft's speed in that condition.
    condition, column : int
        Numbers of the condition and of the line in the lines.
    measured, simulated : complex
        Amplitudes in the probe's SI unit.
    sigma : float
        Their distance in standard deviations of everything uncertain.
    """

    probe: str
    order: float
    condition: int
    column: int
    measured: complex
    simulated: complex
    sigma: float


@dataclass(frozen=True)
class Gain:
    """How much closer the extended machine comes to conditions that it was not fitted to.

    All in dB of residual power against the machine as given; positive is better. NaN where not computed.

    Attributes
    ----------
    held_out_db : float
        By the extended machine.
    calibration_only_db : float
        By calibrating the machine's own parameters and the probes' gains.
    wrong_effect_db : float
        By the best effect of another name: a placebo.
    smooth_function_db : float
        By a smooth function of speed with as many parameters: a placebo.
    held_out : tuple of int
        Numbers of the conditions that were not fitted.
    """

    held_out_db: float
    calibration_only_db: float
    wrong_effect_db: float
    smooth_function_db: float
    held_out: tuple[int, ...]


@dataclass(frozen=True)
class Score:
    """Two figures of one hypothesis, natural logarithms of densities.

    Attributes
    ----------
    log_evidence : float
        Of all fitted conditions together.
    log_prediction : float
        Of each fitted condition given the others, summed.
    log_held_out : float
        Of the held-out conditions given the fitted ones; NaN where it was not computed.
    """

    log_evidence: float
    log_prediction: float
    log_held_out: float = math.nan


@dataclass(frozen=True)
class DetectionLimit:
    """From which size on an effect would have shown.

    Attributes
    ----------
    effect, at, parameter, unit : str
        Its name, part, and the strength that is meant, the others being absent.
    size : float
        The strength's distance from its value without the effect. Infinite where no size within three deviations of
        its prior shows.
    """

    effect: str
    at: str
    parameter: str
    unit: str
    size: float


@dataclass(frozen=True, eq=False)
class GapResult:
    """What a simulated machine gets wrong about a measured one, and why.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    causes : tuple of Cause
        Most probable first; empty for "none". For "unknown" those beside which something unknown acts, if any.
    probabilities : mapping of tuple of str to float
        Of every hypothesis compared, by sorted names of its effects; () is "nothing is wrong", ("unknown",) is
        "something outside the catalogue". They sum to 1.
    indistinguishable : tuple of tuple of str
        Sets of effects that these data cannot tell apart.
    next_measurement : str
        What to record to tell them apart, or to be able to tell at all; empty when nothing is open.
    sentence : str
        The verdict in plain words.
    residuals : tuple of ResidualLine
        Largest first.
    gain : Gain
    detectability : float
        d2: squared size of the fitted response in standard deviations of everything uncertain.
    misfit : float
        Chance of a residual as large as what the verdict leaves.
    measured : OrderLines
        In the conditions to explain.
    before, after : ndarray (conditions, probes, orders), complex
        Simulated lines: by the calibrated machine, and by the extended one (equal where nothing was added).
    machine : Machine
        As given.
    calibrated : Machine
        With its own parameters fitted.
    extended : Machine
        With the fitted effects, or with forces for what no effect explains: simulates.
    not_compared : mapping of str to str
        Effects of the catalogue that were left out, with the reason.
    remarks : tuple of str
    empirical : tuple of AddedForce
        For "unknown": the forces that ``extended`` has for what no effect explains.
    scores : mapping of tuple of str to Score
        Evidence, and prediction of each condition from the others, of the hypotheses that were fitted.
    flawed : tuple of str
        Channels whose waveform shows a defect that no effect that competes makes.
    form : ModelForm, optional
        What the healthy recordings say that the model lacks; None where that was not looked for.
    detection_limits : tuple of DetectionLimit
        For "none" and "cannot tell": what would have shown.
    """

    kind: str
    causes: tuple[Cause, ...]
    probabilities: Mapping[tuple[str, ...], float]
    indistinguishable: tuple[tuple[str, ...], ...]
    next_measurement: str
    sentence: str
    residuals: tuple[ResidualLine, ...]
    gain: Gain
    detectability: float
    misfit: float
    measured: OrderLines
    before: np.ndarray
    after: np.ndarray
    machine: Machine
    calibrated: Machine
    extended: Machine
    not_compared: Mapping[str, str]
    remarks: tuple[str, ...] = ()
    empirical: tuple[AddedForce, ...] = ()
    scores: Mapping[tuple[str, ...], Score] = field(default_factory=dict)
    flawed: tuple[str, ...] = ()
    form: ModelForm | None = None
    detection_limits: tuple[DetectionLimit, ...] = ()

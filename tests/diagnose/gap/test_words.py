"""The result in words and as JSON: what is said follows from the numbers, nothing is rounded to certainty."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console
from rotorwise.diagnose.gap import words
from rotorwise.diagnose.gap.coordinates import Coordinate, coordinates_of
from rotorwise.diagnose.gap.form_words import form_words
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.json_form import as_json
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.refine import Fit
from rotorwise.diagnose.gap.result import KINDS, Estimate, Gain, LackingTerm, ModelForm, ResidualLine
from rotorwise.diagnose.gap.terminal import show
from rotorwise.diagnose.gap.words import (
    NOTABLE_SIGMA,
    alternative_words,
    cause_words,
    estimate_words,
    gain_words,
    gap_words,
    headline,
    line_names,
    line_words,
    mesh_orders,
    not_compared_words,
    parameter_label,
    probability_words,
    sentence_of,
    verdict_words,
)
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.machine import find_machine

from .made_results import CONDITIONS, GAIN, made

MACHINE = find_machine("amb_rotor")
SHAPE = (len(CONDITIONS), 1, 9)
WORDED = OrderLines(
    CONDITIONS, ("path_1",), (0.5, *map(float, range(1, 9))), np.zeros(SHAPE, dtype=complex), np.ones(SHAPE)
)
ANY = st.floats(allow_nan=True, allow_infinity=True)


def residual(order: float, measured: complex, simulated: complex, *, sigma: float = 50.0, condition: int = 0):
    return ResidualLine("path_1", order, condition, WORDED.orders.index(order), measured, simulated, sigma)


def _in(conditions: tuple[Condition, ...]) -> OrderLines:
    return replace(
        WORDED,
        conditions=conditions,
        amplitudes=WORDED.amplitudes[: len(conditions)],
        deviations=WORDED.deviations[: len(conditions)],
    )


# ---- the gap ----


def test_lines_without_phase_are_named_by_where_they_stand() -> None:
    kinds = (
        LineKind(),
        LineKind(phase=False, envelope=True),
        LineKind(phase=False, frequency_hz=100.0),
        LineKind(phase=False, frequency_hz=-5.0),
        LineKind(phase=False, envelope=True, frequency_hz=5.0),
    )
    shape = (1, 1, len(kinds))
    # The same order twice, and two lines of order 0: only the column tells them apart.
    lines = OrderLines(
        CONDITIONS[:1], ("path_1",), (2.95, 2.95, 0.0, 1.0, 0.0), np.ones(shape, dtype=complex), np.ones(shape), kinds
    )
    names = ["2.95X", "envelope, 2.95X", "100 Hz", "1X - 5 Hz", "envelope, 5 Hz"]
    assert line_names(lines) == names
    for column, name in enumerate(names):
        wrong = ResidualLine("path_1", 2.95, 0, column, 3.0, 1.0, 50.0)
        assert gap_words([wrong], lines, MACHINE, whole=4).endswith(f"the model lacks {name}.")


def test_a_line_is_lacking_too_much_or_turned() -> None:
    lines = [residual(1.0, 3.0, 1.0), residual(2.0, 1.0, 3.0), residual(3.0, 1.0, -1.0)]
    said = gap_words(lines, WORDED, MACHINE, whole=4)
    assert said == "At 1500 rpm the model lacks 1X, has too much 2X and gets the phase wrong of 3X."


def test_only_notable_lines_are_named_and_the_clearest_first() -> None:
    lines = [
        residual(2.0, 3, 1, sigma=9),
        residual(1.0, 3, 1, sigma=90),
        residual(3.0, 3, 1, sigma=NOTABLE_SIGMA - 0.1),
    ]
    assert "lacks 1X and 2X." in gap_words(lines, WORDED, MACHINE, whole=4)
    assert "No line by itself differs" in gap_words(lines[2:], WORDED, MACHINE, whole=4)
    many = [residual(float(k), 3, 1) for k in range(1, 8)]
    assert gap_words(many, WORDED, MACHINE, whole=4).endswith("; 3 more lines are wrong.")


def test_conditions_are_named_by_speed_and_by_load_where_it_varies() -> None:
    where = [residual(1.0, 3, 1, condition=i) for i in (2, 0)]
    assert gap_words(where, WORDED, MACHINE, whole=4).startswith("At 1500 and 3300 rpm")
    assert gap_words(where, WORDED, MACHINE, whole=2).startswith("In all 2 fitted conditions")
    loaded = (Condition(1500.0, 10.0), Condition(1500.0), Condition(1500.0, 50.0))
    assert gap_words(where, _in(loaded), MACHINE, whole=3).startswith("At 1500 rpm, load 10 and 1500 rpm, load 50")


@given(st.integers(1, 4), st.integers(-3, 3))
def test_lines_beside_a_tooth_mesh_carry_its_name(multiple: int, side: int) -> None:
    gears = mesh_orders(find_machine("gearbox"))
    mesh = gears[0]
    assert len(gears) == 1
    assert mesh > 6
    name = line_words(multiple * mesh + side, gears)
    assert name.split(" ")[0] == ("mesh" if multiple == 1 else str(multiple))
    assert name.endswith("mesh" if side == 0 else f"{'+' if side > 0 else '-'} {abs(side)}X")
    assert line_words(side % 4 + 1.0, gears) == f"{side % 4 + 1}X"


def test_lines_that_differ_only_together_are_said_to() -> None:
    result = made("one cause")
    small = tuple(replace(one, sigma=NOTABLE_SIGMA / 2) for one in result.residuals)
    differ = f"No line by itself differs from the model by {NOTABLE_SIGMA:g} standard deviations. Together they do. "
    assert verdict_words(replace(result, residuals=small)).startswith(differ)
    # Clipping is seen in the record, not in its lines.
    seen = replace(result, residuals=small, causes=(replace(result.causes[0], effect="clipping"),))
    assert "Together" not in verdict_words(seen)
    assert "Together" not in verdict_words(made("none"))


# ---- values ----


def _fit(coordinates: tuple[Coordinate, ...], variances: list[float]) -> Fit:
    """Return a fit of whose figures only position and covariance matter."""
    bare = np.zeros(0)
    candidate = Candidate(effect_catalogue()["unbalance"](), coordinates)
    return Fit((candidate,), np.zeros(len(coordinates)), np.diag(variances), bare, bare, 0.0, bare, bare)


def test_data_that_leave_the_prior_as_it_was_tell_nothing() -> None:
    moment, angle, _ = coordinates_of(effect_catalogue()["unbalance"].parameters())
    circle = math.pi**2 / 3
    assert [_fit((moment, angle), [v, circle * v]).tells(i) for v in (0.5, 0.9) for i in (0, 1)] == [
        True,
        True,
        False,
        False,
    ]
    assert _fit((angle,), [circle * 0.9]).interval(0) == (-math.pi, math.pi)
    low, high = _fit((angle,), [0.01]).interval(0)
    assert high - low == pytest.approx(2 * 1.645 * 0.1, rel=1e-3)


def test_a_value_far_out_in_its_prior_is_told_whatever_the_slopes_say() -> None:
    every = coordinates_of(effect_catalogue()["rub"].parameters())
    gap = next(one for one in every if one.parameter.name == "interference_m")
    assert not _fit((gap,), [0.9]).tells(0)
    assert replace(_fit((gap,), [0.9]), position=np.array([-3.2])).tells(0)


def test_the_verdict_states_no_value_that_is_not_told() -> None:
    cause = made("one cause").causes[0]
    names = list(cause.parameters)
    open_first = {names[0]: replace(cause.parameters[names[0]], is_told=False)}
    assert parameter_label(names[0], cause.parameters[names[0]].unit) in cause_words(cause)
    second = cause_words(replace(cause, parameters={**cause.parameters, **open_first}))
    assert second.startswith(f"unbalance at disc, {parameter_label(names[1], 'rad')} ")
    assert cause_words(replace(cause, parameters=open_first)) == "unbalance at disc"


@given(st.floats(1e-12, 1.0, exclude_max=True))
def test_no_probability_is_rounded_to_certainty(p: float) -> None:
    for shown in (p, 1 - p):
        words = probability_words(shown)
        assert words not in ("0.00", "1.00") or shown in (0.0, 1.0)


def test_values_are_said_in_readable_units() -> None:
    assert estimate_words(Estimate(math.pi / 4, 0.5, 1.0, "rad")) == "45 deg (28.6 to 57.3)"
    assert estimate_words(Estimate(2e-3, -1e-3, 5e-3, "m")) == "2 mm (-1 to 5)"
    assert estimate_words(Estimate(1.1e-4, 0.9e-4, 1.3e-4, "kg.m")) == "0.00011 kg.m (9e-05 to 0.00013)"


@pytest.mark.parametrize("name", sorted(effect_catalogue()))
def test_labels_lose_the_unit_and_nothing_else(name: str) -> None:
    for one in effect_catalogue()[name].parameters():
        label = parameter_label(one.name, one.unit)
        assert label
        assert one.name.replace("_", " ").startswith(label)


@pytest.mark.parametrize(
    ("gain", "words"),
    [
        (GAIN, "Held-out error falls by 11.8 dB; calibration alone gives 0.6 dB."),
        (Gain(-2.0, -2.5, -3.0, -4.0, (1,)), "Held-out error rises by 2.0 dB; calibration alone gives -2.5 dB."),
        (Gain(0.5, 0.6, -3.0, -4.0, (1,)), "no gain is claimed, as calibration alone does as well"),
        (replace(GAIN, wrong_effect_db=12.0), "no gain is claimed, as the best wrong effect does as well"),
        (
            replace(GAIN, wrong_effect_db=12.0, smooth_function_db=13.0),
            "no gain is claimed, as the best wrong effect and a smooth function of speed do as well",
        ),
        (replace(GAIN, held_out=()), "in the fitted conditions (none was held out) falls"),
        (replace(GAIN, calibration_only_db=-0.01), "calibration alone gives 0.0 dB"),
        (Gain(math.nan, 1.0, 1.0, 1.0, ()), "No gain was computed."),
    ],
)
def test_gain_is_claimed_only_against_placebos(gain: Gain, words: str) -> None:
    assert words in gain_words(gain)
    assert ("no gain is claimed" in gain_words(gain)) == ("no gain is claimed" in words)


# ---- the whole ----


def test_verdict_of_one_cause_says_gap_cause_what_is_open_and_gain() -> None:
    assert verdict_words(made("one cause")) == (
        "In all 3 fitted conditions the model lacks 1X. Cause: unbalance at disc, moment 0.00011 kg.m (8.8e-05 to "
        "0.000132), probability 0.97. Not distinguishable here: unbalance or shaft bow + unbalance. To tell: A "
        "recording at 1200 rpm would separate them. Held-out error falls by 11.8 dB; calibration alone gives 0.6 dB."
    )


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("none", "The model explains the data, probability 0.96"),
        ("several causes", "Causes: unbalance at disc"),
        ("unknown", "explains, clearest in 1X at path_1 and 1500 rpm, probability 0.93"),
        ("cannot tell", "cannot tell why: nothing is wrong 0.40, unbalance 0.35, shaft bow 0.25"),
    ],
)
def test_every_kind_has_its_own_headline(kind: str, words: str) -> None:
    assert words in headline(made(kind))
    assert headline(made(kind)) in verdict_words(made(kind))


def test_the_engine_s_own_sentence_counts() -> None:
    assert sentence_of(replace(made("none"), sentence="As it is.")) == "As it is."


def test_effects_left_out_for_one_reason_are_named_together() -> None:
    assert not_compared_words({"rub": "no b.", "oil_whirl": "no b", "crack": "c"}) == [
        "rub, oil whirl: no b.",
        "crack: c.",
    ]


@pytest.mark.parametrize("kind", KINDS)
def test_terminal_fits_80_columns_and_holds_every_value(kind: str) -> None:
    result, screen = made(kind), io.StringIO()
    show(result, Console(file=screen, width=80, highlight=False), notes=("Channel [b]x[/b] is not compared.",))
    text = screen.getvalue()
    assert max(map(len, text.splitlines())) <= 80
    flat = " ".join(text.split())
    assert sentence_of(result) in flat
    assert "[b]x[/b]" in text
    for cause in result.causes:
        assert cause.effect in text
        for name, one in cause.parameters.items():
            assert f"{parameter_label(name, one.unit)} {estimate_words(one)}" in flat
        assert cause.check in flat.replace("check ", "")


@pytest.mark.parametrize("kind", KINDS)
def test_json_has_the_stated_keys(kind: str) -> None:
    result = made(kind)
    formed = json.loads(json.dumps(as_json(result), allow_nan=False))
    assert set(formed["verdict"]) == {"kind", "sentence", "causes", "indistinguishable", "next_measurement"}
    assert formed["verdict"]["kind"] == kind
    assert {"held_out_db", "calibration_only_db"} <= set(formed["gain"])
    assert [one["effect"] for one in formed["verdict"]["causes"]] == [one.effect for one in result.causes]
    for one, cause in zip(formed["verdict"]["causes"], result.causes, strict=True):
        assert one["probability"] == cause.probability
        for name, value in cause.parameters.items():
            assert one["parameters"][name] == {
                "value": value.value,
                "low": value.low,
                "high": value.high,
                "unit": value.unit,
                "is_told": value.is_told,
            }
    assert len(formed["residuals"]) == len(result.residuals)
    assert formed["calibration"]["coupling_stiffness_n_m"]["fitted"] == 81010.2


@given(held_out=ANY, sigma=ANY, value=ANY, probability=ANY)
@settings(max_examples=60, deadline=None)
def test_numbers_of_any_kind_make_words_and_json(
    held_out: float, sigma: float, value: float, probability: float
) -> None:
    result = made("one cause")
    cause = result.causes[0]
    wild = replace(cause, probability=probability, parameters={"angle_rad": Estimate(value, -value, value, "rad")})
    result = replace(
        result,
        causes=(wild,),
        gain=replace(result.gain, held_out_db=held_out),
        residuals=tuple(replace(one, sigma=sigma) for one in result.residuals),
    )
    json.dumps(as_json(result), allow_nan=False)
    assert verdict_words(result)
    show(result, Console(file=io.StringIO(), width=80))


def test_each_line_counts_alike_in_what_is_wrong_with_it() -> None:
    # Four lines that are lacking at low speeds, one that is right, and large, at a resonance.
    lines = [ResidualLine("path_1", 1.0, i, 0, 20e-6, 1.5e-6, 200.0) for i in range(4)]
    lines.append(ResidualLine("path_1", 1.0, 4, 0, 200e-6, 220e-6j, 50.0))
    assert words._how_wrong(lines) == "lacks"
    assert words._how_wrong(lines[4:]) == "gets the phase wrong of"
    # Half of one line and twice the other: neither lacks nor too much.
    pair = [ResidualLine("path_1", 1.0, i, 0, 20e-6 / (1 + i), 10e-6 * (1 + i), 50.0) for i in range(2)]
    assert words._how_wrong(pair) == "gets the size wrong of"


def test_a_model_that_is_not_this_machine_is_said_to_be() -> None:
    assert form_words(None) == ""
    assert form_words(ModelForm((), 0.1, 0.1)) == ""
    assert "misses 90% of the healthy lines" in form_words(ModelForm((), 0.9, 0.9))
    value = Estimate(-2e4, -3e4, -1e4, "N/m")
    term = LackingTerm("empirical_stiffness", "bearing_1", "cross_n_m", 2.0, 4000.0, value)
    text = form_words(ModelForm((term,), 0.3, 0.02))
    assert "misses 30.0% of their lines, and 2.0% with" in text
    assert "cross-coupled stiffness at bearing_1 growing as speed^2, -2e+04 N/m (-3e+04 to -1e+04) at 4000 rpm" in text
    assert "hardly is this machine" not in text


def test_what_is_not_told_apart_is_given_with_its_values():
    cause = made("one cause").causes[0]
    said = alternative_words([cause])
    assert said.startswith(f"Not told apart: it may as well be {cause.effect.replace('_', ' ')}")
    for name, own in cause.parameters.items():
        assert (estimate_words(own) in said) == own.is_told, name


@pytest.mark.parametrize(("placebo_db", "claimed"), [(12.0, True), (15.9, False), (17.0, False)])
def test_a_gain_that_a_placebo_comes_close_to_is_not_claimed(placebo_db, claimed):
    gain = replace(GAIN, held_out_db=16.0, calibration_only_db=1.0, wrong_effect_db=placebo_db, smooth_function_db=0.0)
    assert ("no gain is claimed" not in gain_words(gain)) == claimed

"""In words: what healthy recordings say that the model lacks, and whether it is this machine at all."""

from __future__ import annotations

from ...simulators.effects.residual_coupling_harmonic import FORCES, MOMENTS
from .result import LackingTerm, ModelForm
from .words import estimate_words

#: A model that misses a larger share of its healthy lines is said to be poor.
POOR = 0.5
#: Of more terms than this only those are said that are not 0.
ALL_SAID = 8
_STRENGTHS = {
    "stiffness_n_m": "stiffness",
    "difference_n_m": "half of stiffness in x less y",
    "cross_n_m": "cross-coupled stiffness",
    "damping_n_s_m": "damping",
    "moment_x_kg_m": "residual unbalance along x",
    "moment_y_kg_m": "residual unbalance along y",
    "force_x_n": "residual force of the coupling along x",
    "force_y_n": "residual force of the coupling along y",
    **{
        f"{way}_{part}_{unit}": f"{what} {words}, {part} part"
        for what, unit, ways in (
            ("residual force between the ends", "n", FORCES),
            ("residual moment between the ends", "n_m", MOMENTS),
        )
        for way, words in ways.items()
        for part in ("cosine", "sine")
    },
    "sine_m": "residual run-out of the gear, sine part",
    "cosine_m": "residual run-out of the gear, cosine part",
    "first_sine_m": "error of the teeth at the mesh order, sine part",
    "first_cosine_m": "error of the teeth at the mesh order, cosine part",
    "second_sine_m": "error of the teeth at twice the mesh order, sine part",
    "second_cosine_m": "error of the teeth at twice the mesh order, cosine part",
    "third_sine_m": "error of the teeth at 3 times the mesh order, sine part",
    "third_cosine_m": "error of the teeth at 3 times the mesh order, cosine part",
    "stiffness_share": "share of the mesh stiffness",
    "gravity_m_s2": "gravity",
}


def form_words(form: ModelForm | None) -> str:
    """Return what was added to the machine on the healthy recordings, and whether it still misses most of them.

    Empty where nothing was added and the model is good enough.
    """
    if form is None:
        return ""
    poor = (
        f"Calibrated, the model still misses {form.missed:.0%} of the healthy lines: it hardly is this machine, and "
        "only what changes clearly since then is told."
    )
    if not form.terms:
        return poor if form.missed > POOR else ""
    told = [one for one in form.terms if len(form.terms) <= ALL_SAID or one.value.low > 0 or one.value.high < 0]
    words = [_term_words(one) for one in told]
    if len(told) < len(form.terms):
        words.append(f"and {len(form.terms) - len(told)} more that they do not tell from 0")
    return (
        f"The healthy recordings show what the model lacks: calibrated, it misses {form.missed_before:.1%} of their "
        f"lines, and {form.missed:.1%} with what was added before anything was diagnosed: {'; '.join(words)}."
        + (f" {poor}" if form.missed > POOR else "")
    )


def _term_words(one: LackingTerm) -> str:
    grows = f" growing as speed^{one.speed_exponent:g}" if one.speed_exponent else ""
    at = f" at {one.reference_speed_rpm:.0f} rpm" if grows else ""
    place = f" at {one.at}" if one.at else ""
    multiple = f" {one.order:g}X" if one.order is not None else ""
    return f"{_STRENGTHS[one.strength]}{multiple}{place}{grows}, {estimate_words(one.value)}{at}"

"""Do detection limits hold? Hides effects of a multiple of the limit that a campaign of the healthy machine states.

    python tests/benchmarks/gap_limits.py MACHINE SEED NUMBER [MULTIPLE ...]

Takes the trial of this number that hides nothing, asks for its limits, hides the first strength of every effect alone
at the part where it shows last, in the same campaign, and prints the verdict for each multiple of the limit (1 and 2).
"""

from __future__ import annotations

import math
import sys
from unittest import mock

from rotorwise.diagnose.gap.coordinates import coordinates_of, values_at
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.result import DetectionLimit
from rotorwise.diagnose.gap.trials import cases
from rotorwise.simulators.effect import Effect, effect_catalogue

SNR_DB = 20.0


def main(machine: str, seed: int, number: int, multiples: list[float]) -> None:
    """Print a row for every effect and multiple, and the share that was named."""
    case = cases.make_case(machine, number=number, seed=seed, snr_db=SNR_DB, anywhere=True)
    answer = explain_gap(case.campaign, case.machine)
    print(machine, number, case.kind, [one.effect.NAME for one in case.hidden], "verdict", answer.kind, flush=True)
    shown: dict[tuple[str, str], DetectionLimit] = {}
    for one in answer.detection_limits:
        if math.isfinite(one.size):
            key = one.effect, one.parameter
            shown[key] = max(one, shown.get(key, one), key=lambda limit: limit.size)
    for multiple in multiples:
        named = [_is_named(machine, seed, number, one, multiple) for one in shown.values()]
        print(f"{multiple:g} x limit: {sum(named)} of {len(named)} named", flush=True)


def _is_named(machine: str, seed: int, number: int, limit: DetectionLimit, multiple: float) -> bool:
    effect = _of_size(limit, multiple)

    def hidden(scene, base, unhidden, kind, catalogue, generator):  # type: ignore[no-untyped-def]
        changed = base.with_effects(effect)
        return scene.run(changed)[0], changed, (cases.Hidden(effect, math.nan),), 0

    with mock.patch.object(cases, "_hide", hidden):
        case = cases.make_case(machine, number=number, seed=seed, snr_db=SNR_DB, anywhere=True)
    answer = explain_gap(case.campaign, case.machine)
    top = sorted(answer.probabilities.items(), key=lambda item: -item[1])[:3]
    told = ", ".join(f"{'+'.join(names) or 'nothing'} {p:.2f}" for names, p in top)
    print(
        f"  {limit.effect} at {limit.at}, {limit.parameter} {multiple * limit.size:.3g}, d2 {case.d2:.3g}: {told}",
        flush=True,
    )
    together = {name for names in answer.indistinguishable for name in names}
    return limit.effect in together | {one.effect for one in answer.causes}


def _of_size(limit: DetectionLimit, multiple: float) -> Effect:
    """Return the effect with this strength alone, other values in the middle of their priors."""
    effect = effect_catalogue()[limit.effect](at=limit.at)
    coordinates = coordinates_of(effect.parameters())
    values = values_at(coordinates, [0.0] * len(coordinates))  # type: ignore[arg-type]
    for one in effect.parameters():
        if one.zero is not None and one.name in values:
            values[one.name] = one.zero
        if one.name == limit.parameter:
            values[one.name] = (one.zero or 0.0) + multiple * limit.size
    return effect.with_values(**values)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), [float(one) for one in sys.argv[4:]] or [1.0, 2.0])

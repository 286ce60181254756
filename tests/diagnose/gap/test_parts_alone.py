"""What was found beside another effect is asked what it does alone."""

from dataclasses import replace

import numpy as np
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.parts_alone import parts_alone
from rotorwise.diagnose.gap.refine import Fit, refined
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.effects.shaft_bow import ShaftBow

from .made_campaigns import recorded, search_inputs


def test_a_cause_that_was_met_beside_another_effect_only_stands_alone() -> None:
    speeds, hidden = (1200.0, 1800.0, 2500.0), ShaftBow(bow_m=3e-5, angle_rad=0.8)
    bent, sound = amb_rotor.with_effects(hidden), amb_rotor
    measured, before = (
        recorded(machine, speeds, rate_hz=4000.0, duration_s=1.0, seed=seed)
        for machine, seed in ((bent, 5), (sound, 1))
    )
    campaign = Campaign(measured, before)
    problem, screening, *_ = search_inputs(campaign, amb_rotor, only=frozenset(("shaft_bow", "run_out")))
    first = {
        name: next(o[0] for o in screening.best() if o[0].candidate.name == name) for name in ("run_out", "shaft_bow")
    }

    def fit(*names: str) -> Fit:
        chosen, start = [first[name].candidate for name in names], [first[name].position for name in names]
        machine, predictor = problem.baseline.machine, problem.predictor
        found = refined(chosen, np.concatenate(start), problem.plain(), machine, predictor)
        assert found is not None
        return found

    pair, run_out = fit("run_out", "shaft_bow"), fit("run_out")
    alone = parts_alone([pair], [run_out], problem)
    assert alone[0].names == ("shaft_bow",)
    # The other one adds nothing that it would be named for.
    assert alone[0].log_evidence > pair.log_evidence - 5
    assert sorted(one.names for one in alone) == [("run_out",), ("shaft_bow",)]
    # Nothing is asked where a single effect leads.
    ahead = replace(run_out, log_evidence=pair.log_evidence + 1)
    assert parts_alone([pair], [ahead], problem) == [ahead]

"""Where something unknown acts: between the halves of a coupling, at a disc, or not told."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import Baseline
from rotorwise.diagnose.gap.evidence import comparison
from rotorwise.diagnose.gap.force_kernels import force_kernels, turning_kernels
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.located import located_words, places_of
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.unknown_force import unexplained
from rotorwise.simulators import test_rig
from rotorwise.simulators.effect import Effect
from rotorwise.simulators.effects.coupling_misalignment import CouplingMisalignment
from rotorwise.simulators.effects.rotating_coupling_force import RotatingCouplingForce
from rotorwise.simulators.effects.unbalance import Unbalance

CONDITIONS = tuple(Condition(speed) for speed in (1100.0, 1500.0, 2000.0, 2600.0))


@pytest.mark.parametrize(
    ("effect", "place"),
    [
        (CouplingMisalignment(offset_m=1e-4, offset_phase_rad=0.4, angle_rad=2e-3, angle_phase_rad=-1.0), "coupling"),
        (RotatingCouplingForce(force_n=5.0, angle_rad=0.3), "coupling_hub"),
        (Unbalance(at="disc", moment_kg_m=1e-4, angle_rad=0.4), "disc"),
    ],
)
def test_a_force_is_where_it_acts(effect: Effect, place: str) -> None:
    probes = tuple(p.name for p in test_rig.bare_assembly().probes if p.quantity == "acceleration")
    count = len(CONDITIONS)
    predictor = Predictor(CONDITIONS, probes, (1.0,), (4000.0,) * count, (8000,) * count, (LineKind(),), (0,))
    own, changed = (predictor.amplitudes(one) for one in (test_rig, test_rig.with_effects(effect)))
    noise = 1e-3 * np.abs(changed - own).max()
    generator = np.random.default_rng(1)
    error = noise * (generator.normal(size=own.shape) + 1j * generator.normal(size=own.shape))
    lines = OrderLines(CONDITIONS, probes, (1.0,), changed + error, np.full(own.shape, noise))
    # A machine of which nothing is uncertain.
    none = np.zeros(0)
    exact = Baseline(test_rig, (), none, none, none > 0, own, np.zeros((0, *own.shape), complex), none, none, none)
    compared = comparison(lines, exact, None, None, np.full(own.shape[1:], 1e-3 * noise))
    kernels = (*force_kernels(test_rig, predictor), *turning_kernels(test_rig, predictor))
    found = unexplained(compared, force_kernels(test_rig, predictor))
    assert places_of(compared, found, kernels) == {place: [0]}
    # Of two places that make the same lines neither is told.
    twins = [replace(one, at="elsewhere") for one in kernels if one.at == place]
    assert places_of(compared, found, (*kernels, *twins)) == {}
    (said,) = located_words(compared, found, test_rig, predictor)
    assert ("misaligned coupling" in said) == place.startswith("coupling")
    assert "1X" in said

"""The contract of every effect on every machine that it fits. There is no opt-out.

Adding an effect adds its rows here by itself: the catalogue is scanned.
"""

import functools
import inspect
import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effect import STAGES, effect_catalogue, make_effect
from rotorwise.simulators.errors import InvalidValueError, RotorwiseError
from rotorwise.simulators.machine import machine_catalogue, machine_from_toml
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from rotorwise.simulators.solvers.simulate import simulate_batch
from rotorwise.simulators.solvers.stepper import LaneGroup, Stepper
from rotorwise.simulators.speed_profile import steady

EFFECTS = {name: effect for name, effect in effect_catalogue().items() if effect.STAGE not in ("sensor", "speed")}
MACHINES = machine_catalogue()
#: A running speed well inside each machine's range; another one needs a row here only if this does not suit it.
SPEED_RPM = 1800.0
TURNS = 12


def fits(machine, effect):
    try:
        effect().contribute(machine.bare_assembly())
    except MissingPartError:
        return False
    return True


PAIRS = [(m, e) for m, machine in MACHINES.items() for e, effect in EFFECTS.items() if fits(machine, effect)]
pairs = pytest.mark.parametrize(("machine", "effect"), PAIRS, ids=[f"{m}-{e}" for m, e in PAIRS])


@functools.cache
def settled(machine):
    """Return a stepper's states after the machine's settling time, without effects."""
    bare = MACHINES[machine]
    run = stepper(bare, step_s=bare.definition.step_s)
    steps = math.ceil(min(bare.definition.settle_s, 0.5) / bare.definition.step_s)
    while run.done < steps:
        run.advance(min(run.block, steps - run.done))
    return run.form.basis @ run.states


def stepper(machine, *, step_s):
    profile = steady(speed_rpm=SPEED_RPM)
    return Stepper(LaneGroup([machine], [profile], [machine.system(speed_rpm=profile)]), step_s=step_s, start_s=0.0)


def run_from(machine, start, *, step_s, duration_s, states=False):
    run = stepper(machine, step_s=step_s)
    # An effect may add coordinates; they start at rest.
    full = np.zeros((run.system.states, 1))
    known = len(run.system.coordinates), start.shape[0]
    if known[1] == full.shape[0]:
        full[:] = start
    run.states[:] = run.form.inverse @ full
    steps = round(duration_s / step_s)
    parts = []
    while run.done < steps:
        parts.append(run.advance(min(run.block, steps - run.done)))
    if states:
        return run.form.basis @ run.states
    return np.concatenate(parts)[:, :, 0]


@pytest.mark.parametrize("name", EFFECTS)
def test_declaration(name):
    effect = EFFECTS[name]
    assert inspect.getmodule(effect).__name__.rpartition(".")[2] == name
    assert effect.STAGE in STAGES
    assert effect.ROLE
    assert effect.MEANING.endswith(".")
    assert effect.CHECK.endswith("?") or effect.CHECK.endswith(".")
    assert effect.REFERENCES
    assert all(isinstance(rival, str) and separates for rival, separates in effect.RIVALS.items())
    parameters = effect.parameters()
    assert any(p.zero is not None for p in parameters), "no strength"
    for p in parameters:
        assert p.meaning
        assert p.source
        if p.prior is None:
            # A number that is given with the machine (how many vanes), not estimated.
            assert p.zero is None
            continue
        assert p.bounds[0] <= p.prior.median <= p.bounds[1]
        assert p.default == p.prior.median
        draws = [p.prior.sample(np.random.default_rng(seed)) for seed in range(50)]
        assert np.mean([p.bounds[0] <= draw <= p.bounds[1] for draw in draws]) > 0.8
        assert all(np.isfinite(p.prior.log_density(draw)) for draw in draws)
        with pytest.raises(InvalidValueError, match=p.name):
            effect(**{p.name: p.bounds[1] + 1.0})


@pytest.mark.parametrize("name", EFFECTS)
def test_some_machine_has_the_part(name):
    assert any(e == name for _, e in PAIRS)


@pairs
def test_text_keeps_it(machine, effect):
    chosen = MACHINES[machine].with_effects(make_effect(effect, {}))
    assert machine_from_toml(chosen.to_toml()) == chosen


@pairs
def test_zero_strength_is_the_base(machine, effect):
    base = MACHINES[machine]
    zero = base.with_effects(EFFECTS[effect]().at_zero())
    a, b = base.system(speed_rpm=SPEED_RPM), zero.system(speed_rpm=SPEED_RPM)
    if a.coordinates == b.coordinates:
        assert np.array_equal(a.core, b.core)
        assert np.array_equal(a.probe_rows, b.probe_rows)
    start, step = settled(machine), base.definition.step_s
    one = run_from(base, start, step_s=step, duration_s=200 * step)
    two = run_from(zero, start, step_s=step, duration_s=200 * step)
    # The forces are the same; more of them change the order of sums in the step tables.
    assert np.abs(one - two).max(axis=0) == pytest.approx(0, abs=1e-9 * np.abs(one).max())


def change(machine, effect):
    """Return orders and the size of the change that the effect makes there, (orders,) and (probes, orders)."""
    base, changed = MACHINES[machine], MACHINES[machine].with_effects(EFFECTS[effect]())
    # A line fixed in Hz or beside an order does not repeat with the shaft: in time.
    if changed.system(speed_rpm=SPEED_RPM).is_linear and not any(
        line.frequency_hz or line.order % 1 for line in EFFECTS[effect]().signature(base)
    ):
        a, b = (harmonic_balance(m, speed_rpm=SPEED_RPM, harmonics=8) for m in (base, changed))
        return a.orders, np.abs(b.amplitudes - a.amplitudes), a.probes
    rate = min(16384.0, 0.5 / base.definition.step_s)
    options = {"duration_s": 60 * TURNS / SPEED_RPM, "rate_hz": rate}
    a, b = simulate_batch([(base, SPEED_RPM), (changed, SPEED_RPM)], **options)
    window = np.hanning(a.phase_rad.size)
    spectrum = 2 * np.abs(np.fft.rfft((b.signals - a.signals) * window, axis=1)) / window.sum()
    return np.arange(spectrum.shape[1]) * rate / a.phase_rad.size * 60 / SPEED_RPM, spectrum, a.probes


@pairs
def test_signature_appears(machine, effect):
    lines = EFFECTS[effect]().signature(MACHINES[machine])
    assert lines, f"{effect} declares no line on {machine}"
    orders, size, probes = change(machine, effect)
    resolution = orders[1]
    strongest = []
    for line in lines:
        # A mean shows as a displacement only.
        seen = [
            i for i, p in enumerate(probes)
            if (line.direction in ("any", p.direction)
                or (line.direction == "lateral" and p.direction in ("x", "y")))
            and (line.order_at(SPEED_RPM) > 0 or p.quantity == "displacement")
        ]  # fmt: skip
        if not seen:
            continue
        own = size[seen]
        order = line.order_at(SPEED_RPM)
        near = np.abs(orders - order) <= 2 * resolution if resolution < 0.5 else np.isclose(orders, order)
        peak = own[:, near].max(axis=1) if near.any() else np.zeros(len(seen))
        # Beside the mean, which a change of equilibrium moves.
        highest = own[:, orders > 0.05].max(axis=1) if order > 0.05 else own.max(axis=1)
        share = float((peak / np.where(highest > 0, highest, 1)).max())
        strongest.append(share)
        assert share > 1e-5, f"order {order:g} ({line.direction}): {share:.2g} of the largest change"
    assert strongest, "no probe looks in the direction of the signature"
    assert max(strongest) > 0.3, f"the declared lines are at most {max(strongest):.2g} of the largest change"


@pairs
def test_finite_at_the_corners_of_its_bounds(machine, effect):
    parameters = EFFECTS[effect].parameters()
    # Two to the number of parameters are too many to list.
    sides = np.random.default_rng(0).integers(2, size=(8, len(parameters))).tolist()
    ends = [[k] * len(parameters) for k in (0, 1)]
    base = MACHINES[machine]
    step = base.definition.step_s
    for corner in [*ends, *sides]:
        values = {p.name: p.bounds[side] for p, side in zip(parameters, corner, strict=True)}
        made = base.with_effects(EFFECTS[effect](**values))
        found = run_from(made, settled(machine), step_s=step, duration_s=100 * step)
        if effect == "empirical_stiffness" and not np.all(np.isfinite(found)):
            # A spring that pushes: no bounds serve large machines and keep small ones stable. It must be said.
            with pytest.raises(RotorwiseError, match=r"grows|unstable"):
                made.simulate(speed_rpm=SPEED_RPM, duration_s=1.0, rate_hz=1000.0)
            continue
        assert np.all(np.isfinite(found)), values


@pairs
def test_halving_the_step_converges(machine, effect):
    changed = MACHINES[machine].with_effects(EFFECTS[effect]())
    step = changed.definition.step_s
    # An effect that sets in suddenly may part the teeth or lift a foot; contacts that open or close are of first order.
    start = run_from(changed, settled(machine), step_s=step, duration_s=6000 * step, states=True)
    runs = [run_from(changed, start, step_s=step / 2**k, duration_s=96 * step)[:: 2**k] for k in range(4)]
    scale = np.abs(runs[-1]).max(axis=0) + 1e-300
    errors = [np.sqrt(np.mean(((run - runs[-1]) / scale) ** 2)) for run in runs[:-1]]
    order = math.log2((errors[0] + 1e-16) / (errors[2] + 1e-16)) / 2
    # The stages' order falls to 3 and below where modes are far faster than the step (Hochbruck and Ostermann 2010),
    # and to 2.5 where a ball meets its race.
    smooth = order > 2.0 or errors[1] < 1e-8
    # Worn teeth part and meet again all the time: first order, but small errors that still fall.
    parting = errors[0] < 3e-4 and errors[2] < errors[0] / 2
    assert smooth or parting, f"order {order:.2f}, errors {errors}"


@pytest.mark.parametrize("machine", MACHINES)
def test_effects_commute(machine):
    own = [EFFECTS[e]() for m, e in PAIRS if m == machine]
    forward, backward = MACHINES[machine].with_effects(*own), MACHINES[machine].with_effects(*reversed(own))
    step = MACHINES[machine].definition.step_s
    one, two = (run_from(m, settled(machine), step_s=step, duration_s=300 * step) for m in (forward, backward))
    assert np.abs(one - two).max() < 1e-8 * np.abs(one).max()


@pytest.mark.parametrize("machine", MACHINES)
def test_compiled_forces_are_the_plain_ones(machine):
    made = MACHINES[machine].with_effects(*(EFFECTS[e]() for m, e in PAIRS if m == machine))
    run = stepper(made, step_s=made.definition.step_s)
    start = settled(machine)
    generator = np.random.default_rng(4)
    timeline = run.plan.lane_timeline(0, generator.uniform(0, 1, 5))
    size = np.abs(run.system.motion_rows[:, : start.shape[0]] @ start) if start.shape[0] == run.system.states else 1e-5
    x = np.ascontiguousarray((size + 1e-7) * generator.normal(size=(run.system.motion_rows.shape[0], 5)))
    for k, force in enumerate(run.plan.forces):
        if force.law.is_linear:
            continue
        parameters = np.repeat(run.plan.own_parameters(k), 5, axis=1)
        extra = {"branch_rad": timeline.phase_rad} if force.law.jumps is not None else {}
        own = np.ascontiguousarray(force.law.signals(timeline, run.plan.own_parameters(k), **extra)[:, :, 0])
        reads = run.plan.inputs[run.plan.rows[k, 1] : run.plan.rows[k, 2]]
        acts = run.plan.outputs[run.plan.rows[k, 3] : run.plan.rows[k, 4]]
        results = []
        for function in (force.law.force, force.law.force.py_func):
            u = np.zeros((run.system.force_columns.shape[1], 5))
            function(own, parameters, x, reads, acts, u)
            results.append(u)
        assert results[0] == pytest.approx(results[1], rel=1e-12, abs=1e-12 * np.abs(results[1]).max())


@pytest.mark.parametrize("name", sorted(name for name, kind in effect_catalogue().items() if kind.ROLE == "gear"))
def test_which_gear_is_named_makes_no_difference_to_shared_effects_only(name):
    kind, made = effect_catalogue()[name], []
    for at in ("pinion", "wheel"):
        assembly = MACHINES["gearbox"].bare_assembly()
        kind(at=at).contribute(assembly)
        made.append(assembly.component("mesh").interface_force().parameters)
    assert (made[0] == made[1]) == kind.SHARED

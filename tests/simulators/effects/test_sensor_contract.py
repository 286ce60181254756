"""The contract of effects on the measuring chain and on the speed, on every machine that they fit. No opt-out."""

import functools
import inspect

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effect import STAGES, SensorEffect, SpeedEffect, effect_catalogue, make_effect
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import machine_catalogue, machine_from_toml
from rotorwise.simulators.sensor_record import LINKS
from rotorwise.simulators.solvers.simulate import simulate_batch

EFFECTS = {name: effect for name, effect in effect_catalogue().items() if effect.STAGE in ("sensor", "speed")}
MACHINES = machine_catalogue()
SPEED_RPM = 1800.0
DURATION_S = 0.25
#: Enough to tell apart the sidebands of a slow wander.
LONG_S = 2.0


def fits(machine, effect):
    try:
        effect().contribute(machine.bare_assembly())
    except MissingPartError:
        return False
    return True


PAIRS = [(m, e) for m, machine in MACHINES.items() for e, effect in EFFECTS.items() if fits(machine, effect)]
pairs = pytest.mark.parametrize(("machine", "effect"), PAIRS, ids=[f"{m}-{e}" for m, e in PAIRS])


def rate_hz(machine):
    return min(4096.0, 0.5 / MACHINES[machine].definition.step_s)


def simulate(machine, *effects, seed=3, **options):
    made = MACHINES[machine].with_effects(*effects)
    rate = rate_hz(machine)
    return made.simulate(
        speed_rpm=SPEED_RPM, rate_hz=rate, seed=seed, **{"duration_s": DURATION_S, "settle_s": 0.2, **options}
    )


@functools.cache
def base(machine):
    return simulate(machine)


@functools.cache
def long_base(machine):
    return simulate(machine, duration_s=LONG_S)


@pytest.mark.parametrize("name", EFFECTS)
def test_declaration(name):
    effect = EFFECTS[name]
    assert inspect.getmodule(effect).__name__.rpartition(".")[2] == name == effect.NAME
    assert effect.STAGE in STAGES
    assert issubclass(effect, SensorEffect if effect.STAGE == "sensor" else SpeedEffect)
    assert effect.STAGE == "speed" or effect.LINK in LINKS
    assert effect.MEANING.endswith(".")
    assert effect.CHECK.endswith(("?", "."))
    assert effect.REFERENCES
    assert effect.RIVALS
    assert effect.__doc__
    assert any(p.zero is not None for p in effect.parameters()), "no strength"
    for p in effect.parameters():
        assert p.meaning
        assert p.source
        if p.prior is not None:
            assert p.default == pytest.approx(p.prior.median)
            draws = [p.prior.sample(np.random.default_rng(seed)) for seed in range(50)]
            assert np.mean([p.bounds[0] <= draw <= p.bounds[1] for draw in draws]) > 0.8
        with pytest.raises(InvalidValueError, match=p.name):
            effect(**{p.name: p.bounds[1] + 1.0})


@pytest.mark.parametrize("name", EFFECTS)
def test_some_machine_has_the_part(name):
    assert any(e == name for _, e in PAIRS)


@pytest.mark.parametrize("name", [n for n, e in EFFECTS.items() if e.STAGE == "sensor"])
def test_unknown_probe_is_refused(name):
    machine = MACHINES[next(m for m, e in PAIRS if e == name)].with_effects(EFFECTS[name](at="nowhere"))
    with pytest.raises(MissingPartError, match="nowhere"):
        machine.simulate(speed_rpm=SPEED_RPM, duration_s=0.1, rate_hz=500, seed=1)


@pairs
def test_text_keeps_it(machine, effect):
    chosen = MACHINES[machine].with_effects(make_effect(effect, {}))
    assert machine_from_toml(chosen.to_toml()) == chosen


@pairs
def test_zero_strength_is_the_signal_exactly(machine, effect):
    # A seed is not needed: nothing is drawn.
    zero = simulate(machine, EFFECTS[effect]().at_zero(), seed=None)
    assert np.array_equal(zero.signals, base(machine).signals)
    assert np.array_equal(zero.phase_rad, base(machine).phase_rad)


@pairs
def test_default_changes_the_record_and_keeps_its_shape(machine, effect):
    changed = simulate(machine, EFFECTS[effect]())
    assert changed.signals.shape == base(machine).signals.shape
    assert changed.phase_rad.shape == base(machine).phase_rad.shape
    assert changed.rate_hz == base(machine).rate_hz
    size = base(machine).signals.std(axis=1)
    moved = np.sqrt(np.mean((changed.signals - base(machine).signals) ** 2, axis=1))
    assert np.max(moved / np.where(size > 0, size, 1.0)) > 1e-4


@pairs
def test_same_seed_same_record(machine, effect):
    one, two, other = (simulate(machine, EFFECTS[effect](), seed=seed).signals for seed in (3, 3, 4))
    assert np.array_equal(one, two)
    made = EFFECTS[effect]()
    if EFFECTS[effect].STAGE == "sensor" and made.is_random:
        assert not np.array_equal(one, other)
        with pytest.raises(InvalidValueError, match=f"seed.*{effect}"):
            simulate(machine, made, seed=None)
    else:
        assert np.array_equal(one, other)


@pytest.mark.parametrize("effect", EFFECTS)
def test_finite_at_the_corners_of_its_bounds(effect):
    machine = next(m for m, e in PAIRS if e == effect)
    parameters = EFFECTS[effect].parameters()
    chosen = np.random.default_rng(0).integers(2, size=(4, len(parameters))).tolist()
    for corner in ([0] * len(parameters), [1] * len(parameters), *chosen):
        values = {p.name: p.bounds[side] for p, side in zip(parameters, corner, strict=True)}
        run = simulate(machine, EFFECTS[effect](**values), duration_s=0.1, settle_s=0.05)
        assert np.all(np.isfinite(run.signals)), values


@pytest.mark.parametrize("machine", MACHINES)
def test_effects_commute(machine):
    own = [EFFECTS[e]() for m, e in PAIRS if m == machine and e != "aliasing"]
    assert np.array_equal(simulate(machine, *own).signals, simulate(machine, *reversed(own)).signals)


def test_two_wanders_commute_exactly():
    wander = EFFECTS["speed_wander"]
    two = [wander(hunting_hz=1.3), wander(hunting_hz=3.1, seed=5)]
    assert np.array_equal(simulate("amb_rotor", *two).signals, simulate("amb_rotor", *reversed(two)).signals)


def test_another_effect_does_not_change_the_draw():
    lost, hum = EFFECTS["dropped_samples"](gap_s=0.01, share=0.1), EFFECTS["dc_drift"](offset=0.5, drift=0.0)
    alone, both = simulate("amb_rotor", lost).signals, simulate("amb_rotor", lost, hum).signals
    # Where a value is held it equals the one before; hum moves all values alike.
    assert np.array_equal(np.diff(alone) == 0, np.isclose(np.diff(both), 0, atol=1e-15))


def test_cases_of_a_batch_have_draws_of_their_own():
    machine = MACHINES["amb_rotor"].with_effects(EFFECTS["clock_error"](rate_error_ppm=0.0))
    plain = MACHINES["amb_rotor"]
    options = {"duration_s": 0.1, "rate_hz": 500.0, "settle_s": 0.1}
    one, two, bare = simulate_batch([(machine, 1800), (machine, 1800), (plain, 1800)], seed=1, **options)
    assert not np.array_equal(one.signals, two.signals)
    alone = plain.simulate(speed_rpm=1800, **options)
    assert bare.signals == pytest.approx(alone.signals, rel=1e-9, abs=1e-15)


def peak(run, order, directions):
    window = np.hanning(run.phase_rad.size)
    rows = [i for i, p in enumerate(run.probes) if "any" in directions or p.direction in directions]
    turns = run.phase_rad / (2 * np.pi)
    wave = (run.signals - run.signals.mean(axis=1, keepdims=True))[rows] if order else run.signals[rows]
    return np.abs((wave * window) @ np.exp(-2j * np.pi * order * turns)) / window.sum()


@pairs
def test_signature_appears(machine, effect):
    made = EFFECTS[effect]()
    highest = 0.4 * rate_hz(machine) * 60 / SPEED_RPM
    lines = [line for line in made.signature(MACHINES[machine]) if line.order_at(SPEED_RPM) < highest]
    if not lines:
        return
    after, before = simulate(machine, made, duration_s=LONG_S), long_base(machine)
    for line in lines:
        directions = {"lateral": ("x", "y")}.get(line.direction, (line.direction,))
        order = line.order_at(SPEED_RPM)
        change = peak(after, order, directions) - peak(before, order, directions)
        assert np.abs(change).max() > 1e-6 * np.abs(before.signals).max(axis=1).min()
        assert change.max() > 0 or order == 0

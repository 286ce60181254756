"""What an added effect costs a step, and a run with ten of them, on the gearbox and the test rig.

    OPENBLAS_NUM_THREADS=1 python tests/benchmarks/effects_speed.py [ROUNDS]

Process CPU time of one lane, smallest of several rounds in which all runs take turns, so that a busy machine slows all
of them. Signals (numpy) are included, set-up and the output's low-pass filter are not. An effect counts as linear when
the machine has the same compiled forces with it as without; "changes compiled forces" are those that add one or give
one that is there more to do. At the prior median.
"""

import sys

import numpy as np
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.plan import Room, block_signals
from simulator_cost import SPEED_RPM, smallest, step_ns, stepper

MACHINES = ("gearbox", "test_rig")
WANTED_NS = 100.0


def fitting(machine):
    """Return one of each effect of the stages structure and force that the machine has a part for."""
    found = []
    for effect in effect_catalogue().values():
        try:
            if effect.STAGE in ("structure", "force"):
                machine.with_effects(effect()).system(speed_rpm=SPEED_RPM)
                found.append(effect())
        except MissingPartError:
            continue
    return found


def compiled_forces(machine):
    """Return law and number of parameters of the machine's compiled forces."""
    forces = machine.system(speed_rpm=SPEED_RPM).forces
    return sorted((force.law.name, len(force.parameters)) for force in forces if not force.law.is_linear)


def in_turns(runs, rounds):
    """Return the ns of a step of each run."""
    return np.min([[step_ns(run, repeats=2) for run in runs] for _ in range(rounds)], axis=0)


def signals_ns(run, rounds):
    """Return how much of a step's cost are the signals."""
    steps, room = min(run.block, 4000), Room()
    return smallest(lambda: block_signals(run.plan, 0.0, run.step_s, steps, room), rounds) / steps * 1e9


def each_alone(machine, effects, rounds):
    step_s = machine.definition.step_s
    runs = [stepper([machine.with_effects(*some)], step_s=step_s) for some in ((), *((effect,) for effect in effects))]
    costs = in_turns(runs, rounds)
    signals = np.array([signals_ns(run, rounds) for run in runs])
    added, added_signals = costs[1:] - costs[0], signals[1:] - signals[0]
    print(f"{machine.name}: {costs[0]:.0f} ns a step without effects, {signals[0]:.0f} of them signals")
    base = compiled_forces(machine)
    is_linear = np.array([compiled_forces(machine.with_effects(effect)) == base for effect in effects])
    for kind, chosen in (("linear", is_linear), ("changes compiled forces", ~is_linear)):
        if not chosen.any():
            continue
        print(
            f"  {kind}: mean {added[chosen].mean():.0f}, median {np.median(added[chosen]):.0f} ns; signals in brackets"
        )
        for i in np.flatnonzero(chosen)[np.argsort(added[chosen])]:
            print(f"    {effects[i].NAME} {added[i]:.0f} ({added_signals[i]:.0f})")


def ten_at_once(machine, effects, rounds):
    """Print the cost with ten effects: unbalances, and draws from those that fit."""
    step_s = machine.definition.step_s
    draws = [[effects[i] for i in np.random.default_rng(seed).permutation(len(effects))[:10]] for seed in range(5)]
    unbalances = [Unbalance(moment_kg_m=1e-6 * (1 + k), angle_rad=0.5 * k) for k in range(10)]
    sets = {"ten unbalances": unbalances, "first ten of the catalogue": effects[:10]}
    sets |= {f"ten drawn, {number + 1}": draw for number, draw in enumerate(draws)}
    runs = [stepper([machine.with_effects(*some)], step_s=step_s) for some in ([], *sets.values())]
    costs = in_turns(runs, rounds)
    for name, cost in zip(sets, costs[1:], strict=True):
        each = (cost - costs[0]) / 10
        print(f"  {name}: {cost:.0f} ns a step, {each:.0f} each (asked {WANTED_NS:.0f}), ", end="")
        print(f"{costs[0] / cost:.2f} of the speed without (asked 0.5)")


def main(rounds):
    for name in MACHINES:
        machine = find_machine(name)
        effects = fitting(machine)
        each_alone(machine, effects, rounds)
        ten_at_once(machine, effects, rounds)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)

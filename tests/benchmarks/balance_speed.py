"""What harmonic balance costs in a search: many variants of a machine, eight speeds each, eight harmonics.

    OPENBLAS_NUM_THREADS=1 python tests/benchmarks/balance_speed.py [FOLDER_WITH_ANOTHER_ROTORWISE]

Process CPU time for each variant and speed, smallest of five turns. A second rotorwise (a folder that holds
`rotorwise/simulators`, of an older commit for instance) is measured in turns with this one.
"""

import json
import os
import subprocess
import sys
import time

SPEEDS_RPM = [900.0, 1200.0, 1500.0, 1800.0, 2100.0, 2400.0, 2700.0, 3000.0]
VARIANTS, TURNS = 12, 5
#: Machine; effects with a strength that is varied, or a parameter of the machine after "=".
CASES = [
    ("amb_rotor", "unbalance"),
    ("amb_rotor", "coupling_stiffness_harmonics+coupling_misalignment"),
    ("amb_rotor", "breathing_crack"),
    ("amb_rotor", "rub"),
    ("amb_rotor", "=coupling_stiffness_n_m"),
    ("amb_rotor", "=shaft_length_m"),
    ("rigid_coupling", "unbalance"),
    ("rigid_coupling", "rub"),
    ("rigid_coupling", "bolt_loss"),
    ("rigid_coupling", "=support_2_n_m"),
    ("test_rig", "unbalance"),
    ("test_rig", "unbalance+coupling_misalignment"),
    ("test_rig", "looseness"),
    ("test_rig", "breathing_crack"),
    ("test_rig", "rub"),
    ("test_rig", "=mount_stiffness_n_m"),
]


def variants(name, what):
    """Return variants of a machine; strengths between 60 and 70 % of their default, or of a tenth of their range."""
    from rotorwise.simulators.effect import make_effect
    from rotorwise.simulators.machine import find_machine

    machine, factors = find_machine(name), [0.6 + 0.1 * i / VARIANTS for i in range(VARIANTS)]
    if what.startswith("="):
        value = machine.values[what[1:]]
        return [machine.with_parameters(**{what[1:]: value * (1.2 - 0.4 * factor)}) for factor in factors]
    found = []
    for factor in factors:
        effects = []
        for effect in (make_effect(one, {}) for one in what.split("+")):
            strength = next(p for p in effect.parameters() if p.zero is not None)
            value = getattr(effect, strength.name)
            value = value if value != strength.zero else strength.zero + 0.1 * (strength.bounds[1] - strength.zero)
            effects.append(effect.with_values(**{strength.name: factor * value}))
        found.append(machine.with_effects(*effects))
    return found


def measure():
    """Print the CPU milliseconds for each variant and speed of every case, as JSON."""
    from rotorwise.simulators.solvers import harmonic_balance as solver

    def balance(machine):
        try:
            if hasattr(solver, "harmonic_balance_at_speeds"):
                solver.harmonic_balance_at_speeds(machine, SPEEDS_RPM, harmonics=8)
            else:
                for speed in SPEEDS_RPM:
                    solver.harmonic_balance(machine, speed_rpm=speed, harmonics=8)
        except solver.NoPeriodicMotionError:
            return

    costs = {}
    for name, what in CASES:
        machines = variants(name, what)
        balance(machines[0])
        begun = time.process_time()
        for machine in machines[1:]:
            balance(machine)
        costs[f"{name} {what}"] = 1e3 * (time.process_time() - begun) / len(machines[1:]) / len(SPEEDS_RPM)
    print(json.dumps(costs))


def main(other):
    costs = {"": {}, other: {}}
    for _ in range(TURNS):
        for folder, found in costs.items():
            environment = {**os.environ, "PYTHONPATH": folder} if folder else dict(os.environ)
            answer = subprocess.run(
                [sys.executable, __file__, "--measure"], env=environment, check=True, capture_output=True, text=True
            )
            for case, cost in json.loads(answer.stdout).items():
                found[case] = min(cost, found.get(case, cost))
    for case, cost in costs[""].items():
        before = costs[other][case]
        print(f"{case:70s}" + (f"{before:7.2f} -> " if other else "") + f"{cost:5.2f} ms" + f"  {before / cost:.1f} x")


if __name__ == "__main__":
    if "--measure" in sys.argv:
        measure()
    else:
        main(sys.argv[1] if len(sys.argv) > 1 else "")

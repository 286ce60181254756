"""ROSS's half of `ross_speed.py`: its documented misalignment example, timed and written to a file.

    python ross_side.py FILE.npz          in an environment with ross-rotordynamics 3.1.0

Two ways to run it, both from ROSS's documentation: the default (an exact recursion for forces that are linear between
samples, scipy's `lsim`) and Newmark's method on 12 modes. A third, Newmark on all degrees of freedom, is what the
reduction replaces.
"""

import sys
import time

import numpy as np
import ross as rs
from ross.faults.misalignment import MisalignmentFlex

SPEED_RPM, STEP_S, ANGLES = 1200.0, 1e-4, 64
DISC_NODES, UNBALANCE_KG_M, UNBALANCE_PHASE_RAD = (12, 24), (5e-4, 0.0), (-np.pi / 2, 0.0)
WAYS = {
    "documented": {},
    "12 modes": {"method": "newmark", "model_reduction": {"num_modes": 12}},
    "newmark": {"method": "newmark"},
}


def fault(rotor):
    """Return the documented parallel misalignment of 0.2 mm in x and y at the first element."""
    return MisalignmentFlex(
        rotor,
        n=0,
        mis_type="parallel",
        mis_distance_x=2e-4,
        mis_distance_y=2e-4,
        mis_angle=np.radians(5),
        radial_stiffness=40e3,
        bending_stiffness=38e3,
    )


def run(rotor, duration_s, **options):
    """Return x and y of both discs (samples, 4), from rest, and the CPU seconds."""
    # A new start: ROSS changes the dictionary of options that it is given.
    options = {name: dict(value) if isinstance(value, dict) else value for name, value in options.items()}
    times = np.arange(round(duration_s / STEP_S)) * STEP_S
    begun = time.process_time()
    result = fault(rotor).run(
        list(DISC_NODES), list(UNBALANCE_KG_M), list(UNBALANCE_PHASE_RAD), SPEED_RPM * np.pi / 30, times, **options
    )
    spent = time.process_time() - begun
    rows = [6 * node + axis for node in DISC_NODES for axis in (0, 1)]
    return result.yout[:, rows], spent


def main(path):
    rotor = rs.rotor_example_with_damping()
    force = fault(rotor).compute_reaction_force(2 * np.pi * np.arange(ANGLES) / ANGLES)
    known = {
        "nodes_m": np.array(rotor.nodes_pos),
        "coupling_force_n": force[[0, 1]],
        "coupling_force_sum_n": np.abs(force[[0, 1]] + force[[6, 7]]).max(),
        "speed_rpm": SPEED_RPM,
        "step_s": STEP_S,
        "degrees_of_freedom": rotor.ndof,
    }
    for name, options in WAYS.items():
        for duration_s in (0.5, 2.0):
            repeats = 1 if name == "newmark" else 3
            known[f"{name}, cpu for {duration_s:g} s"] = min(
                run(rotor, duration_s, **options)[1] for _ in range(repeats)
            )
        # The slowest mode decays with 4 per second: after 4 s, 1e-7 of the start is left.
        known[name] = run(rotor, 4.0, **options)[0] if name != "newmark" else np.zeros(0)
    np.savez(path, **known)


if __name__ == "__main__":
    main(sys.argv[1])

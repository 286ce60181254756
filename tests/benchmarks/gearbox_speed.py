"""Cost of one simulated second of paper 001's gearbox, at equal accuracy, against scipy's LSODA.

    python tests/benchmarks/gearbox_speed.py [--numpy]

The accuracy is the relative rms error of the pinion's torsional velocity over 0.05 s from a settled state, against our
own stepper at 960 kHz, which the tests check against scipy's Radau and CVODE. Each solver gets the loosest setting that
reaches 1e-3. Process CPU time. LSODA runs on the same equations, once with the right-hand side compiled by numba, once
in numpy.
"""

import sys
import time

import numba
import numpy as np
from rotorwise.simulators.machine import machine_catalogue
from rotorwise.simulators.solvers.oracle import _derivative
from rotorwise.simulators.solvers.plan import force_plan
from rotorwise.simulators.solvers.simulate import simulate_batch
from rotorwise.simulators.solvers.stepper import LaneGroup, Stepper
from rotorwise.simulators.speed_profile import steady
from scipy.integrate import odeint

SPEED_RPM, DURATION_S, OUTPUT_HZ = 1800.0, 0.05, 15_000
WANTED = 1e-3
PROBE = "pinion torsional velocity"
GEARBOX = machine_catalogue()["gearbox"]
PROFILE = steady(speed_rpm=SPEED_RPM)
SYSTEM = GEARBOX.system(speed_rpm=SPEED_RPM)


def stepper(rate_hz, lanes=1, start_s=0.0, modal=True):
    return Stepper(
        LaneGroup([GEARBOX] * lanes, [PROFILE] * lanes, [SYSTEM] * lanes),
        step_s=1 / rate_hz,
        start_s=start_s,
        modal=modal,
    )


def settled_state():
    run = stepper(120_000, start_s=-0.5, modal=False)
    while run.done < 60_000:
        run.advance(min(run.block, 60_000 - run.done))
    return run.states[:, 0].copy()


def velocity(rate_hz, start, duration_s=DURATION_S):
    """Return the pinion's velocity at the output times, and the CPU seconds."""
    run = stepper(rate_hz)
    run.states[:, 0] = run.form.inverse @ start
    steps = round(duration_s * rate_hz) + 1
    begun = time.process_time()
    parts = []
    while run.done < steps:
        parts.append(run.advance(min(run.block, steps - run.done)))
    spent = time.process_time() - begun
    index = [probe.name for probe in SYSTEM.probes].index(PROBE)
    return np.concatenate(parts)[:: rate_hz // OUTPUT_HZ, index, 0], spent


def compiled_derivative():
    """Return f(y, t) compiled: the same laws, their signals written out."""
    plan = force_plan([SYSTEM], [PROFILE])
    speed = PROFILE.speeds_rad_s[0]
    core, columns, rows = SYSTEM.core.copy(), SYSTEM.force_columns.copy(), SYSTEM.motion_rows.copy()
    kinds = {force.name: k for k, force in enumerate(plan.forces)}
    bearings = [k for name, k in kinds.items() if name.startswith("bearing")]
    mesh = kinds["mesh"]
    ball, teeth = plan.forces[bearings[0]].law.force.compiled, plan.forces[mesh].law.force.compiled
    ins, outs = plan.inputs, plan.outputs
    rows_of = plan.rows
    own = [np.ascontiguousarray(plan.own_parameters(k)) for k in bearings]
    cage = np.array([p[2, 0] for p in own])
    p0, p1, p2, p3 = own
    i0, i1, i2, i3 = (ins[rows_of[k, 1] : rows_of[k, 2]].copy() for k in bearings)
    o0, o1, o2, o3 = (outs[rows_of[k, 3] : rows_of[k, 4]].copy() for k in bearings)
    pm = np.ascontiguousarray(plan.own_parameters(mesh))
    im, om = ins[rows_of[mesh, 1] : rows_of[mesh, 2]].copy(), outs[rows_of[mesh, 3] : rows_of[mesh, 4]].copy()
    constant = np.zeros((columns.shape[1], 1))
    timeline = plan.lane_timeline(0, np.zeros(1))
    for k, force in enumerate(plan.forces):
        if k != mesh and k not in bearings:
            assert force.law.is_linear
            acts = outs[rows_of[k, 3] : rows_of[k, 4]]
            constant[acts, 0] += force.law.signals(timeline, plan.own_parameters(k))[: acts.size, 0, 0]
    powers = int(pm[8, 0])
    order, start, changes, mean_error = pm[0, 0] / (2 * np.pi), pm[1, 0], pm[2, 0], pm[7, 0]
    assert pm[9, 0] == 0, "no damaged teeth here"
    first, second = pm[11 : 11 + powers, 0].copy(), pm[11 + powers : 11 + 2 * powers, 0].copy()
    series = pm[11 + 2 * powers :, 0].reshape(-1, 3).copy()

    # Arrays of a closure are read-only to numba, the forces want writable ones: copying these few costs little.
    @numba.njit(numba.float64[::1](numba.float64[::1], numba.float64), error_model="numpy")
    def derivative(y, t):
        phase = speed * t
        x = (rows @ y).reshape(-1, 1)
        u = constant.copy()
        signals = np.empty((2, 1))
        signals[0, 0], signals[1, 0] = np.cos(cage[0] * phase), np.sin(cage[0] * phase)
        ball(signals, p0.copy(), x, i0.copy(), o0.copy(), u)
        signals[0, 0], signals[1, 0] = np.cos(cage[1] * phase), np.sin(cage[1] * phase)
        ball(signals, p1.copy(), x, i1.copy(), o1.copy(), u)
        signals[0, 0], signals[1, 0] = np.cos(cage[2] * phase), np.sin(cage[2] * phase)
        ball(signals, p2.copy(), x, i2.copy(), o2.copy(), u)
        signals[0, 0], signals[1, 0] = np.cos(cage[3] * phase), np.sin(cage[3] * phase)
        ball(signals, p3.copy(), x, i3.copy(), o3.copy(), u)
        at = phase * order + start
        local = at - np.floor(at)
        stiffness = 0.0
        if local < changes:
            for k in range(powers - 1, -1, -1):
                stiffness = stiffness * local + first[k]
        else:
            local -= changes
            for k in range(powers - 1, -1, -1):
                stiffness = stiffness * local + second[k]
        error, rate = mean_error, 0.0
        for k in range(series.shape[0]):
            angle = series[k, 0] * phase
            error += series[k, 1] * np.cos(angle) + series[k, 2] * np.sin(angle)
            rate += series[k, 0] * speed * (series[k, 2] * np.cos(angle) - series[k, 1] * np.sin(angle))
        triple = np.empty((3, 1))
        triple[0, 0], triple[1, 0], triple[2, 0] = stiffness, error, rate
        teeth(triple, pm.copy(), x, im.copy(), om.copy(), u)
        return core @ y + columns @ np.ascontiguousarray(u[:, 0])

    return derivative


def numpy_derivative():
    plan = force_plan([SYSTEM], [PROFILE])
    # On the branch of each instant: LSODA steps over the jumps.
    return lambda y, t: _derivative(SYSTEM, plan, float(PROFILE.phase_rad(np.array([t]))[0]))(t, y)


def lsoda(derivative, start, tolerance, duration_s):
    times = np.arange(round(duration_s * OUTPUT_HZ) + 1) / OUTPUT_HZ
    begun = time.process_time()
    states = odeint(derivative, start, times, rtol=tolerance, atol=tolerance * 1e-6, mxstep=1_000_000)
    spent = time.process_time() - begun
    index = [probe.name for probe in SYSTEM.probes].index(PROBE)
    return states @ SYSTEM.probe_rows[index], spent


def error_of(found, truth):
    return float(np.sqrt(np.mean((found - truth) ** 2)) / truth.std())


def main():
    start = settled_state()
    truth, _ = velocity(960_000, start)
    print("solver | setting | error | CPU s per simulated s")
    ours = None
    for rate in (30_000, 45_000, 60_000, 120_000, 240_000):
        found, _ = velocity(rate, start)
        spent = min(velocity(rate, start, 0.5)[1] for _ in range(3)) / 0.5
        error = error_of(found, truth)
        print(f"rotorwise, one lane | {rate} Hz | {error:.1e} | {spent:.3f}")
        if ours is None and error < WANTED:
            ours = rate, spent
    derivative = compiled_derivative()
    derivative(start, 0.0)
    compiled = None
    for tolerance in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9):
        found, spent = lsoda(derivative, start, tolerance, DURATION_S)
        error = error_of(found, truth)
        print(f"LSODA, compiled | rtol {tolerance:g} | {error:.1e} | {spent / DURATION_S:.2f}")
        if error < WANTED:
            compiled = tolerance, spent / DURATION_S
            break
    if ours and compiled:
        print(f"one lane against compiled LSODA at error {WANTED:g}: {compiled[1] / ours[1]:.1f} x")
        if "--numpy" in sys.argv:
            _, spent = lsoda(numpy_derivative(), start, compiled[0], 0.01)
            print(f"one lane against numpy LSODA: {spent / 0.01 / ours[1]:.0f} x ({spent / 0.01:.0f} s)")
    for lanes in (1, 8, 16, 32, 64):
        rate = ours[0] if ours else 60_000
        cases = [(GEARBOX.with_parameters(load_torque_n_m=20 + i), SPEED_RPM) for i in range(lanes)]
        spent = []
        for _ in range(3):
            begun = time.process_time()
            simulate_batch(cases, duration_s=0.2, rate_hz=rate / 2, step_s=1 / rate, settle_s=0.0)
            spent.append(time.process_time() - begun)
        print(
            f"{lanes} lanes at {rate} Hz, all included: {min(spent) / 0.2 / lanes:.4f} CPU s per simulated s and lane"
        )
    cases = [(GEARBOX.with_parameters(load_torque_n_m=20 + i), SPEED_RPM) for i in range(64)]
    for threads in (1, 2):
        begun = time.perf_counter()
        simulate_batch(cases, duration_s=0.5, rate_hz=30_000, settle_s=0.0, threads=threads)
        print(f"64 lanes, {threads} thread(s): {time.perf_counter() - begun:.2f} s wall")


if __name__ == "__main__":
    main()

"""What a simulation step costs, and what the first one costs; draws docs/simulator_cost.png.

    OPENBLAS_NUM_THREADS=1 python tests/benchmarks/simulator_cost.py [PICTURE.png]

Process CPU time, smallest of several; wall time where threads or a new process are measured. The picture needs a
headless Chromium. Cost of a step includes the signals (numpy), leaves out set-up and the output's low-pass filter.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rotorwise.simulators.assembly import MissingPartError, Place, Probe
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import Machine, MachineDefinition, Preset, find_machine
from rotorwise.simulators.rotor_dynamics.flexible_shaft import add_bending, bending_at
from rotorwise.simulators.rotor_dynamics.harmonic_force import rotating_mass
from rotorwise.simulators.rotor_dynamics.shaft_parts import Disc, Material, ShaftElement
from rotorwise.simulators.solvers.simulate import simulate_batch
from rotorwise.simulators.solvers.stepper import LaneGroup, Stepper
from rotorwise.simulators.speed_profile import steady
from rotorwise.simulators.threshold_map import threshold_map

SPEED_RPM = 1800.0
COLOURS = ("#1f6f8b", "#d1495b", "#4f8a5b", "#8d6a9f")
PICTURE = Path(__file__).parents[2] / "docs" / "simulator_cost.png"
STEEL = Material(2.1e11, 7850.0, 0.3)
#: What `first_run` runs in a new process: CPU and wall seconds of import, first and second simulation.
FIRST_RUN = """
import time
clocks = [(time.process_time(), time.perf_counter())]
def lap():
    clocks.append((time.process_time(), time.perf_counter()))
import numba, numpy, scipy.linalg, scipy.signal
lap()
from rotorwise.simulators.machine import find_machine
machine = find_machine("{machine}")
options = dict(speed_rpm=1800.0, duration_s=0.05, rate_hz=2000.0, settle_s=0.0)
machine.simulate(**options)
lap()
machine.simulate(**options)
lap()
print(*(b - a for before, after in zip(clocks, clocks[1:]) for a, b in zip(before, after)))
"""


def smallest(work, repeats=7, clock=time.process_time):
    spent = []
    for _ in range(repeats):
        begun = clock()
        work()
        spent.append(clock() - begun)
    return min(spent)


def stepper(machines, *, step_s, highest_hz=None):
    profile = steady(speed_rpm=SPEED_RPM)
    systems = [machine.system(speed_rpm=profile) for machine in machines]
    group = LaneGroup(machines, [profile] * len(machines), systems)
    return Stepper(group, step_s=step_s, start_s=0.0, highest_hz=highest_hz)


def step_ns(run, steps=4000, repeats=9):
    """Return the cost of one step of all lanes in ns."""
    count = min(run.block, steps)
    run.advance(count)
    return smallest(lambda: run.advance(count), repeats) / count * 1e9


def fitting(machine):
    """Return one of each effect that the machine has a part for."""
    found = []
    for effect in effect_catalogue().values():
        try:
            if effect.STAGE in ("structure", "force"):
                machine.with_effects(effect()).system(speed_rpm=SPEED_RPM)
                found.append(effect())
        except MissingPartError:
            continue
    return found


def in_turns(runs, rounds=5):
    """Return the cost of a step of each run in ns; in turns, so that a busy machine slows all of them."""
    return np.min([[step_ns(run, repeats=2) for run in runs] for _ in range(rounds)], axis=0)


def by_effects():
    """Return {curve: (numbers, added ns a step)}: shipped effects one after the other, and unbalances.

    Some shipped effects only change a force that is there; each unbalance is a force of its own.
    """
    curves = {}
    for name in ("gearbox", "test_rig"):
        machine = find_machine(name)
        step_s = machine.definition.step_s
        shipped = fitting(machine)
        alone = [stepper([machine.with_effects(*effects)], step_s=step_s) for effects in ((), *((e,) for e in shipped))]
        costs = in_turns(alone)
        added = sorted(zip(costs[1:] - costs[0], shipped, strict=True), key=lambda pair: pair[0])
        print(f"{name}: {costs[0]:.0f} ns a step; each effect alone adds")
        print("    " + ", ".join(f"{effect.NAME} {cost:.0f}" for cost, effect in added))
        print(f"    mean {np.mean(costs[1:] - costs[0]):.0f}, median {np.median(costs[1:] - costs[0]):.0f}")
        for kind, effects in (("shipped effects", shipped), ("unbalances", [Unbalance(moment_kg_m=1e-6)] * 10)):
            counts = np.arange(11)
            costs = in_turns([stepper([machine.with_effects(*effects[:n])], step_s=step_s) for n in counts])
            each = np.polyfit(counts, costs, 1)[0]
            print(f"    {kind}: {costs[-1] - costs[0]:.0f} ns for 10, {each:.0f} each")
            label = f"{name} ({costs[0] / 1e3:.1f} us without), {kind}: {each:.0f} ns each"
            curves[label] = counts, costs - costs[0]
    return curves


def rotor(nodes):
    """Return a shaft of 1 m with a disc in the middle on two bearings, four degrees of freedom a node."""

    def build(assembly, values, switches):
        elements = [ShaftElement(1.0 / (nodes - 1), 0.03)] * (nodes - 1)
        disc = Disc.from_geometry(nodes // 2, width_m=0.03, outer_diameter_m=0.25, density_kg_m3=7850.0)
        add_bending(assembly, "node", elements=elements, discs=[disc], material=STEEL, damping_ratio=0.01)
        for node in (0, nodes - 1):
            for axis in "xy":
                assembly.add_spring(bending_at("node", node)[axis], stiffness=1e7, damping=500.0)
        place = Place("disc", frozenset({"rotor"}), bending_at("node", nodes // 2))
        assembly.add_place(place)
        for axis in "xy":
            assembly.probes.append(Probe(axis, "displacement", "m", "disc", axis, place.directions[axis]))
        assembly.forces.append(rotating_mass("unbalance", place, moment_kg_m=1e-4, angle_rad=0.0))

    presets = {"plausible": Preset("a plain rotor")}
    return Machine(MachineDefinition("rotor", "a plain rotor", (), presets, build, step_s=1e-4, settle_s=1.0))


def by_size():
    """Return {curve: (degrees of freedom, ns a step)} and {curve: (degrees of freedom, set-up in s)}."""
    nodes = (5, 10, 20, 34, 50, 75, 100)
    sizes = 4 * np.array(nodes)
    curves = {}
    for label, highest_hz in (("all modes", None), ("modes up to 2 kHz", 2000.0)):
        costs = [step_ns(stepper([rotor(n)], step_s=1e-4, highest_hz=highest_hz)) for n in nodes]
        print(
            f"{label}: "
            + ", ".join(f"{size} {cost:.0f}" for size, cost in zip(sizes, costs, strict=True))
            + " ns a step"
        )
        curves[label] = sizes, np.array(costs)
    machines = [rotor(n) for n in nodes]
    setup = [smallest(lambda m=m: stepper([m], step_s=1e-4, highest_hz=2000.0), 3) for m in machines]
    print("set-up: " + ", ".join(f"{size} {cost * 1e3:.0f}" for size, cost in zip(sizes, setup, strict=True)) + " ms")
    return curves, {"matrices, modes, tables": (sizes, 1e3 * np.array(setup))}


def by_lanes():
    """Return {curve: (lanes, ns a step and lane)}; the lanes differ in load or unbalance."""
    lanes = (1, 2, 4, 8, 16, 32, 64)
    curves = {}
    for name in ("gearbox", "test_rig"):
        machine = find_machine(name)
        effects = [Unbalance(moment_kg_m=1e-6 * (1 + k)) for k in range(max(lanes))]
        runs = [
            stepper([machine.with_effects(effect) for effect in effects[:n]], step_s=machine.definition.step_s)
            for n in lanes
        ]
        costs = np.min([[step_ns(run, repeats=2) for run in runs] for _ in range(5)], axis=0) / lanes
        print(
            f"{name}: "
            + ", ".join(f"{n} {cost:.0f}" for n, cost in zip(lanes, costs, strict=True))
            + " ns a step and lane"
        )
        curves[name] = np.array(lanes), costs
    return curves


def by_threads():
    """Print the wall time of 64 gearboxes in one and two threads."""
    machine = find_machine("gearbox")
    cases = [(machine.with_effects(Unbalance(moment_kg_m=1e-6 * (1 + k))), SPEED_RPM) for k in range(64)]
    spent = {1: [], 2: []}
    for _ in range(3):
        for threads, times in spent.items():
            begun = time.perf_counter(), time.process_time()
            simulate_batch(cases, duration_s=0.2, rate_hz=30_000, settle_s=0.0, threads=threads)
            times.append((time.perf_counter() - begun[0], time.process_time() - begun[1]))
    for threads, times in spent.items():
        print(
            f"64 gearboxes, {threads} thread(s): {min(times)[0]:.2f} s wall, {min(cpu for _, cpu in times):.2f} s CPU"
        )


def first_run():
    """Print the first simulation of a new process, with an empty and with a full numba cache.

    Python keeps its bytecode, as in an installed package; some environments of developers switch that off.
    """
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    for machine in ("gearbox", "amb_rotor"):
        with tempfile.TemporaryDirectory() as folder:
            rows = []
            for _ in range(4):
                answer = subprocess.run(
                    [sys.executable, "-c", FIRST_RUN.format(machine=machine)],
                    env={**kept, "NUMBA_CACHE_DIR": folder},
                    cwd=folder,
                    check=True,
                    capture_output=True,
                    text=True,
                )
                rows.append([float(word) for word in answer.stdout.split()])
            for state, row in (("empty", rows[0]), ("full", np.min(rows[1:], axis=0))):
                cpu, wall = row[::2], row[1::2]
                print(
                    f"{machine}, {state} cache: first simulation {cpu[1]:.2f} s CPU ({wall[1]:.2f} wall); with numba's "
                    f"and scipy's import {cpu[0] + cpu[1]:.2f} ({wall[0] + wall[1]:.2f}); second {cpu[2]:.3f}"
                )


def map_cost():
    """Print the cost of a threshold map of 101 x 101 x 4."""
    machine = find_machine("amb_rotor")
    offsets, angles = np.linspace(0, 5e-4, 101), np.radians(np.linspace(0, 2, 101))
    shape = threshold_map(machine, 2580.0, offsets, angles).peaks.shape
    cpu, wall = (
        smallest(lambda: threshold_map(machine, 2580.0, offsets, angles), 9, clock)
        for clock in (time.process_time, time.perf_counter)
    )
    print(f"threshold map {shape}: {cpu:.3f} s CPU, {wall:.3f} s wall")


def draw(panels, path):
    """Write a picture of panels (title, x title, y title, curves, logarithmic axes) through Chromium."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    figure = make_subplots(rows=2, cols=2, subplot_titles=[panel[0] for panel in panels], vertical_spacing=0.16)
    for number, (_, x_title, y_title, curves, logarithmic) in enumerate(panels):
        row, column = number // 2 + 1, number % 2 + 1
        for order, (colour, (name, (x, y))) in enumerate(zip(COLOURS, curves.items(), strict=False)):
            line = go.Scatter(x=x, y=y, mode="lines+markers", line_color=colour, showlegend=False)
            figure.add_trace(line, row, column)
            # Names stand in the corner that the curves leave free: above rising, below falling ones.
            height = 0.05 + 0.07 * order if logarithmic else 0.95 - 0.07 * order
            axis = "" if number == 0 else str(number + 1)
            where = {"x": 0.04, "y": height, "xref": f"x{axis} domain", "yref": f"y{axis} domain", "xanchor": "left"}
            figure.add_annotation(text=name, showarrow=False, font={"size": 12, "color": colour}, **where)
        kind = {"type": "log", "dtick": "D2"} if logarithmic else {"rangemode": "tozero"}
        figure.update_xaxes(title_text=x_title, row=row, col=column, **kind)
        figure.update_yaxes(title_text=y_title, row=row, col=column, **kind)
    figure.update_layout(width=1180, height=820, template="simple_white", margin={"t": 50, "b": 50, "l": 70, "r": 30})
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        figure.write_html(page, include_plotlyjs=True, config={"displayModeBar": False})
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=5000"]
        options += [f"--user-data-dir={folder}", "--window-size=1200,840", f"--screenshot={path}"]
        subprocess.run(
            [shutil.which("chromium") or "chromium", *options, page.as_uri()], check=True, capture_output=True
        )


def main(path):
    effects = by_effects()
    sizes, setup = by_size()
    lanes = by_lanes()
    by_threads()
    first_run()
    map_cost()
    panels = [
        ("What effects add", "effects", "ns a step", effects, False),
        ("Size of the rotor, one lane", "degrees of freedom", "ns a step", sizes, False),
        ("Runs side by side", "lanes", "ns a step and lane", lanes, True),
        ("Set-up, once for a machine", "degrees of freedom", "ms", setup, False),
    ]
    draw(panels, path)


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else PICTURE)

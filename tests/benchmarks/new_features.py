"""Which features of the signal pipeline tell a faulty from a sound simulated machine, as shares of pairs told right.

    OPENBLAS_NUM_THREADS=1 python tests/benchmarks/new_features.py gears|whirl|run_ups [DRAWS] [SEED]

Gears: the gearbox of the simulators, each draw another machine (ball angles, first contact, small run-out and wear of
manufacture) at another speed and load, healthy twice and with each fault. Whirl: the rotors of the simulators with
probes at right angles, and the turbines of the blind set. Run-ups: the test rig with a tacho, features at equal angles
against the same record as if at constant speed. 0.5 tells nothing, 1 everything, 0 everything the other way round.
"""

import sys
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np
from rotorwise.datasets.recording import OperatingCondition, Recording
from rotorwise.datasets.simulated import record_machine
from rotorwise.diagnose.features import features
from rotorwise.diagnose.gear_average import gear_averages
from rotorwise.diagnose.observe import Observation, observe
from rotorwise.diagnose.probe_pair import probe_pair
from rotorwise.diagnose.signal.cepstrum import band_cepstrum, line_spacing
from rotorwise.diagnose.signal.orbit import full_spectrum
from rotorwise.diagnose.simulate_options import parse_chain, parse_effect, parse_machine
from rotorwise.simulators.errors import RotorwiseError
from rotorwise.simulators.speed_profile import ramp

CHAIN = parse_chain("accelerometer:noise.m/s2=2e-3,noise.m=1e-8", pulses_per_revolution=1)
INDICATORS = ("fm0", "fm4", "na4", "energy_ratio")


def drawn(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def simulated(machine: str, preset: str, effects: list[str], seed: int, **options) -> Recording:
    """Return the record of a machine with effects, with the noise of its sensors."""
    settings, load = options.pop("settings", ()), options.pop("load", None)
    made = parse_machine(machine, preset=preset, settings=settings, load=load)
    made = made.with_effects(*(parse_effect(text) for text in effects))
    return record_machine(made, chain=CHAIN, seed=seed, **options).recording


def shares(values: dict[str, dict[str, list[float]]], sound: str) -> None:
    """Print, for each measure and state, the share of pairs in which the state has the larger value than ``sound``."""
    states = [one for one in values if one != sound]
    print("| | " + " | ".join(states) + " |\n|" + "---|" * (len(states) + 1))
    for measure in values[sound]:
        row = []
        for state in states:
            own, healthy = np.array(values[state][measure]), np.array(values[sound][measure])
            own, healthy = own[np.isfinite(own)], healthy[np.isfinite(healthy)]
            pairs = own[:, None] - healthy[None, :]
            share = float(((pairs > 0) + 0.5 * (pairs == 0)).mean()) if pairs.size else float("nan")
            row.append(f"{share:.2f} ({own.size})")
        print(f"| {measure} | " + " | ".join(row) + " |", flush=True)


# ----- gears


def gear_measures(now: Observation) -> dict[str, float]:
    averages = gear_averages(now)
    found = {name: max((getattr(one.indicators, name) for one in averages), default=np.nan) for name in INDICATORS}
    values = features(now)
    found["modulation index"] = values["mesh_modulation_index"]
    return found


def spacing_right(recording: Recording, spacing_hz: float) -> float:
    """Return 1 where the cepstrum's spacing on any channel is the one asked, 0 where another stands out, else NaN."""
    said = []
    for channel, row in zip(recording.channels, recording.signals, strict=True):
        if not channel.is_vibration:
            continue
        cepstrum = band_cepstrum(
            row, rate_hz=recording.rate_hz, low_hz=200.0, high_hz=0.4 * recording.rate_hz, narrowest_hz=3.0
        )
        found = line_spacing(cepstrum, narrowest_hz=4.0, widest_hz=100.0)
        if found is not None and found.power_ratio > 16.0:
            said.append(abs(found.spacing_hz / spacing_hz - 1) < 0.01)
    return float(any(said)) if said else np.nan


def gears(draws: int, seed: int) -> None:
    """Each draw: one machine at one speed and load, healthy as baseline, healthy again, and with each fault."""
    values: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    spacing: dict[str, list[float]] = defaultdict(list)
    for number in range(draws):
        rng = np.random.default_rng([seed, number])
        angles = [f"bearing_{one}_angle_rad={rng.uniform(-3.1, 3.1)}" for one in range(1, 5)]
        speed = rng.choice([1000.0, 1500.0, 2100.0])
        options = {
            "settings": (*angles, f"first_contact_pitches={rng.uniform(0, 1)}"),
            "load": float(rng.choice([15.0, 30.0, 50.0])),
            "duration_s": 2.0,
            "rate_hz": 20_000.0,
            "settle_s": 0.5,
            "probes": ("accelerometer", "bearing 1 x", "bearing 1 y"),
        }
        run_out, wear = drawn(rng, 1e-6, 5e-6), drawn(rng, 5e-7, 3e-6)
        own = [f"gear_eccentricity@pinion:run_out_m={run_out}", f"wear:wear_m={wear}"]
        angle = rng.uniform(-3, 3)
        states = {
            "healthy": own,
            "tooth crack": [*own, f"tooth_crack@pinion:depth={rng.uniform(0.1, 0.5)},angle_rad={angle}"],
            "pitting": [*own, f"pitting@pinion:share={rng.uniform(0.1, 0.6)},angle_rad={angle}"],
            "wear": [own[0], f"wear:wear_m={drawn(rng, 6e-6, 3e-5)}"],
            "eccentricity": [f"gear_eccentricity@pinion:run_out_m={drawn(rng, 8e-6, 4e-5)}", own[1]],
        }
        before = gear_measures(
            observe(simulated("gearbox", "plausible", own, 10_000 + number, speed_rpm=speed * 1.01, **options))
        )
        for place, (state, effects) in enumerate(states.items()):
            recording = simulated("gearbox", "plausible", effects, 100 * number + place, speed_rpm=speed, **options)
            for name, value in gear_measures(observe(recording)).items():
                values[state][name].append(value)
                values[state][f"{name}, growth"].append(value / max(before[name], 1e-12))
            spacing[state].append(spacing_right(recording, speed / 60))
    shares(values, "healthy")
    print("\ncepstral spacing is the pinion's within 1 %, of records where any spacing stands out:")
    for state, found in spacing.items():
        seen = [one for one in found if np.isfinite(one)]
        print(f"  {state}: {int(sum(seen))} of {len(seen)}, of {len(found)} records")


# ----- whirl


def whirl_measures(recording: Recording) -> dict[str, float]:
    """Return whirl (forward less backward over their sum) of 1X, 2X and the strongest line of 0.3X to 0.6X."""
    vibration = recording.select([i for i, one in enumerate(recording.channels) if one.is_vibration])
    pair, now = probe_pair(vibration.channels), observe(recording)
    names = ("1X whirl", "2X whirl", "whirl below 1X", "1X backward share", "roundness of 1X")
    if pair is None or now.speed is None or not now.turning:
        return dict.fromkeys(names, np.nan)
    found = full_spectrum(*(vibration.signals[one] for one in pair), rate_hz=vibration.rate_hz)

    def line(low: float, high: float) -> tuple[float, float]:
        inside = (found.frequency_hz >= low * now.speed_hz) & (found.frequency_hz <= high * now.speed_hz)
        if not inside.any():
            return 0.0, 0.0
        best = int(np.argmax(np.where(inside, found.forward + found.backward, 0.0)))
        return float(found.forward[best]), float(found.backward[best])

    def whirl(parts: tuple[float, float]) -> float:
        return (parts[0] - parts[1]) / max(sum(parts), 1e-300)

    one, two, below = line(0.97, 1.03), line(1.97, 2.03), line(0.3, 0.6)
    values = (whirl(one), whirl(two), whirl(below), min(one) / max(sum(one), 1e-300), abs(whirl(one)))
    return dict(zip(names, values, strict=True))


def whirl(draws: int, seed: int) -> None:
    """Print the whirl of rotors with faults against sound ones: simulators first, turbines of the blind set then."""
    values: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for number in range(draws):
        rng = np.random.default_rng([seed, number])
        moment = drawn(rng, 1e-3, 1e-2)
        states = {
            "healthy": [],
            "rub": ["rub"],
            "looseness": ["looseness"],
            "oil whirl": [f"oil_whirl:damping_n_s_m={drawn(rng, 500, 1000)},mass_kg=50"],
            "unbalance": [f"unbalance:moment_kg_m={moment}"],
            "bolt loss": ["bolt_loss"],
        }
        for place, (state, effects) in enumerate(states.items()):
            speed = rng.uniform(2700, 3100) if state == "oil whirl" else rng.uniform(1200, 3000)
            options = {"duration_s": 4.0, "rate_hz": 2048.0, "settle_s": 3.0, "speed_rpm": speed}
            try:
                made = simulated("rigid_coupling", "plausible", effects, 100 * number + place, **options)
            except RotorwiseError as problem:
                print(state, problem)
                continue
            for name, value in whirl_measures(made).items():
                values[state][name].append(value)
    print("rotors of the simulators (rigid_coupling)")
    shares(values, "healthy")
    sys.path.insert(0, str(Path(__file__).parent / "blind_set"))
    from blind_cases import build_case

    blind: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for place, state in enumerate(("healthy", "oil_whirl", "rub", "unbalance")):
        index = 0
        while len(blind[state]["1X whirl"]) < draws and index < 40 * draws:
            case = build_case(seed + place, index, state)
            index += 1
            vibration = [one for one in case.recording.channels if one.is_vibration]
            if all(one.quantity == "displacement" for one in vibration) and probe_pair(vibration):
                for name, value in whirl_measures(case.recording).items():
                    blind[state][name].append(value)
    print("\nturbines of the blind set")
    shares(blind, "healthy")


# ----- run-ups


def run_ups(draws: int, seed: int) -> None:
    """Print what features tell at equal angles, and at equal times with the mean speed."""
    even: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    fixed: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    names = ("1x_velocity_share", "1x_signal_to_noise", "2x_signal_to_noise", "outer_race_modulation",
             "outer_race_signal_to_noise", "inner_race_modulation", "inner_race_signal_to_noise")  # fmt: skip
    for number in range(draws):
        rng = np.random.default_rng([seed, number])
        start = rng.uniform(900, 1300)
        profile = ramp(start_rpm=start, stop_rpm=start * rng.uniform(1.1, 1.5), duration_s=4.0)
        mean = float(profile.mean_speed_rad_s) * 30 / np.pi
        states = {
            "healthy": [],
            "unbalance": [f"unbalance@disc:moment_kg_m={drawn(rng, 5e-4, 2e-3)}"],
            "misalignment": [f"coupling_misalignment:offset_m={drawn(rng, 6e-4, 2e-3)},angle_rad=0.04"],
            "outer race": ["outer_race_defect@bearing_a"],
            "inner race": ["inner_race_defect@bearing_a"],
        }
        for place, (state, effects) in enumerate(states.items()):
            made = simulated(
                "test_rig", "adi", effects, 100 * number + place,
                speed_rpm=profile, duration_s=4.0, rate_hz=12_800.0, settle_s=1.5,
                probes=("housing_a_x", "housing_a_y"),
            )  # fmt: skip
            part = made.select([i for i, one in enumerate(made.channels) if one.is_vibration])
            for target, recording in ((even, made), (fixed, replace(part, condition=OperatingCondition(mean)))):
                measured = features(observe(recording))
                for name in names:
                    target[state][name].append(measured[name])
    for title, values in (("at equal angles (tacho)", even), ("at equal times, mean speed known", fixed)):
        print(title)
        shares(values, "healthy")


if __name__ == "__main__":
    what = {"gears": gears, "whirl": whirl, "run_ups": run_ups}[sys.argv[1]]
    what(int(sys.argv[2]) if len(sys.argv) > 2 else 24, int(sys.argv[3]) if len(sys.argv) > 3 else 1)

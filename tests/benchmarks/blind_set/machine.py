"""What stays the same between two records of one machine: structure, bearings, gears, sensors' places."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from rotorwise.datasets.recording import GearPair, MountedBearing, Nameplate
from rotorwise.simulators.rotor_dynamics.rolling_bearing import BearingGeometry, bearing_catalogue
from structure import Structure, draw_structure


@dataclass
class Machine:
    """A machine. ``gains`` holds the force of each source, fixed by the first healthy record."""

    kind: str
    speed_hz: float
    line_hz: float
    poles: int
    structure: Structure
    bearings: tuple[MountedBearing, ...]
    gear: GearPair | None
    nameplate: Nameplate
    seed: int
    slip: float
    coordinates: tuple[int, ...]
    units: tuple[str, ...]
    gains: dict[str, float] = field(default_factory=dict)

    def details(self, source: str) -> np.random.Generator:
        """Random numbers that are the same in each record of this machine, one stream a source."""
        return np.random.default_rng([self.seed, *source.encode()])


def draw_bearing(rng: np.random.Generator) -> BearingGeometry:
    """A catalogue bearing, or one of ordinary proportions."""
    if rng.random() < 0.4:
        catalogue = bearing_catalogue()
        return catalogue[sorted(catalogue)[int(rng.integers(len(catalogue)))]]
    ball = rng.uniform(6e-3, 20e-3)
    angle = float(np.radians(rng.choice([0.0, 0.0, 15.0, 40.0])))
    return BearingGeometry(int(rng.integers(7, 14)), ball, ball / rng.uniform(0.17, 0.29), angle)


def draw_machine(rng: np.random.Generator, label: str) -> Machine:
    """A machine on which the labelled state can exist."""
    kind = draw_kind(rng, label)
    line_hz = float(rng.choice([50.0, 60.0]))
    poles = int(rng.choice([2, 4, 4, 6]))
    slip = rng.uniform(0.006, 0.03)
    speed_hz = float(np.exp(rng.uniform(np.log(10.0), np.log(100.0))))
    if kind == "motor":
        speed_hz = 2 * line_hz / poles * (1 - slip)
    if kind == "turbine":
        speed_hz = rng.uniform(30.0, 100.0)
    gear = None
    if kind == "gearbox":
        gear = GearPair(int(rng.integers(17, 40)), int(rng.integers(41, 90)))
        speed_hz = min(speed_hz, 60.0)
    rolling = kind != "turbine"
    bearings = tuple(MountedBearing(draw_bearing(rng), place) for place in ("DE", "NDE")) if rolling else ()
    coordinates, units = draw_channels(rng, kind)
    return Machine(
        kind=kind,
        speed_hz=speed_hz,
        line_hz=line_hz,
        poles=poles,
        structure=draw_structure(rng, speed_hz),
        bearings=bearings,
        gear=gear,
        nameplate=draw_nameplate(rng, label, bearings, gear, line_hz),
        seed=int(rng.integers(2**31)),
        slip=slip,
        coordinates=coordinates,
        units=units,
    )


def draw_kind(rng: np.random.Generator, label: str) -> str:
    if label.startswith("gear"):
        return "gearbox"
    if label == "electrical":
        return "motor"
    if label == "oil_whirl":
        return "turbine"
    if label in ("rub", "unbalance"):
        return str(rng.choice(["pump", "motor", "turbine"]))
    if label == "healthy":
        return str(rng.choice(["pump", "pump", "motor", "gearbox", "turbine"]))
    if label.startswith("bearing"):
        return str(rng.choice(["pump", "motor", "gearbox"]))
    return str(rng.choice(["pump", "pump", "motor"]))


def draw_channels(rng: np.random.Generator, kind: str) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """Places (see ``structure.COORDINATES``) and stored units of the sensors."""
    if kind == "turbine":
        return ((0, 1) if rng.random() < 0.4 else (0, 1, 3, 4)), ("um",)
    layouts = ((1,), (0, 1), (0, 1, 2), (1, 2), (1, 2, 4), (0, 1, 2, 3, 4, 5))
    places = layouts[int(rng.choice(len(layouts), p=[0.12, 0.13, 0.3, 0.15, 0.15, 0.15]))]
    unit = str(rng.choice(["g", "m/s2", "mm/s"], p=[0.45, 0.35, 0.2]))
    units = [unit] * len(places)
    if unit != "mm/s" and len(places) > 1 and rng.random() < 0.15:
        units[-1] = "mm/s"
    return places, tuple(units)


def draw_nameplate(
    rng: np.random.Generator,
    label: str,
    bearings: tuple[MountedBearing, ...],
    gear: GearPair | None,
    line_hz: float,
) -> Nameplate:
    """What the user tells: mostly all, sometimes nothing."""
    share = 0.95 if label.startswith(("bearing", "gear", "electrical")) else 0.75
    group = bool(rng.random() < 0.7)
    return Nameplate(
        bearings=bearings if rng.random() < share else (),
        gears=(gear,) if gear is not None and rng.random() < max(share, 0.85) else (),
        line_frequency_hz=line_hz if rng.random() < max(share, 0.8) else None,
        power_kw=float(rng.choice([7.5, 30.0, 110.0, 400.0])) if group else None,
        mounting=str(rng.choice(["rigid", "flexible"])) if group else None,
    )

"""What a machine does: kinematics, physics, solvers and synthetic signals. Imports nothing else of rotorwise.

The machines are attributes by name, `simulators.gearbox`, `simulators.amb_rotor`, ...; the effects are in
`simulators.effects`.

Examples
--------
>>> from rotorwise.simulators import amb_rotor, effects
>>> machine = amb_rotor.with_effects(effects.CouplingMisalignment(offset_m=2e-4, angle_rad=0.0))
>>> run = machine.simulate(speed_rpm=3000, duration_s=0.2, rate_hz=1000)
>>> run.signals.shape
(4, 200)
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import effects as effects
    from .machine import Machine as Machine
    from .machine import find_machine as find_machine
    from .machine import machine_catalogue as machine_catalogue
    from .machine import machine_from_toml as machine_from_toml
    from .sensor_chain import SensorChain as SensorChain
    from .solvers.floquet import floquet_multipliers as floquet_multipliers
    from .solvers.harmonic_balance import harmonic_balance as harmonic_balance
    from .solvers.lyapunov import lyapunov_exponent as lyapunov_exponent
    from .solvers.simulate import Simulation as Simulation
    from .solvers.simulate import simulate_batch as simulate_batch
    from .speed_profile import SpeedProfile as SpeedProfile
    from .speed_profile import ramp as ramp
    from .speed_profile import steady as steady
    from .speed_profile import wander as wander

    amb_rotor: Machine
    gearbox: Machine
    rigid_coupling: Machine
    test_rig: Machine

#: Public names and the module that has each; loaded at first use, so that the command line starts fast.
_PLACES = {
    "Machine": "machine",
    "find_machine": "machine",
    "machine_catalogue": "machine",
    "machine_from_toml": "machine",
    "SensorChain": "sensor_chain",
    "Simulation": "solvers.simulate",
    "simulate_batch": "solvers.simulate",
    "harmonic_balance": "solvers.harmonic_balance",
    "floquet_multipliers": "solvers.floquet",
    "lyapunov_exponent": "solvers.lyapunov",
    "SpeedProfile": "speed_profile",
    "ramp": "speed_profile",
    "steady": "speed_profile",
    "wander": "speed_profile",
}


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(importlib.import_module(f".{_PLACES[name]}", __name__), name)
    if name == "effects":
        return importlib.import_module(".effects", __name__)
    if not name.startswith("_"):
        from .machine import machine_catalogue

        if name in machine_catalogue():
            return machine_catalogue()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

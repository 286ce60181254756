"""Campaigns for the gap engine: stepped in time, on a machine whose own parameters are not those of the model."""

from typing import Any

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign, Recording
from rotorwise.datasets.simulated import record_machine
from rotorwise.diagnose.gap import explain as module
from rotorwise.simulators.machine import Machine
from rotorwise.simulators.sensor_chain import SensorChain

CHAIN = SensorChain(pulses_per_revolution=1, noise={"m": 2e-8, "rad": 2e-7, "m/s2": 2e-3, "rad/s": 1e-4})


def altered(machine: Machine, *, share: float, seed: int) -> Machine:
    """The machine with every parameter that has a prior off by ``share`` (standard deviation)."""
    rng = np.random.default_rng(seed)
    load = machine.definition.load_parameter
    uncertain = [p.name for p in machine.definition.parameters if p.prior is not None and p.name != load]
    return machine.with_parameters(
        **{name: machine.values[name] * (1 + share * rng.normal()) for name in uncertain if machine.values[name] != 0}
    )


def recorded(
    machine: Machine,
    speeds_rpm: tuple[float, ...],
    *,
    rate_hz: float,
    duration_s: float,
    seed: int,
    torsion: bool = False,
    **options: float,
) -> tuple[Recording, ...]:
    """Return recordings with all probes of the machine; those of torsion, which hardly anyone has, when asked for."""
    probes = [one.name for one in machine.bare_assembly().probes if torsion or one.unit != "rad"]
    return tuple(
        record_machine(
            machine,
            speed_rpm=rpm,
            duration_s=duration_s,
            rate_hz=rate_hz,
            chain=CHAIN,
            seed=seed + i,
            probes=probes,
            **options,
        ).recording
        for i, rpm in enumerate(speeds_rpm)
    )


def without_tacho(recordings: tuple[Recording, ...]) -> tuple[Recording, ...]:
    found = []
    for one in recordings:
        kept = [i for i, channel in enumerate(one.channels) if channel.quantity != "tacho"]
        assert len(kept) == len(one.channels) - 1
        found.append(one.select(kept))
    return tuple(found)


class _Stopped(Exception):
    pass


def search_inputs(campaign: Campaign, machine: Machine, *, only: frozenset[str]) -> tuple[Any, ...]:
    """Return what the search is given: problem, screening and what unknown forces make."""
    kept: list[Any] = []

    def stop(*given: Any, **_: Any) -> None:
        kept.extend(given)
        raise _Stopped

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "search", stop)
        with pytest.raises(_Stopped):
            module.explain_gap(campaign, machine, only=only)
    return tuple(kept)

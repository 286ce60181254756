"""How much parallel and angular misalignment a linear machine bears: peak displacement over both, by superposition.

For fixed phases the steady motion of a linear machine is exactly x = x_0 + offset x_1 + angle x_2, whatever the
stiffness does within a revolution. Three solutions of one harmonic balance therefore give the whole map. The peak over
a revolution is the largest of |x| over instants, a maximum of affine functions: every set "peak below a limit" is
convex.

Source: paper 000, section 4.2, Figs 10-12. Zone limits as a share of the clearance: ISO 14839-2 (the paper names
ISO 7919-1, which has other limits).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .effects.coupling_misalignment import CouplingMisalignment
from .errors import InvalidValueError
from .law import Timeline

if TYPE_CHECKING:
    from .machine import Machine
    from .system import System

#: Upper limits of the zones A, B and C as a share of the smallest radial clearance (ISO 14839-2).
ZONE_LIMITS = (0.3, 0.4, 0.5)
#: Instants of a revolution: the peak of 1X is missed by at most 8e-5 of itself.
INSTANTS = 256


@dataclass(frozen=True)
class ThresholdMap:
    """Peak of each probe over parallel and angular misalignment.

    Attributes
    ----------
    probes : tuple of str
    offsets_m : ndarray (offsets,)
    angles_rad : ndarray (angles,)
    peaks : ndarray (probes, offsets, angles)
        Largest absolute value in a revolution, mean included, in the probes' unit.
    """

    probes: tuple[str, ...]
    offsets_m: np.ndarray
    angles_rad: np.ndarray
    peaks: np.ndarray

    def zones(self, clearance_m: float) -> np.ndarray:
        """Return 0, 1, 2, 3 for zone A, B, C, D, shape (probes, offsets, angles)."""
        if not clearance_m > 0:
            raise InvalidValueError(f"Clearance {clearance_m} m; allowed: more than 0. Give the radial clearance.")
        return np.digitize(self.peaks, clearance_m * np.array(ZONE_LIMITS), right=True)

    def largest_offset_m(self, limit_m: float) -> np.ndarray:
        """Return for each probe the largest offset of the map without angle that keeps the peak, NaN for none."""
        return self._largest(self.peaks[:, :, int(np.argmin(np.abs(self.angles_rad)))], self.offsets_m, limit_m)

    def largest_angle_rad(self, limit_m: float) -> np.ndarray:
        """Return for each probe the largest angle of the map without offset that keeps the peak, NaN for none."""
        return self._largest(self.peaks[:, int(np.argmin(np.abs(self.offsets_m))), :], self.angles_rad, limit_m)

    @staticmethod
    def _largest(peaks: np.ndarray, values: np.ndarray, limit_m: float) -> np.ndarray:
        allowed = np.where(peaks <= limit_m, values, -np.inf).max(axis=1)
        return np.where(np.isfinite(allowed), allowed, np.nan)


def threshold_map(
    machine: Machine,
    speed_rpm: float,
    offsets_m: np.ndarray,
    angles_rad: np.ndarray,
    *,
    offset_phase_rad: float = 0.0,
    angle_phase_rad: float = 0.0,
    harmonics: int = 8,
) -> ThresholdMap:
    """Return the peak of every probe for every pair of parallel and angular misalignment at one speed.

    Parameters
    ----------
    machine : Machine
        Linear, with a coupling; misalignment of its own is added to.
    speed_rpm : float
    offsets_m, angles_rad : ndarray (offsets,), (angles,)
    offset_phase_rad, angle_phase_rad : float
        As in `CouplingMisalignment`; the map depends on their difference, and on both against the unbalance.
    harmonics : int
        Highest order of the harmonic balance.

    Raises
    ------
    InvalidValueError
        For a machine that is not linear, or whose misalignment does more than add a force.
    """
    offsets, angles = np.atleast_1d(np.asarray(offsets_m, float)), np.atleast_1d(np.asarray(angles_rad, float))
    if offsets.ndim != 1 or angles.ndim != 1 or not (np.all(np.isfinite(offsets)) and np.all(np.isfinite(angles))):
        raise InvalidValueError("Offsets and angles of the map; allowed: two lists of finite numbers.")
    unshifted = CouplingMisalignment(
        offset_m=0.0, angle_rad=0.0, offset_phase_rad=offset_phase_rad, angle_phase_rad=angle_phase_rad
    )
    bounds = {declared.name: declared.bounds[1] for declared in CouplingMisalignment.parameters()}
    units = (bounds["offset_m"], bounds["angle_rad"])
    shifted = [unshifted.with_values(offset_m=units[0]), unshifted.with_values(angle_rad=units[1])]
    names, waves = _waveforms([machine, *(machine.with_effects(effect) for effect in shifted)], speed_rpm, harmonics)
    waves[1:] = (waves[1:] - waves[0]) / np.array(units)[:, None, None]
    peaks = np.array([_peaks(offsets, angles, waves[:, probe]) for probe in range(len(names))])
    return ThresholdMap(names, offsets, angles, peaks)


def _peaks(offsets: np.ndarray, angles: np.ndarray, waves: np.ndarray) -> np.ndarray:
    """Return max |w_0 + offset w_1 + angle w_2| (offsets, angles) for waves (3, instants).

    Row by row: one sum an element, within the cache, without the threads of a matrix product.
    """
    tilted = np.multiply.outer(angles, waves[2])
    found = np.empty((offsets.size, angles.size))
    for row, offset in enumerate(offsets):
        values = tilted + (waves[0] + offset * waves[1])
        np.maximum(values.max(axis=1), -values.min(axis=1), out=found[row])
    return found


def _waveforms(machines: list[Machine], speed_rpm: float, harmonics: int) -> tuple[tuple[str, ...], np.ndarray]:
    """Return probe names and one revolution of each machine's probes, shape (machines, probes, instants).

    The machines differ in forces only, so that one balance serves all; `harmonic_balance` would solve each anew.
    """
    from .solvers.harmonic_balance import balance_matrix

    systems = [machine.system(speed_rpm=speed_rpm) for machine in machines]
    parts = [_linear_parts(system) for system in systems]
    system, slope = systems[0], parts[0][1]
    same_core = all(np.array_equal(s.core, system.core) for s in systems)
    if not same_core or any(own.shape != slope.shape or not np.array_equal(own, slope) for _, own in parts):
        raise InvalidValueError(
            f"A misalignment of machine {machines[0].name} changes its stiffness, so that responses do not add up; "
            "allowed: couplings where it only adds a force. Solve each case by harmonic balance."
        )
    responses, probe_responses = _responses(system, harmonics)
    matrix, wide = balance_matrix(slope, responses)
    orders = np.arange(-harmonics, harmonics + 1)
    constants = np.array([constant for constant, _ in parts])
    spectra = (np.fft.fft(constants) / constants.shape[-1])[:, :, orders]
    right = np.einsum("amf,sfa->ams", wide, spectra)
    motions = np.linalg.solve(matrix, right.reshape(-1, len(parts))).reshape(right.shape)
    phase = 2 * np.pi * np.arange(slope.shape[-1]) / slope.shape[-1]
    motion = np.einsum("ams,at->smt", motions, np.exp(1j * np.outer(orders, phase))).real
    forces = constants + np.einsum("fmt,smt->sft", slope, motion)
    amplitudes = np.einsum("arf,sfa->sra", probe_responses, (np.fft.rfft(forces) / phase.size)[:, :, : harmonics + 1])
    amplitudes[:, :, 1:] *= 2
    wave = np.exp(2j * np.pi * np.outer(np.arange(harmonics + 1), np.arange(INSTANTS) / INSTANTS))
    return tuple(probe.name for probe in system.probes), (amplitudes @ wave).real


def _responses(system: System, harmonics: int) -> tuple[np.ndarray, np.ndarray]:
    """Return what a force does to interface motions and to probes at the orders 0 .. harmonics."""
    seen = []
    for order in range(harmonics + 1):
        pencil = 1j * order * system.speed_rad_s * np.eye(system.states) - system.core
        states = np.linalg.solve(pencil, system.force_columns)
        seen.append((system.motion_rows @ states, system.probe_rows @ states + system.probe_columns))
    motions, probes = zip(*seen, strict=True)
    return np.array(motions), np.array(probes)


def _linear_parts(system: System) -> tuple[np.ndarray, np.ndarray]:
    """Return one revolution of s (forces, instants) and S (forces, motions, instants) of u = s + S C y."""
    phase = 2 * np.pi * np.arange(INSTANTS)[:, None] / INSTANTS
    speed = np.full(phase.shape, system.speed_rad_s)
    timeline = Timeline(phase / system.speed_rad_s, phase, speed, np.zeros(phase.shape))
    count = system.force_columns.shape[1]
    constant, slope = np.zeros((count, INSTANTS)), np.zeros((count, system.motion_rows.shape[0], INSTANTS))
    for force, reads, acts in zip(system.forces, system.inputs, system.outputs, strict=True):
        if not force.law.is_linear:
            raise InvalidValueError(
                f"The force {force.name!r} is not linear in the motion; allowed: linear machines. Solve each case by "
                "harmonic balance or simulation."
            )
        signals = force.law.signals(timeline, np.array(force.parameters)[:, None])[:, :, 0]
        constant[acts] += signals[: acts.size]
        for i, act in enumerate(acts):
            for j, read in enumerate(reads):
                slope[act, read] += signals[acts.size + i * reads.size + j]
    return constant, slope

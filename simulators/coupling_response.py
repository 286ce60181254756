"""Steady response of a machine as a function of the stiffness harmonics of its flexible coupling.

With z = d + s the elongation of the coupling including its misalignment, and h(phi) the varying part of its stiffness,
the coupling adds f = -k0 h z to a machine whose other parts are linear with constant coefficients. In Fourier
components X(phi) = sum_m X_m exp(i m phi), at constant speed,

    z_m = z0_m + R_m f_m,     f_m = -k0 sum_n h_n z_(m-n),     probes_m = probes0_m + P_m f_m.

z0 and probes0 are the response with constant stiffness, R and P the frequency responses to coupling forces; they are
computed once, so that another set of harmonics costs one small linear system. Source: paper 000, Eqs (1)-(5) in
steady state.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .errors import InvalidValueError
from .law import InterfaceForce, Timeline
from .rotor_dynamics.flexible_coupling import FLEXIBLE_COUPLING, split_parameters, without_harmonics

if TYPE_CHECKING:
    from .machine import Machine
    from .system import System


@dataclass(frozen=True)
class CouplingResponse:
    """See the module. 2 H + 1 orders m = -H .. H, d coupling directions, r probes.

    Attributes
    ----------
    directions : tuple of str
        Names of the coupling's forces, in the order of d.
    probes : tuple of str
    stiffness : ndarray (d,)
        k0, negative where the coupling has the reversed sign.
    elongation : ndarray (2 H + 1, d), complex
        z0 in m and rad.
    compliance : ndarray (2 H + 1, d, d), complex
        R.
    probe_base : ndarray (2 H + 1, r), complex
    probe_compliance : ndarray (2 H + 1, r, d), complex
        P.
    """

    directions: tuple[str, ...]
    probes: tuple[str, ...]
    stiffness: np.ndarray
    elongation: np.ndarray
    compliance: np.ndarray
    probe_base: np.ndarray
    probe_compliance: np.ndarray

    @property
    def highest_order(self) -> int:
        """H."""
        return len(self.elongation) // 2

    def amplitudes(self, cos: np.ndarray, sin: np.ndarray | None = None) -> np.ndarray:
        """Return the probes' complex amplitudes A_m, one-sided: probe = A_0 + Re sum_m A_m exp(i m phi).

        Parameters
        ----------
        cos, sin : ndarray (..., d, N)
            Stiffness harmonics as a fraction of k0; ``sin`` zero when left out.

        Returns
        -------
        ndarray (..., r, H + 1), complex
        """
        harmonics = _two_sided(cos, sin, self.highest_order)
        force = -self.stiffness * self._times_harmonics(harmonics, self._elongation(harmonics))
        return _one_sided(self.probe_base + _apply(self.probe_compliance, force))

    def sensitivity(self, cos: np.ndarray, sin: np.ndarray | None = None) -> np.ndarray:
        """Return d amplitudes / d cos at one set of harmonics, shape (r, H + 1, d, N)."""
        return self._sensitivity(cos, sin, part=0.5)

    def sensitivity_to_sin(self, cos: np.ndarray, sin: np.ndarray | None = None) -> np.ndarray:
        """Return d amplitudes / d sin at one set of harmonics, shape (r, H + 1, d, N)."""
        return self._sensitivity(cos, sin, part=-0.5j)

    def _sensitivity(self, cos: np.ndarray, sin: np.ndarray | None, *, part: complex) -> np.ndarray:
        directions, number = np.shape(cos)
        harmonics = _two_sided(cos, sin, self.highest_order)
        elongation = self._elongation(harmonics)
        unit = np.zeros((directions, number, directions, 2 * number + 1), complex)
        for d in range(directions):
            for n in range(1, number + 1):
                unit[d, n - 1, d, number + n], unit[d, n - 1, d, number - n] = part, np.conj(part)
        direct = -self.stiffness * self._times_harmonics(unit, elongation)
        change = self._solve(harmonics, _apply(self.compliance, direct))
        force = direct - self.stiffness * self._times_harmonics(harmonics, change)
        return np.moveaxis(_one_sided(_apply(self.probe_compliance, force)), (0, 1), (2, 3))

    def _elongation(self, harmonics: np.ndarray) -> np.ndarray:
        return self._solve(harmonics, np.broadcast_to(self.elongation, (*harmonics.shape[:-2], *self.elongation.shape)))

    def _solve(self, harmonics: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Solve z_m + R_m k0 sum_n h_n z_(m-n) = right_m; ``right`` may have more leading axes than the harmonics."""
        coupled = np.einsum("mdc,...mkc->...mdkc", self.compliance * self.stiffness, self._toeplitz(harmonics))
        size = self.elongation.size
        matrix = coupled.reshape(*coupled.shape[:-4], size, size) + np.eye(size)
        solution = np.linalg.solve(matrix, right.reshape(*right.shape[:-2], size, 1))
        return solution.reshape(right.shape)

    def _times_harmonics(self, harmonics: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.einsum("...mkd,...kd->...md", self._toeplitz(harmonics), values)

    def _toeplitz(self, harmonics: np.ndarray) -> np.ndarray:
        """Return h_(m-k) as (..., 2 H + 1, 2 H + 1, d) from two-sided coefficients (..., d, 2 N + 1)."""
        number, orders = harmonics.shape[-1] // 2, 2 * self.highest_order + 1
        step = np.subtract.outer(np.arange(orders), np.arange(orders))
        inside = np.abs(step) <= number
        picked = harmonics[..., np.where(inside, step + number, 0)] * inside
        return np.moveaxis(picked, -3, -1)


def coupling_response(machine: Machine, *, speed_rpm: float, highest_order: int = 8) -> CouplingResponse:
    """Prepare the response of a machine with one flexible coupling, at one constant speed.

    The machine's own stiffness harmonics are left out: `CouplingResponse.amplitudes` takes them as its argument.

    Raises
    ------
    InvalidValueError
        When the machine has no flexible coupling, or is nonlinear or time-periodic in another part.
    """
    system = machine.system(speed_rpm=speed_rpm)
    coupling = [i for i, force in enumerate(system.forces) if force.law is FLEXIBLE_COUPLING]
    if not coupling:
        raise InvalidValueError(
            f"Machine {machine.name} has no flexible coupling; allowed: one that has, such as amb_rotor."
        )
    forces = [without_harmonics(f) if i in coupling else f for i, f in enumerate(system.forces)]
    exciting = _excitation(system, forces, highest_order)
    split = [split_parameters(system.forces[i]) for i in coupling]
    misalignment = np.zeros((highest_order + 1, len(coupling)), complex)
    misalignment[0] = [part.offset[0] for part in split]
    misalignment[1] = [(part.offset[1] - 1j * part.offset[2]) / 2 for part in split]
    columns = [int(system.outputs[i][0]) for i in coupling]
    rows = system.motion_rows[[int(system.inputs[i][0]) for i in coupling]]
    results = [_order_response(system, rows, columns, exciting[m], m) for m in range(highest_order + 1)]
    elongation, compliance, base, probe_compliance = (np.array(part) for part in zip(*results, strict=True))
    return CouplingResponse(
        directions=tuple(system.forces[i].name for i in coupling),
        probes=tuple(probe.name for probe in system.probes),
        stiffness=np.array([part.stiffness for part in split]),
        elongation=_mirrored(elongation + misalignment),
        compliance=_mirrored(compliance),
        probe_base=_mirrored(base),
        probe_compliance=_mirrored(probe_compliance),
    )


def _excitation(system: System, forces: list[InterfaceForce], highest_order: int) -> np.ndarray:
    """Return the Fourier components (H + 1, interface forces) of the forces without motion; refuse any with motion."""
    count = 4 * highest_order + 4
    phase = 2 * np.pi * np.arange(count)[:, None] / count
    speed = np.full(phase.shape, system.speed_rad_s)
    timeline = Timeline(phase / system.speed_rad_s, phase, speed, np.zeros(phase.shape))
    total = np.zeros((highest_order + 1, system.force_columns.shape[1]), complex)
    for force, outputs in zip(forces, system.outputs, strict=True):
        signals = force.law.signals(timeline, np.array(force.parameters)[:, None]) if force.law.is_linear else None
        if signals is None or np.any(signals[len(outputs) :]):
            raise InvalidValueError(
                f"The force {force.name!r} depends on the motion in a way that is not constant; allowed here: only the "
                "coupling. Leave that effect out, or use harmonic balance."
            )
        total[:, outputs] += np.fft.fft(signals[: len(outputs), :, 0])[:, : highest_order + 1].T / count
    return total


def _order_response(
    system: System, rows: np.ndarray, columns: list[int], exciting: np.ndarray, order: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    pencil = 1j * order * system.speed_rad_s * np.eye(system.states) - system.core
    right = np.column_stack([system.force_columns @ exciting, system.force_columns[:, columns]])
    states = np.linalg.solve(pencil, right)
    seen, probes = rows @ states, system.probe_rows @ states
    probes[:, 0] += system.probe_columns @ exciting
    probes[:, 1:] += system.probe_columns[:, columns]
    return seen[:, 0], seen[:, 1:], probes[:, 0], probes[:, 1:]


def _apply(transfer: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return transfer_m force_m for (m, r, d) and (..., m, d)."""
    return np.einsum("mrd,...md->...mr", transfer, force)


def _mirrored(half: np.ndarray) -> np.ndarray:
    """Return the orders -H .. H of a real signal from its orders 0 .. H."""
    return np.concatenate([half[:0:-1].conj(), half])


def _one_sided(two_sided: np.ndarray) -> np.ndarray:
    """Return (..., r, H + 1) amplitudes from (..., 2 H + 1, r)."""
    highest = two_sided.shape[-2] // 2
    half = np.moveaxis(two_sided[..., highest:, :], -1, -2).copy()
    half[..., 1:] *= 2
    return half


def _two_sided(cos: np.ndarray, sin: np.ndarray | None, highest_order: int) -> np.ndarray:
    """Return Fourier coefficients (..., d, 2 N + 1) of a series given by cosines and sines (..., d, N)."""
    cos = np.asarray(cos, float)
    positive = cos / 2 if sin is None else (cos - 1j * np.asarray(sin, float)) / 2
    if cos.shape[-1] > highest_order:
        raise InvalidValueError(
            f"{cos.shape[-1]} stiffness harmonics with orders up to {highest_order}; allowed: at most as many as "
            "orders. Raise highest_order."
        )
    mean = np.zeros((*cos.shape[:-1], 1))
    return np.concatenate([positive[..., ::-1].conj(), mean, positive], axis=-1).astype(complex)

"""Active magnetic bearing with its control loop, one axis: sensor, PID controller, power amplifier, actuator.

Sign convention, held throughout: the force on the rotor is

    F = + k_s q + k_i i,     i = - G_a(s) G_c(s) G_s(s) q,

with displacement q, k_s > 0 the magnitude of the negative stiffness (the magnets attract: a rotor off centre is
pulled further off) and k_i > 0. Without current the bearing is unstable, as a real one is.

Source: the "coupling misalignment" study of a rotor on magnetic bearings (paper 000 of this project), Eqs (7)-(9),
read with this convention. Printed Eq (7), F = -k_s q + k_i i, would make the magnets centre the rotor for k_s > 0;
Eq (10) of the same paper, K - k_s T^T T, has the sign used here, so the two contradict each other. Eq (10) besides
lists its states as {q', q} but uses matrix rows that hold for {q, q'}, and feeds the current into the row of q. The
paper's k_s also names the sensor gain of Eq (9); here that is ``sensor_gain_v_m``.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from ..errors import InvalidValueError


@dataclass(frozen=True, eq=False)
class ControllerMatrices:
    """State-space form of the path from displacement to current, x' = A x + B q, i = C x; read-only.

    The states are: integral of the sensor voltage error in V s; that error behind the lag of the derivative filter
    in V; amplifier input behind the first lag in V; and behind both lags in V. The error is -(sensor gain) q.

    Attributes
    ----------
    state : numpy.ndarray
        A, shape (4, 4).
    input : numpy.ndarray
        B, shape (4,), multiplies the displacement in m.
    output : numpy.ndarray
        C, shape (4,), gives the current in A.
    """

    state: np.ndarray
    input: np.ndarray
    output: np.ndarray


@dataclass(frozen=True)
class MagneticBearing:
    """One axis of a magnetic bearing: G_s = sensor gain, G_c = K_P + K_I/s + K_D s/(T_D s + 1),
    G_a = k_a / ((T_a s + 1)(T_b s + 1)).

    Parameters
    ----------
    current_stiffness_n_a : float
        k_i in N/A, above 0.
    displacement_stiffness_n_m : float
        k_s in N/m, the magnitude of the negative stiffness, at least 0.
    sensor_gain_v_m, amplifier_gain_a_v : float
        Static gains in V/m and A/V, above 0.
    proportional, integral, derivative : float
        K_P in V/V, K_I in 1/s, K_D in s, at least 0.
    first_amplifier_time_s, second_amplifier_time_s, derivative_filter_time_s : float
        T_a, T_b and T_D in s, above 0.
    """  # noqa: D205

    current_stiffness_n_a: float
    displacement_stiffness_n_m: float
    sensor_gain_v_m: float
    amplifier_gain_a_v: float
    proportional: float
    integral: float
    derivative: float
    first_amplifier_time_s: float
    second_amplifier_time_s: float
    derivative_filter_time_s: float

    def __post_init__(self) -> None:
        may_be_zero = {"displacement_stiffness_n_m", "proportional", "integral", "derivative"}
        for field in fields(self):
            value = getattr(self, field.name)
            zero_allowed = field.name in may_be_zero
            if not (np.isfinite(value) and (value > 0 or (zero_allowed and value == 0))):
                raise InvalidValueError(
                    f"{field.name} is {value}; allowed: a number {'of at least' if zero_allowed else 'above'} 0. "
                    "Give magnitudes, the signs are built in."
                )

    def transfer(self, s: np.ndarray) -> np.ndarray:
        """Return current over displacement in A/m, -G_a G_c G_s, at the complex frequencies ``s`` in rad/s.

        Same shape as ``s``. With an integral gain there is a pole at 0.
        """
        s = np.asarray(s, dtype=complex)
        controller = self.proportional + self.derivative * s / (self.derivative_filter_time_s * s + 1)
        if self.integral:
            controller = controller + self.integral / s
        lags = (self.first_amplifier_time_s * s + 1) * (self.second_amplifier_time_s * s + 1)
        return -self.sensor_gain_v_m * self.amplifier_gain_a_v * controller / lags

    def dynamic_stiffness_n_m(self, s: np.ndarray) -> np.ndarray:
        """Return minus force over displacement in N/m, -k_s - k_i i/q, at the complex frequencies ``s`` in rad/s.

        The real part at s = j omega is the stiffness, the imaginary part over omega the damping that the rotor sees.
        """
        return -self.displacement_stiffness_n_m - self.current_stiffness_n_a * self.transfer(s)

    def controller(self) -> ControllerMatrices:
        """Return the four-state realisation of ``transfer``, Eqs (8) and (9)."""
        sensor, filter_time = self.sensor_gain_v_m, self.derivative_filter_time_s
        first, second = self.first_amplifier_time_s, self.second_amplifier_time_s
        fast = self.derivative / filter_time
        state = np.array(
            [
                [0.0, 0.0, 0.0, 0.0],
                [0.0, -1 / filter_time, 0.0, 0.0],
                [self.integral / first, -fast / first, -1 / first, 0.0],
                [0.0, 0.0, 1 / second, -1 / second],
            ]
        )
        drive = -sensor * np.array([1.0, 1 / filter_time, (self.proportional + fast) / first, 0.0])
        output = np.array([0.0, 0.0, 0.0, self.amplifier_gain_a_v])
        for array in (state, drive, output):
            array.setflags(write=False)
        return ControllerMatrices(state, drive, output)

    def closed_loop_matrix(self, mass_kg: float) -> np.ndarray:
        """Return the state matrix of a rigid mass in the bearing, shape (6, 6); states q, q', then the controller's."""
        if not (np.isfinite(mass_kg) and mass_kg > 0):
            raise InvalidValueError(f"Mass {mass_kg} kg; allowed: above 0. Give the mass that this bearing carries.")
        control = self.controller()
        matrix = np.zeros((6, 6))
        matrix[0, 1] = 1.0
        matrix[1, 0] = self.displacement_stiffness_n_m / mass_kg
        matrix[1, 2:] = self.current_stiffness_n_a / mass_kg * control.output
        matrix[2:, 0] = control.input
        matrix[2:, 2:] = control.state
        return matrix

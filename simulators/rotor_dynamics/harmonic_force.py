"""Forces that repeat with the shaft angle and do not depend on the motion: unbalance, ripple, weight."""

from __future__ import annotations

import math

import numpy as np

from ..assembly import Place, combination
from ..errors import InvalidValueError
from ..law import Direction, InterfaceForce, Law, Timeline


def _harmonic_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    cos, sin = timeline.cos_sin(parameters[0])
    # A power of 0 costs as much as any other.
    scale = np.abs(timeline.speed_rad_s) ** parameters[1] if parameters[1].any() else 1.0
    return np.stack([scale * (c * cos + s * sin) for c, s in zip(parameters[2::2], parameters[3::2], strict=True)])


def _rotating_mass_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    ratio, real, imaginary = parameters
    cos, sin = timeline.cos_sin(ratio)
    # In complex form F = (w^2 - i dw/dt) U exp(i w t), U = m e exp(i psi): centripetal and tangential inertia.
    centripetal, tangential = (ratio * timeline.speed_rad_s) ** 2, ratio * timeline.acceleration_rad_s2
    along, across = real * cos - imaginary * sin, real * sin + imaginary * cos
    if not timeline.acceleration_rad_s2.any():
        return np.stack([centripetal * along, centripetal * across])
    return np.stack([centripetal * along + tangential * across, centripetal * across - tangential * along])


def _harmonic_wave(parameters: np.ndarray, speed_rad_s: float) -> tuple[float, float, np.ndarray]:
    scale = abs(speed_rad_s) ** parameters[1]
    return float(parameters[0]), 0.0, scale * (parameters[2::2] - 1j * parameters[3::2])


HARMONIC_FORCE = Law("force that repeats with the shaft angle", _harmonic_signals, wave=_harmonic_wave)
ROTATING_MASS = Law("rotating mass", _rotating_mass_signals)


def harmonic_force(
    name: str,
    outputs: tuple[Direction, ...],
    *,
    order: float,
    cos: tuple[float, ...],
    sin: tuple[float, ...],
    speed_power: float = 0.0,
) -> InterfaceForce:
    """Return F_i = speed^p (cos_i cos(order phi) + sin_i sin(order phi)) on each output.

    Parameters
    ----------
    name : str
    outputs : tuple of Direction
    order : float
        Of the reference shaft; 0 for a constant force.
    cos, sin : tuple of float
        One coefficient for each output, N (or N.m) over (rad/s) to the power ``speed_power``.
    speed_power : float
    """
    if not len(outputs) == len(cos) == len(sin):
        raise InvalidValueError(f"Force {name}: {len(outputs)} outputs, {len(cos)} and {len(sin)} coefficients.")
    pairs = [value for pair in zip(cos, sin, strict=True) for value in pair]
    return InterfaceForce(name, HARMONIC_FORCE, (order, speed_power, *pairs), outputs)


def rotating_mass(name: str, place: Place, *, moment_kg_m: float, angle_rad: float) -> InterfaceForce:
    """Return the force of an unbalance m e at ``place``: m e w^2 turning with its shaft.

    When the speed changes, the tangential inertia force m e dw/dt is included.

    Parameters
    ----------
    name : str
    place : Place
        With "x" and "y" directions, on a turning shaft.
    moment_kg_m : float
        Unbalance m e.
    angle_rad : float
        From x at shaft angle 0, positive in the sense of rotation.
    """
    outputs = (place.directions["x"], place.directions["y"])
    parts = (moment_kg_m * math.cos(angle_rad), moment_kg_m * math.sin(angle_rad))
    return InterfaceForce(name, ROTATING_MASS, (place.shaft_ratio, *parts), outputs)


def rotating_couple(name: str, place: Place, *, couple_kg_m2: float, angle_rad: float) -> InterfaceForce | None:
    """Return the moment that an unbalance beside the middle of a part has about it; None where the part cannot tilt.

    Parameters
    ----------
    name : str
    place : Place
        With "angle_x" and "angle_y" directions, if it can tilt; the slope of its axis is angle_y in x, -angle_x in y.
    couple_kg_m2 : float
        Unbalance m e times its distance from the middle, along the shaft.
    angle_rad : float
        Of the unbalance, from x at shaft angle 0, positive in the sense of rotation.
    """
    if not {"angle_x", "angle_y"} <= set(place.directions):
        return None
    outputs = (place.directions["angle_y"], combination((-1.0, place.directions["angle_x"])))
    parts = (couple_kg_m2 * math.cos(angle_rad), couple_kg_m2 * math.sin(angle_rad))
    return InterfaceForce(name, ROTATING_MASS, (place.shaft_ratio, *parts), outputs)


def turning_force(name: str, place: Place, *, force_n: float, angle_rad: float) -> InterfaceForce:
    """Return a force of constant size at ``place`` that turns with its shaft.

    Parameters
    ----------
    name : str
    place : Place
        With "x" and "y" directions, on a turning shaft.
    force_n : float
    angle_rad : float
        From x at shaft angle 0, positive in the sense of rotation.
    """
    along, across = force_n * math.cos(angle_rad), force_n * math.sin(angle_rad)
    return harmonic_force(
        name,
        (place.directions["x"], place.directions["y"]),
        order=place.shaft_ratio,
        cos=(along, across),
        sin=(-across, along),
    )

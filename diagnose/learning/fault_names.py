"""From what a simulation was given to what a diagnosis calls it."""

from __future__ import annotations

from collections.abc import Iterable

HEALTHY = "healthy"

#: Simulated effects that are faults of a machine, by the name that every answer uses (``result.FAULTS``).
FAULT_OF_EFFECT = {
    "unbalance": "unbalance",
    "coupling_misalignment": "misalignment",
    "axis_misalignment": "misalignment",
    "misalignment_forces": "misalignment",
    "shaft_bow": "bent_shaft",
    "looseness": "looseness",
    "bolt_loss": "looseness",
    "soft_foot": "looseness",
    "rub": "rub",
    "oil_whirl": "oil_whirl",
    "outer_race_defect": "bearing_outer_race",
    "inner_race_defect": "bearing_inner_race",
    "ball_defect": "bearing_ball",
    "cage_defect": "bearing_cage",
    "wear": "gear_wear",
    "backlash_growth": "gear_wear",
    "tooth_crack": "gear_tooth_fault",
    "pitting": "gear_tooth_fault",
    "gear_eccentricity": "gear_eccentricity",
    "twice_line_force": "electrical",
    "pole_pass": "electrical",
    "housing_resonance": "resonance",
    "clipping": "sensor_fault",
    "dropped_samples": "sensor_fault",
    "dc_drift": "sensor_fault",
}

#: Simulated effects that sound machines have too, in a measure: no label.
IMPERFECTIONS = (
    "clock_error",
    "coupling_stiffness_harmonics",
    "gravity",
    "load_fluctuation",
    "mains_hum",
    "mesh_error_harmonics",
    "mounting_resonance",
    "quantisation",
    "remounted_sensor",
    "rotating_coupling_force",
    "run_out",
    "speed_wander",
    "support_anisotropy",
    "torque_ripple",
)


def fault_of(effects: Iterable[str]) -> str:
    """Return the fault that effects make: one name, several joined by " + ", or "healthy" for none.

    An effect without a name of its own in the diagnosis keeps its simulator's name; imperfections that sound machines
    have too are left out.

    Examples
    --------
    >>> fault_of(["coupling_misalignment"])
    'misalignment'
    >>> fault_of([])
    'healthy'
    """
    names = {FAULT_OF_EFFECT.get(effect, effect) for effect in effects if effect not in IMPERFECTIONS}
    return " + ".join(sorted(names)) or HEALTHY

"""Forces of a bearing whose rings are held apart, over many turns: what a defect does, without a machine's dynamics."""

import numpy as np
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import find_machine

#: A bearing with Hertz contacts and one that is a linear spring.
KINDS = [("gearbox", "bearing 1"), ("test_rig", "bearing_a")]


def part_of(machine, effect, at=""):
    """Return the bearing with the effect, before it is finished."""
    assembly = find_machine(machine).bare_assembly()
    effect.contribute(assembly)
    return assembly.component("bearing", at)


def interface(part):
    """Return the bearing's interface force."""
    if hasattr(part, "interface_force"):
        return part.interface_force()
    from rotorwise.simulators.assembly import Assembly

    assembly = Assembly(speed_rad_s=0.0)
    part.finish(assembly)
    return assembly.forces[0]


def core_stiffness(part):
    return part.core_stiffness_n_m if hasattr(part, "core_stiffness_n_m") else part.stiffness_x_n_m


def force_over_turns(part, phase_rad, *, push_m, angle_rad=None):
    """Return the force (2, angles) on the inner ring, pushed by ``push_m`` in the direction of the load."""
    angle = part.load_angle_rad if angle_rad is None else angle_rad
    own = interface(part)
    phase = np.asarray(phase_rad, float)[:, None]
    timeline = Timeline(phase, phase, np.ones_like(phase), np.zeros_like(phase))
    parameters = np.array(own.parameters)[:, None]
    signals = np.ascontiguousarray(own.law.signals(timeline, parameters)[:, :, 0])
    lanes = signals.shape[1]
    x = np.ascontiguousarray(push_m * np.array([[np.cos(angle)], [np.sin(angle)]]) * np.ones(lanes))
    rows, u = np.arange(2), np.zeros((2, lanes))
    own.law.force(signals, np.ascontiguousarray(np.repeat(parameters, lanes, axis=1)), x, rows, rows, u)
    return u - core_stiffness(part) * x


def lines(signal, turns, *, share=1e-3):
    """Return the orders whose amplitude is above ``share`` of the largest, of a signal over whole turns."""
    size = np.abs(np.fft.rfft(signal - signal.mean()))
    return np.flatnonzero(size > share * size.max()) / turns

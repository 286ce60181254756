"""The modes below a frequency, found without those above, against all eigenvalues of the core."""

import numpy as np
import pytest
from rotorwise.simulators.rotor_dynamics.flexible_shaft import add_bending, bending_at
from rotorwise.simulators.rotor_dynamics.shaft_parts import Disc, Material, ShaftElement
from rotorwise.simulators.solvers import block_form
from rotorwise.simulators.solvers.low_modes import low_modes

from .small_machines import add_probes, define

STEEL = Material(2.1e11, 7850.0, 0.3)
NODES, CUT_HZ = 31, 800.0


def rotor(*, stiffness=1e7, damping=300.0, cross=0.0):
    """Return a shaft of 1 m with a large disc out of its middle."""

    def build(assembly, values, switches):
        disc = Disc.from_geometry(9, width_m=0.03, outer_diameter_m=0.4, density_kg_m3=7850.0)
        elements = [ShaftElement(1.0 / (NODES - 1), 0.03)] * (NODES - 1)
        add_bending(assembly, "node", elements=elements, discs=[disc], material=STEEL, damping_ratio=0.01)
        for node in (0, NODES - 1):
            along = bending_at("node", node)
            assembly.add_spring(along["x"], stiffness=stiffness, damping=damping)
            assembly.add_spring(along["y"], stiffness=0.7 * stiffness, damping=damping)
            names = [*along["x"], *along["y"]]
            assembly.add_matrix("stiffness", names, cross * np.array([[0.0, 1.0], [-1.0, 0.0]]))
        add_probes(assembly, next(iter(bending_at("node", 9)["x"])))

    return define(build).system(speed_rpm=9000.0)


def upper(values):
    kept = values[(np.imag(values) >= 0) & (np.abs(values) <= 2 * np.pi * CUT_HZ)]
    return kept[np.lexsort((np.abs(kept), np.imag(kept)))]


@pytest.mark.parametrize(
    "system",
    [rotor(), rotor(damping=5e3), rotor(cross=2e5), rotor(stiffness=100.0, damping=10.0)],
    ids=["damped", "strongly damped at the bearings", "cross-coupled", "hardly held"],
)
def test_eigenvalues_are_those_of_the_core(system):
    found = low_modes(system, np.arange(len(system.coordinates)), CUT_HZ)
    assert found is not None
    truth = upper(np.linalg.eigvals(system.core))
    assert found.values.size == truth.size >= 8
    assert np.abs(upper(found.values) - truth).max() < 1e-8 * np.abs(truth).max()
    assert (
        np.abs(system.core @ found.vectors - found.vectors * found.values).max()
        < 1e-4 * np.abs(found.vectors * found.values).max() * np.abs(truth).max()
    )
    assert found.left @ found.vectors == pytest.approx(np.eye(truth.size), abs=1e-7)


def test_block_form_answers_as_with_all_eigenvalues(monkeypatch):
    system = rotor()
    quick = block_form.block_form(system, highest_hz=CUT_HZ)
    monkeypatch.setattr(block_form, "low_modes", lambda *_: None)
    slow = block_form.block_form(system, highest_hz=CUT_HZ)
    assert quick.is_blocks
    assert quick.core.shape == slow.core.shape
    for frequency_hz in (0.0, 50.0, 150.0, 600.0):
        # Of forces at the disc, seen at the disc.
        push = np.linalg.pinv(system.mass_matrix)[:, 36]
        one, other = (
            system.probe_rows
            @ form.basis
            @ np.linalg.solve(
                2j * np.pi * frequency_hz * np.eye(form.core.shape[0]) - form.core,
                form.inverse[:, len(system.coordinates) :] @ push,
            )
            for form in (quick, slow)
        )
        # Up to 1e-5 of a mode may be missing.
        assert np.abs(one - other).max() < 1e-5 * np.abs(other).max()


def test_what_is_not_accurate_is_refused():
    # A damper so strong that it holds a node, which no few motions of the shaft without it can show.
    system = rotor(damping=1e6)
    found = low_modes(system, np.arange(len(system.coordinates)), CUT_HZ)
    truth = upper(np.linalg.eigvals(system.core))
    assert found is None or np.abs(upper(found.values) - truth).max() < 1e-8 * np.abs(truth).max()
    # Half of all modes are wanted: nothing would be saved.
    assert low_modes(system, np.arange(len(system.coordinates)), 1e6) is None

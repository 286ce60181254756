"""Gear mesh: a spring that pulses with the teeth, a damper, backlash and transmission errors.

With the approach d of the teeth along the line of action, the error e(phi) and the number of tooth pairs in contact
jumping at known shaft angles, the force along the line of action is

    F = k(phi) (d - e) + c (d' - e')             driving flanks in contact, d - e > 0
    F = 0                                        within the backlash b, -b <= d - e <= 0
    F = k(phi) (d - e + b) + c (d' - e')         rear flanks in contact, d - e < -b

A gear that runs out moves to and fro along the line of centres as well. With the distance g more than its mean, the tip
of the wheel meets the line of action g / sin(alpha') further on: each pair enters so much later, and leaves at the same
place, at the pinion's tip. The jumps that make the harmonics of the stiffness move to and fro, once a turn. Left out:
the line of action itself turns, by a fifth of that on the pinion's base circle, and the wheel's teeth touch elsewhere.

A damaged tooth changes stiffness and error while its pair is in contact, see `tooth_damage`; the mesh then repeats with
the turns of that gear and not with every tooth. Its pair enters and leaves where every pair does: no further jumps.

The damping force goes with the contact: teeth apart exchange no force. The linear core holds the mean stiffness and the
damper; the interface force is the difference, so that it vanishes for a constant stiffness without error or separation.

Source: the bearing-rotor-gear study (paper 001 of this project), Eqs (6)-(8), there without backlash. Separation:
A. Kahraman and R. Singh, "Non-linear dynamics of a spur gear pair", J. Sound Vib. 142 (1990) 49-75.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..assembly import Assembly
from ..errors import InvalidValueError
from ..law import Direction, InterfaceForce
from . import gear_mesh_law as law
from .gear_mesh_stiffness import OVERLAP, SpurPair, StiffnessBranch
from .tooth_damage import (
    Damage,
    DamagedTooth,
    damage_polynomials,
    mean_stiffness_loss_n_m,
    pair_compliance,
    wear_harmonics_m,
)

#: Harmonics of the mesh that wear of the flanks makes; those above are small.
WEAR_HARMONICS = 5
Branches = tuple[StiffnessBranch, StiffnessBranch]


@dataclass
class GearMesh:
    """A pair of gears in mesh; a component with the role "mesh". See the module for the law.

    Parameters
    ----------
    name : str
    along : Direction
        Approach d of the driving flanks.
    branches : pair of StiffnessBranch
        Stiffness from the first contact of a pair to the jump, and from the jump to the next first contact.
    mesh_order : float
        Tooth engagements per turn of the reference shaft.
    damping_n_s_m : float
    backlash_m : float
        Along the line of action.
    reaction : Direction, optional
        Where the force acts; ``along`` unless a print leaves out a reaction.
    separates : bool
        False for teeth that also pull (as if glued).
    first_contact_pitches : float
        Mesh phase at shaft angle 0, in pitches; a pair enters at 0.
    mean_error_m : float
        Constant part of the error.
    pair : SpurPair, optional
        The gears; without them no tooth can be damaged. ``branches`` may differ from theirs for a misprint, damage is
        always theirs.
    branch_model : callable, optional
        Makes ``branches`` of a pair; its own branches unless given.
    gears : pair of str
        Names of the places of driving and driven gear.
    """

    name: str
    along: Direction
    branches: tuple[StiffnessBranch, StiffnessBranch]
    mesh_order: float
    damping_n_s_m: float
    backlash_m: float
    reaction: Direction | None = None
    separates: bool = True
    first_contact_pitches: float = 0.0
    mean_error_m: float = 0.0
    #: Error by order of the reference shaft: cosine part less 1j times sine part.
    errors: dict[float, complex] = field(default_factory=dict)
    #: Run-outs r exp(i angle) by order; of the wheel, under minus its order.
    run_outs: dict[float, complex] = field(default_factory=dict)
    pair: SpurPair | None = None
    branch_model: Callable[[SpurPair], Branches] | None = None
    gears: tuple[str, str] = ("pinion", "wheel")
    teeth: list[DamagedTooth] = field(default_factory=list)
    wear_m: float = 0.0
    stiffness_factor: float = 1.0
    roles: frozenset[str] = frozenset({"mesh"})

    def __post_init__(self) -> None:
        for what, value in (("damping", self.damping_n_s_m), ("backlash", self.backlash_m)):
            if not 0 <= value < math.inf:
                raise InvalidValueError(f"Gear mesh {self.name}: {what} {value}; allowed: at least 0. Correct it.")

    @property
    def mean_stiffness_n_m(self) -> float:
        """Mean stiffness over a turn."""
        lost = sum(mean_stiffness_loss_n_m(self._pair, tooth) for tooth in self.teeth)
        return self.stiffness_factor * sum(branch.integral_n_m for branch in self.branches) - lost

    @property
    def _pair(self) -> SpurPair:
        if self.pair is None:
            raise InvalidValueError(
                f"Gear mesh {self.name} does not know its teeth; allowed: damage of a mesh made with ``pair``. "
                "Give it the SpurPair."
            )
        return self.pair

    def gear(self, place: str) -> tuple[int, bool]:
        """Return the number of teeth of the gear at a place, and whether it is the driven one."""
        if place not in self.gears:
            raise InvalidValueError(f"{place!r} is no gear of mesh {self.name}; allowed: {', '.join(self.gears)}.")
        is_wheel = place == self.gears[1]
        return (self._pair.wheel if is_wheel else self._pair.pinion).teeth, is_wheel

    def add_tooth_damage(self, damage: Damage, *, every: int, first: int) -> None:
        """Damage the pairs ``first``, ``first`` + ``every``, ...: a tooth of a gear with ``every`` teeth."""
        self._pair  # noqa: B018  says at once what is missing
        self.teeth.append(DamagedTooth(every, first % every, damage))

    def add_wear(self, wear_m: float) -> None:
        """Wear all flanks by up to ``wear_m``, both gears together; wear of several effects adds."""
        self._pair  # noqa: B018
        self.wear_m += wear_m

    def scale_stiffness(self, factor: float) -> None:
        """Make all sound teeth stiffer by a factor, or softer; what damage takes away stays."""
        self.stiffness_factor *= factor

    def grow_centre_distance(self, growth_m: float) -> None:
        """Move the gears apart: less contact, another stiffness, more backlash. Damping stays."""
        before = self._pair
        after = replace(before, centre_growth_m=before.centre_growth_m + growth_m)
        self.pair = after
        self.branches = after.branches if self.branch_model is None else self.branch_model(after)
        self.backlash_m += after.backlash_growth_m - before.backlash_growth_m

    def add_error(self, *, order: float, amplitude_m: float, angle_rad: float) -> None:
        """Add e = amplitude sin(order phi + angle) to the transmission error; errors of one order add as vectors.

        Parameters
        ----------
        order : float
            Of the reference shaft: 1 for a run-out of a gear on it, ``mesh_order`` for an error of every tooth.
        amplitude_m, angle_rad : float
        """
        value = amplitude_m * complex(math.sin(angle_rad), -math.cos(angle_rad))
        self.errors[order] = self.errors.get(order, 0j) + value

    def add_run_out(self, place: str, *, order: float, amplitude_m: float, angle_rad: float) -> None:
        """Add e = amplitude sin(order phi + angle) of a gear that runs out, and what its centre distance does.

        The pinion stands by the angle order phi + angle from the normal of the line of action then, the wheel, which
        turns the other way, at minus that angle; the line of centres lies at the working pressure angle from it. With
        the driving flanks in contact the distance grows by amplitude cos(order phi + angle - alpha') of the pinion, and
        by - amplitude cos(order phi + angle + alpha') of the wheel.

        Parameters
        ----------
        place : str
            Of the gear.
        order : float
            Its turns per turn of the reference shaft.
        amplitude_m, angle_rad : float
        """
        self.add_error(order=order, amplitude_m=amplitude_m, angle_rad=angle_rad)
        if self.pair is not None and amplitude_m:
            signed = -order if self.gear(place)[1] else order
            self.run_outs[signed] = self.run_outs.get(signed, 0j) + cmath.rect(amplitude_m, angle_rad)

    def _later_entries(self) -> dict[float, complex]:
        """Return by how many pitches pairs enter later, by order; about the centre distance with all effects."""
        found: dict[float, complex] = {}
        for signed, run_out in self.run_outs.items():
            order, way = abs(signed), 1 if signed > 0 else -1
            later = way * self._pair.later_entry_per_m * run_out
            found[order] = found.get(order, 0j) + later * cmath.exp(-1j * way * self._pair.working_angle_rad)
        return found

    def interface_force(self) -> InterfaceForce:
        """Return what the linear core leaves out, as an interface force."""
        first, second = (self.stiffness_factor * branch.coefficients for branch in self.branches)
        powers = max(first.size, second.size)
        polynomials = [np.pad(own, (0, powers - own.size)) for own in (first, second)]
        errors, entries = self._errors_with_wear(), self._later_entries()
        series = [
            number
            for order, e in errors.items()
            for later in (entries.get(order, 0j),)
            for number in (order, e.real, -e.imag, later.real, -later.imag)
        ]
        pair_powers, teeth = self._tooth_parameters()
        head = {
            law.ORDER: self.mesh_order,
            law.START: self.first_contact_pitches,
            law.CHANGE: self.branches[0].end_phase,
            law.MEAN: self.mean_stiffness_n_m,
            law.DAMPING: self.damping_n_s_m,
            law.BACKLASH: self.backlash_m,
            law.SEPARATES: float(self.separates),
            law.MEAN_ERROR: self.mean_error_m,
            law.POWERS: float(powers),
            law.TEETH: float(len(self.teeth)),
            law.PAIR_POWERS: float(pair_powers),
        }
        parameters = np.concatenate([[head[row] for row in range(law.SERIES)], *polynomials, *teeth, series])
        acts = self.along if self.reaction is None else self.reaction
        return InterfaceForce(
            self.name, law.GEAR_MESH, tuple(parameters.tolist()), (acts,), (self.along,), (self.along,)
        )

    def _errors_with_wear(self) -> dict[float, complex]:
        errors = dict(self.errors)
        if self.wear_m:
            turned = np.exp(2j * np.pi * np.arange(1, WEAR_HARMONICS + 1) * self.first_contact_pitches)
            sizes = wear_harmonics_m(self._pair, wear_m=self.wear_m, count=WEAR_HARMONICS) * turned
            for number, size in enumerate(sizes, start=1):
                order = number * self.mesh_order
                errors[order] = errors.get(order, 0j) + complex(size)
        return errors

    def _tooth_parameters(self) -> tuple[int, list[np.ndarray]]:
        """Return the common length of the teeth's polynomials, and the rows of the law for the teeth."""
        if not self.teeth:
            return 0, []
        sound = pair_compliance(self._pair)
        teeth = sorted(self.teeth, key=lambda tooth: tooth.key)
        made = [damage_polynomials(self._pair, tooth.damage) for tooth in teeth]
        powers = max(polynomial.size for polynomial in (sound, *(p for both in made for p in both)))
        rows = [np.pad(sound, (0, powers - sound.size))]
        for tooth, both in zip(teeth, made, strict=True):
            rows.append(np.array([tooth.every, tooth.first], dtype=float))
            rows += [np.pad(polynomial, (0, powers - polynomial.size)) for polynomial in both]
        return powers, rows

    def finish(self, assembly: Assembly) -> None:
        """Add mean stiffness and damping to the linear core and the rest as a force."""
        names = list(self.along)
        reads = np.array([self.along[name] for name in names])
        acts = reads if self.reaction is None else np.array([self.reaction.get(name, 0.0) for name in names])
        assembly.add_matrix("stiffness", names, self.mean_stiffness_n_m * np.outer(acts, reads))
        assembly.add_matrix("damping", names, self.damping_n_s_m * np.outer(acts, reads))
        assembly.forces.append(self.interface_force())


def mesh_damping_n_s_m(*, stiffness_n_m: float, damping_ratio: float, effective_mass_kg: float) -> float:
    """Return c = 2 zeta sqrt(k m), N.s/m, for a mesh of mean stiffness k between gears of effective mass m.

    For two gears that only turn, 1/m = R_1^2 / I_1 + R_2^2 / I_2 with the base radii R.
    """
    return 2 * damping_ratio * math.sqrt(stiffness_n_m * effective_mass_kg)


def misprinted_branches(pair: SpurPair) -> tuple[StiffnessBranch, StiffnessBranch]:
    """Return the mesh stiffness that Eq (7) of paper 001 gives when taken literally.

    Double contact: the compliances of both pairs added, as if one pair carried the other (true: the stiffnesses add).
    Single contact: the compliance of the contact counted three times (true: once).
    """

    def double(phase: np.ndarray) -> np.ndarray:
        return 1 / (1 / pair.pair_stiffness_n_m(phase) + 1 / pair.pair_stiffness_n_m(phase + 1))

    def single(phase: np.ndarray) -> np.ndarray:
        return 1 / (1 / pair.pair_stiffness_n_m(phase) + 2 * pair.contact_compliance_m_n)

    fitted = []
    for true, model in zip(pair.branches, (double, single), strict=True):
        ends = [true.start_phase - OVERLAP, true.end_phase + OVERLAP]
        curve = np.polynomial.Chebyshev.interpolate(model, true.coefficients.size - 1, ends)
        powers = curve(np.polynomial.Polynomial([true.start_phase, 1.0])).coef
        check = np.linspace(ends[0], ends[1], 101)
        values = np.polynomial.polynomial.polyval(check - true.start_phase, powers)
        error = float(np.abs(values / model(check) - 1).max())
        fitted.append(StiffnessBranch(true.pairs, true.start_phase, true.end_phase, powers, error))
    return fitted[0], fitted[1]

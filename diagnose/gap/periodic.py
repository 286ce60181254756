"""Periodic motions of machines in measured conditions, all side by side."""

from __future__ import annotations

from collections.abc import Sequence

from ...simulators.errors import InvalidValueError, RotorwiseError
from ...simulators.machine import Machine
from ...simulators.solvers.harmonic_balance import PeriodicMotion, harmonic_balances
from .lines import Condition

#: The motion of a machine in each condition, or why it does not repeat.
Moving = list[PeriodicMotion] | RotorwiseError


def motions_in(
    conditions: Sequence[Condition],
    machines: Sequence[Machine],
    near: Moving | None,
    *,
    harmonics: int,
    lasting: bool = False,
) -> list[Moving]:
    """Return the motion of machines in each condition, or why one has none; sought from motions ``near``, if any.

    Whether a motion lasts is asked of machines with contacts and the like (`Effect.IDEALISED`): a machine by itself was
    recorded, and runs. ``lasting`` says that these do as well, as one beside them does.
    """
    loads: dict[float | None, list[int]] = {}
    for number, condition in enumerate(conditions):
        loads.setdefault(condition.load, []).append(number)
    cases: list[tuple[Machine, list[float]]] = []
    owners: list[tuple[int, list[int]]] = []
    failed: dict[int, RotorwiseError] = {}
    for owner, machine in enumerate(machines):
        for numbers in loads.values():
            try:
                loaded = at_condition(machine, conditions[numbers[0]])
            except InvalidValueError as problem:
                failed[owner] = problem.with_traceback(None)
                break
            cases.append((loaded, [conditions[number].speed_rpm for number in numbers]))
            owners.append((owner, numbers))
    beside = [[near[n] for n in numbers] if isinstance(near, list) else None for _, numbers in owners]
    doubtful = [not lasting and any(effect.IDEALISED for effect in machine.effects) for machine, _ in cases]
    motions: dict[tuple[int, int], PeriodicMotion] = {}
    balances = harmonic_balances(cases, harmonics=harmonics, near=beside, only_stable=doubtful)
    for (owner, numbers), found in zip(owners, balances, strict=True):
        if isinstance(found, RotorwiseError):
            failed[owner] = found
        else:
            motions |= {(owner, number): motion for number, motion in zip(numbers, found, strict=True)}
    every = range(len(conditions))
    return [failed.get(owner) or [motions[owner, number] for number in every] for owner in range(len(machines))]


def at_condition(machine: Machine, condition: Condition) -> Machine:
    """Return the machine under the condition's load, where it has a load parameter and the load is known."""
    name = machine.definition.load_parameter
    if not name or condition.load is None:
        return machine
    return machine.with_parameters(**{name: condition.load})

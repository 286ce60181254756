"""Machines of a recipe as a table to learn from, by harmonic balance instead of a simulation in time: in seconds."""

import numpy as np
from rotorwise.datasets.recipe import Recipe
from rotorwise.datasets.recipe_draw import draw_signal, position_of, severity_of
from rotorwise.diagnose.learning.severity.feature_row import ShaftLines, _lines
from rotorwise.diagnose.learning.severity.reading import SeverityTable, probes_of
from rotorwise.diagnose.learning.severity.targets import TARGETS
from rotorwise.diagnose.learning.severity.unit_responses import UnitResponses, source_features
from rotorwise.diagnose.misalignment_levels import misalignment_levels
from rotorwise.diagnose.result import Severity
from rotorwise.diagnose.severity import zone_of
from rotorwise.diagnose.zones.table import find_table
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

#: Of the lines, in metres; a record of a second at 1e-8 m/sqrt(Hz) and 1000 Hz has about this.
NOISE_M = 5e-9
_TABLE = find_table("iso14839-2").rows


def drawn_table(recipe: Recipe, responses: UnitResponses, *, draws: range, per_draw: int, seed: int) -> SeverityTable:
    """Return ``per_draw`` records of each machine draw of a recipe of magnetic-bearing rotors, chosen by chance."""
    stream = np.random.default_rng(seed)
    rows = []
    for draw in draws:
        first = draw * recipe.per_round
        for number in np.sort(stream.permutation(recipe.per_round)[:per_draw]):
            drawn = draw_signal(recipe, position_of(recipe, first + int(number)))
            amplitudes = harmonic_balance(drawn.machine, speed_rpm=drawn.speed_rpm).amplitudes[:, 1:4]
            # Where the tacho's mark sits nobody knows.
            turned = amplitudes * np.exp(1j * np.arange(1, 4) * stream.uniform(0, 2 * np.pi))
            noise = stream.normal(size=(2, *turned.shape)) * NOISE_M
            lines = ShaftLines(
                probes_of(recipe), drawn.speed_rpm, turned + noise[0] + 1j * noise[1], np.full(turned.shape, NOISE_M)
            )
            values = {"speed_rpm": drawn.speed_rpm, **_lines(lines.probes, lines.amplitudes, lines.noise)}
            values |= source_features(responses, lines)
            rows.append(
                (drawn, values, lines, shown_zone(drawn.machine, drawn.speed_rpm), severity_of(recipe, drawn.values))
            )
    names = tuple(rows[0][1])
    labels = {target.name: target.label.removeprefix("severity.") for target in TARGETS}
    return SeverityTable(
        names=names,
        values=np.array([[values[name] for name in names] for _, values, *_ in rows]),
        labels={
            name: np.array([found[label] for *_, found in rows])
            for name, label in labels.items()
            if label in recipe.severity
        },
        groups=np.array([f"{one.position.recipe.name}-{one.position.draw}" for one, *_ in rows]),
        splits=np.array(["train"] * len(rows)),
        cases=np.array([one.position.case.name for one, *_ in rows]),
        kinds=np.array([one.position.recipe.name for one, *_ in rows]),
        lines=tuple(lines for _, _, lines, *_ in rows),
        zones=tuple(zone for *_, zone, _ in rows),
        rates_hz=np.full(len(rows), 2000.0),
        durations_s=np.ones(len(rows)),
    )


def shown_zone(machine, speed_rpm: float) -> Severity:
    """Return the zone of a machine's own steady motion."""
    probes = machine.assembly(speed_rpm=speed_rpm).probes
    levels = misalignment_levels(
        machine,
        speed_rpm=speed_rpm,
        offsets_m=np.zeros(1),
        angles_rad=np.zeros(1),
        probes=probes,
        rows=_TABLE,
        clearance_m=machine.values["clearance_m"],
    )
    value, limits = float(levels.map.peaks.max()), levels.limits
    return Severity("ISO 14839-2", "", zone_of(value, limits), value, "m", "", limits, "", "", "M")

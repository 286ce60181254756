"""One effect shown on one machine: spectra with and without it, how far its lines rise, a small picture."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .assembly import MissingPartError, Probe
from .effect import Effect, Line
from .errors import RotorwiseError
from .machine import Machine

#: All exhibits run at this speed; fast enough for every machine, far from none of them.
SPEED_RPM = 1800.0
TURNS, TURNS_FOR_NEAR_LINES = 60, 300
HIGHEST_RATE_HZ = 16384.0
#: The first machine on which a line rises at least so far is shown; otherwise the one where it rises most.
CLEAR = 3.0
#: A line this far below the strongest one of its record is not counted, however far it rose.
VISIBLE = 1e-3
#: Orders below this belong to the mean.
LOWEST = 0.1
#: The seed of random effects on the recording.
SEED = 1


@dataclass(frozen=True)
class Exhibit:
    """Spectra of one probe with and without an effect at its default values.

    Attributes
    ----------
    machine : str
    probe : Probe
    orders, before, after : ndarray (lines,)
        Multiples of the shaft speed and peak amplitudes, Hann window.
    lines : tuple of Line
        The effect's signature on this machine.
    line : Line or None
        The one that rises most; None for an effect without lines: ``rise`` is then that of the floor.
    rise : float
        Amplitude with the effect over that without.
    is_visible : bool
        Whether that line is not far below the strongest one of its record.
    """

    machine: str
    probe: Probe
    orders: np.ndarray
    before: np.ndarray
    after: np.ndarray
    lines: tuple[Line, ...]
    line: Line | None
    rise: float
    is_visible: bool = True


def exhibit(effect: type[Effect], machines: Mapping[str, Machine]) -> Exhibit | None:
    """Return the effect on the first machine that shows it clearly, else on the one that shows it best.

    None when no machine has the part, or none runs with the effect at its default values.
    """
    found: list[Exhibit] = []
    for machine in machines.values():
        try:
            found += _on_machine(effect(), machine)
        except MissingPartError:
            continue
        except RotorwiseError as problem:
            # Another machine may run; a table that keeps silent would hide the trouble.
            print(f"{effect.NAME} on {machine.name}: {problem}")
        if any(_worth(shown)[0] for shown in found):
            break
    return max(found, key=_worth, default=None)


def _worth(shown: Exhibit) -> tuple[bool, bool, int, float]:
    """Prefer lines that are clear, then those that the effect declares first, then the largest rise."""
    clear = shown.rise >= CLEAR and shown.is_visible
    place = -shown.lines.index(shown.line) if clear and shown.line in shown.lines else 0
    return clear, shown.is_visible, place, shown.rise


def _on_machine(effect: Effect, machine: Machine) -> list[Exhibit]:
    """Return the exhibits of all probes and lines that show anything."""
    effect.contribute(machine.bare_assembly())
    lines = effect.signature(machine)
    places = sorted({1.0, *(line.order_at(SPEED_RPM) for line in lines)})
    near = min(np.diff(places), default=1.0) < 0.1
    turns = TURNS_FOR_NEAR_LINES if near else TURNS
    orders, before, probes = _spectra(machine, turns)
    _, after, _ = _spectra(machine.with_effects(effect), turns)
    return [
        Exhibit(machine.name, probe, orders, before[i], after[i], lines, line, rise, is_visible)
        for i, probe in enumerate(probes)
        for line, rise, is_visible in _rises(lines, probe, orders, before[i], after[i])
        if rise > 0
    ]


@functools.lru_cache(maxsize=16)
def _kept(name: str, turns: int) -> tuple[np.ndarray, np.ndarray, tuple[Probe, ...]]:
    from .machine import find_machine

    return _computed(find_machine(name), turns)


def _spectra(machine: Machine, turns: int) -> tuple[np.ndarray, np.ndarray, tuple[Probe, ...]]:
    """Return orders (lines,), amplitudes (probes, lines) and probes; the healthy machine is computed once."""
    return _computed(machine, turns) if machine.effects else _kept(machine.name, turns)


def _computed(machine: Machine, turns: int) -> tuple[np.ndarray, np.ndarray, tuple[Probe, ...]]:
    rate = min(HIGHEST_RATE_HZ, 0.5 / machine.definition.step_s)
    run = machine.simulate(speed_rpm=SPEED_RPM, duration_s=60 * turns / SPEED_RPM, rate_hz=rate, seed=SEED)
    window = np.hanning(run.signals.shape[1])
    spectrum = 2 * np.abs(np.fft.rfft(run.signals * window, axis=1)) / window.sum()
    frequency = np.fft.rfftfreq(window.size, 1 / rate)
    within = frequency <= 0.4 * rate
    return frequency[within] * 60 / SPEED_RPM, spectrum[:, within], run.probes


def sees(probe: Probe, line: Line) -> bool:
    """Return whether a probe looks in the direction of a line."""
    return line.direction in ("any", probe.direction) or (line.direction == "lateral" and probe.direction in ("x", "y"))


def _rises(
    lines: tuple[Line, ...], probe: Probe, orders: np.ndarray, before: np.ndarray, after: np.ndarray
) -> list[tuple[Line | None, float, bool]]:
    """Return how far each line rises in one probe and whether it is visible; without lines, the floor or any line."""
    if not lines:
        floor = float(np.median(before))
        raised = float(np.median(after)) / floor if floor > 0 else 0.0
        if raised >= CLEAR:
            return [(None, raised, True)]
        # No floor: a line somewhere, as of what folds back.
        visible = np.flatnonzero((after > VISIBLE * after.max()) & (before > 0))
        ratios = after[visible] / before[visible]
        if ratios.size == 0 or ratios.max() < raised:
            return [(None, raised, True)]
        return [(Line(float(orders[visible[np.argmax(ratios)]]), "any"), float(ratios.max()), True)]
    strongest = after[orders > LOWEST].max()
    found: list[tuple[Line | None, float, bool]] = []
    for line in lines:
        near = np.abs(orders - line.order_at(SPEED_RPM)) <= 1.5 * orders[1]
        if sees(probe, line) and near.any():
            peak, base = float(after[near].max()), float(before[near].max())
            if base > 0:
                found.append((line, peak / base, peak > VISIBLE * strongest))
    return found


def picture(shown: Exhibit, *, width: int = 300, height: int = 110) -> str:
    """Return the two spectra as SVG text: grey without, blue with the effect; marks below at the declared lines.

    Across: orders of the shaft. Up: peak amplitude, a line for each decade; lowest and highest value stand above.
    """
    low, high = _range(shown)
    inside = (shown.orders >= low) & (shown.orders <= high)
    top = max(shown.before[inside].max(), shown.after[inside].max())
    left, right, floor, ceiling = 4, width - 4, height - 18, 14
    decades = 5

    def across(order: float) -> float:
        return left + (right - left) * (order - low) / (high - low)

    def curve(values: np.ndarray, colour: str) -> str:
        columns = np.array([round(across(order)) for order in shown.orders[inside].tolist()])
        highest = [(x, values[inside][columns == x].max()) for x in np.unique(columns)]
        up = [(x, floor + (ceiling - floor) * max(0.0, 1 + np.log10(max(v / top, 1e-9)) / decades)) for x, v in highest]
        points = " ".join(f"{x},{y:.1f}" for x, y in up)
        return f'<polyline fill="none" stroke="{colour}" stroke-width="1" points="{points}"/>'

    levels = [round(floor + (ceiling - floor) * k / decades, 1) for k in range(decades + 1)]
    grid = [f'<path d="M{left},{y} H{right}" stroke="#e4e4e4" stroke-width="0.5"/>' for y in levels]
    marks = [
        f'<path d="M{across(order):.1f},{floor + 1} l-2.5,5 h5 z" fill="#c33"/>'
        for order in {line.order_at(SPEED_RPM) for line in shown.lines}
        if low <= order <= high
    ]
    text = (
        '<text font-family="sans-serif" font-size="9" fill="#555" y="{y}" x="{x}" text-anchor="{anchor}">{what}</text>'
    )
    labels = [
        text.format(x=left, y=height - 4, anchor="start", what=f"{low:.3g}X"),
        text.format(x=width / 2, y=height - 4, anchor="middle", what=f"orders; {shown.machine}, {shown.probe.name}"),
        text.format(x=left, y=ceiling - 4, anchor="start", what=_scale_text(top, decades, shown.probe.unit)),
        text.format(x=right, y=height - 4, anchor="end", what=f"{high:.3g}X"),
    ]
    size = f'width="{width}" height="{height}" viewBox="0 0 {width} {height}"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}>',
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
        *grid,
        curve(shown.after, "#1668b8"),
        curve(shown.before, "#888"),
        *sorted(marks),
        *labels,
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _scale_text(top: float, decades: int, unit: str) -> str:
    return f"{top / 10**decades:.1g} to {top:.2g} {unit}"


def _range(shown: Exhibit) -> tuple[float, float]:
    """Return the orders to show: all declared lines, or close to a group of lines that lie close together."""
    places = [line.order_at(SPEED_RPM) for line in shown.lines if line.order_at(SPEED_RPM) <= shown.orders[-1]]
    # The mean of a displacement would dwarf all lines; it is shown only where it is declared.
    start = 0.0 if min(places, default=1.0) < LOWEST else LOWEST
    if not places:
        return start, float(min(20.0, shown.orders[-1]))
    spread = max(places) - min(places)
    if len(places) > 1 and min(places) > 0.3 and spread < 0.3 * min(places):
        margin = max(spread, 20 * shown.orders[1])
        return min(places) - margin, max(places) + margin
    return start, float(min(max(6.0, 1.3 * max(places)), shown.orders[-1]))

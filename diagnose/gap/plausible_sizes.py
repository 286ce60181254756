"""Recordings in another unit than is said: far smaller than the machine makes them, or than the healthy ones are.

A diagnosis of lines that are a thousand times too small is a confident and a wrong one: calibration finds a machine
that hardly moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...datasets.recording import Campaign, Recording
from ...simulators.errors import InvalidValueError
from ...simulators.machine import Machine
from .lines import OrderLines
from .predict import Predictor, UnpredictableError

#: No fault and no machine that is off by its tolerances makes all channels of a quantity this many times as large.
IMPLAUSIBLE = 300.0
#: Of a sound machine there may be next to nothing of these: a shaft that turned evenly swings by any factor more.
NEXT_TO_NOTHING = frozenset(("rotational_speed", "torque", "angle"))


def check_alike(campaign: Campaign, names: Sequence[str]) -> None:
    """Refuse healthy recordings of which `unlike_words` says something.

    Raises
    ------
    InvalidValueError
    """
    words = unlike_words(campaign, names)
    if words:
        raise InvalidValueError(words)


def unlike_words(campaign: Campaign, names: Sequence[str]) -> str:
    """Return that all channels of one quantity are of another size in the healthy recordings, noise and all; or ""."""
    if not campaign.baseline:
        return ""
    quantities = {channel.name: channel.quantity for channel in campaign.recordings[0].channels}
    ratios = {name: _ratio(campaign, name) for name in names}
    for quantity in dict.fromkeys(quantities[name] for name in names):
        own = {name: ratios[name] for name in names if quantities[name] == quantity}
        least, most = min(own.values()), max(own.values())
        if (least > IMPLAUSIBLE and quantity not in NEXT_TO_NOTHING) or most < 1 / IMPLAUSIBLE:
            times, word = (least, "larger") if least > 1 else (1 / most, "smaller")
            return (
                f"The recordings to explain are {times:.0f} times {word} than the healthy ones ({quantity}: "
                f"{', '.join(own)}), noise and all; allowed: one unit for both. Check --unit and --sensitivity, or the "
                "recording.toml of each folder."
            )
    return ""


def _ratio(campaign: Campaign, name: str) -> float:
    """Return how many times as large a channel is as in the healthy recordings, by the measure that differs least."""
    now, before = (
        np.median([_sizes(one, name) for one in recordings], axis=0)
        for recordings in (campaign.recordings, campaign.baseline)
    )
    ratios = now / np.maximum(before, 1e-300)
    return float(ratios.min()) if ratios.min() > 1 else float(min(ratios.max(), 1.0))


def _sizes(recording: Recording, name: str) -> np.ndarray:
    """Return deviation, what it is like most of the time, and how much it differs from sample to sample."""
    signal = recording.signals[[channel.name for channel in recording.channels].index(name)]
    signal = signal[np.isfinite(signal)]
    signal = signal - np.median(signal)
    return np.array([signal.std(), np.median(np.abs(signal)), np.median(np.abs(np.diff(signal)))])


def check_size_of_machine(
    machine: Machine, lines: Sequence[tuple[OrderLines, Predictor]], quantities: Mapping[str, str]
) -> None:
    """Refuse recordings that are all far smaller than the machine as given makes them.

    Larger ones may come from an unbalance that its file does not have.

    Parameters
    ----------
    machine : Machine
    lines : sequence of OrderLines and Predictor
        Of the healthy recordings if any, which mostly settle it, and of those to explain.
    quantities : mapping of str to str
        What each probe measures.

    Raises
    ------
    InvalidValueError
    """
    left = dict.fromkeys(quantities.values(), 0.0)
    for measured, predictor in lines:
        try:
            made = predictor.amplitudes(machine)
        except UnpredictableError:
            return
        for quantity, largest in left.items():
            which = [quantities[name] == quantity for name in measured.probes]
            left[quantity] = max(largest, _share(measured, made, which))
        left = {quantity: share for quantity, share in left.items() if share * IMPLAUSIBLE < 1}
        if not left:
            return
    quantity, share = next(iter(left.items()))
    names = [name for name in quantities if quantities[name] == quantity]
    times = f"{1 / share:.0f} times" if share else "endlessly"
    raise InvalidValueError(
        f"The recordings are {times} smaller than {machine.name} makes them ({quantity}: {', '.join(names)}); allowed: "
        f"less than {IMPLAUSIBLE:.0f} times. Check --unit and --sensitivity; if they are right, the unbalance in the "
        "machine file is not this machine's."
    )


def _share(measured: OrderLines, made: np.ndarray, which: Sequence[bool]) -> float:
    """Return how large the lines of some probes are, measured over simulated; 1 where the machine makes none."""
    seen = measured.seen & np.array(which)[:, None] & np.array([kind.phase for kind in measured.kinds])
    sizes = [float((np.abs(one[seen]) ** 2).sum()) for one in (measured.amplitudes, made)]
    return float(np.sqrt(sizes[0] / sizes[1])) if sizes[1] > 0 else 1.0

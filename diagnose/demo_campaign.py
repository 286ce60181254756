"""Makes the campaign that ``rotorwise demo`` explains: a rotor whose fault is sealed in a file of its own.

``python -m rotorwise.diagnose.demo_campaign -o FOLDER --seed 1`` writes ``FOLDER/campaign`` (six recordings, and six of
the healthy machine in ``baseline``) and ``FOLDER/sealed.toml``, the truth, which nothing reads before the answer is
given. The machine that is recorded differs from the model by some per cent, its probes have errors of 1 %,
noise and a converter of 16 bit; motion is stepped in time, while the engine balances harmonics.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..datasets.recording import Recording
from ..datasets.simulated import record_machine
from ..simulators.effects.coupling_misalignment import CouplingMisalignment
from ..simulators.errors import InvalidValueError, RotorwiseError
from ..simulators.machine import Machine, find_machine
from ..simulators.sensor_chain import SensorChain
from .demo import CAMPAIGN, MACHINE, SEALED

SPEEDS_RPM = (1200.0, 1700.0, 2200.0, 2800.0, 3400.0, 4000.0)
HEALTHY_SPEEDS_RPM = (1150.0, 1750.0, 2150.0, 2900.0, 3300.0, 4050.0)
DURATION_S, RATE_HZ = 4.0, 1800.0
#: Of the usual eddy-current probes; full scale is then 127 um.
SENSITIVITY_V_M, FULL_SCALE_V = 7870.0, 1.0
HIDDEN = CouplingMisalignment(offset_m=6e-5, angle_rad=4e-4, offset_phase_rad=0.7, angle_phase_rad=-0.4)
_SPREAD, _GAIN_ERROR = 0.05, 0.01
_CHAIN = SensorChain(pulses_per_revolution=1, noise={"m": 1e-8})
_SIDECAR_HEAD = "# What the files do not say: probes as in the machine, eddy-current sensors, one pulse a turn.\n"


def write_campaign(folder: Path, *, seed: int) -> tuple[Path, Path]:
    """Write the campaign and the sealed truth into a folder, and return both places.

    Parameters
    ----------
    folder : Path
        New or empty: nothing in it is replaced.
    seed : int
        Of the machine's deviations, the probes' errors and the noise.

    Raises
    ------
    InvalidValueError
        When the folder holds something, or the signal leaves the converter's range.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InvalidValueError(f"{folder} exists; allowed: a new or an empty folder. Choose another place.")
    rng = np.random.default_rng(seed)
    real = _deviating(find_machine(MACHINE), rng)
    gains = 1 + _GAIN_ERROR * rng.standard_normal(len(real.bare_assembly().probes))
    campaign = folder / CAMPAIGN
    (campaign / "baseline").mkdir(parents=True)
    faulty = real.with_effects(HIDDEN)
    for number, speed_rpm in enumerate(SPEEDS_RPM):
        _write(_recorded(faulty, speed_rpm, seed + 100 + number), gains, campaign / f"{speed_rpm:.0f}_rpm.flac")
    for number, speed_rpm in enumerate(HEALTHY_SPEEDS_RPM):
        path = campaign / "baseline" / f"healthy_{speed_rpm:.0f}_rpm.flac"
        _write(_recorded(real, speed_rpm, seed + 200 + number), gains, path)
    (campaign / "recording.toml").write_text(_sidecar(real), encoding="utf-8")
    sealed = folder / SEALED
    sealed.write_text(_truth(real, gains, seed=seed), encoding="utf-8")
    return campaign, sealed


def _deviating(machine: Machine, rng: np.random.Generator) -> Machine:
    """Return the machine with the values that vary between machines off by some per cent."""
    varied = [one.name for one in machine.definition.parameters if one.prior is not None]
    return machine.with_parameters(
        **{name: machine.values[name] * (1 + _SPREAD * float(rng.standard_normal())) for name in varied}
    )


def _recorded(machine: Machine, speed_rpm: float, seed: int) -> Recording:
    # No governor holds a round number.
    actual = speed_rpm * (1 + 2e-3 * float(np.random.default_rng(seed).standard_normal()))
    made = record_machine(
        machine, speed_rpm=actual, duration_s=DURATION_S, rate_hz=RATE_HZ, chain=_CHAIN, seed=seed, settle_s=20.0
    )
    return made.recording


def _write(recording: Recording, gains: np.ndarray, path: Path) -> None:
    """Write probes in volts and the tacho as 16-bit FLAC: the file is the converter."""
    import soundfile

    volts = recording.signals.copy()
    volts[: len(gains)] *= SENSITIVITY_V_M * gains[:, None]
    volts[len(gains) :] *= 0.5
    largest = float(np.abs(volts).max())
    if largest >= FULL_SCALE_V:
        raise InvalidValueError(f"{path.name}: {largest:.3g} V; allowed: below {FULL_SCALE_V} V. Hide less.")
    soundfile.write(path, volts.T, round(recording.rate_hz), subtype="PCM_16", format="FLAC")


def _sidecar(machine: Machine) -> str:
    lines = [_SIDECAR_HEAD, "[recording]", "pulses_per_revolution = 1"]
    for number, probe in enumerate(machine.bare_assembly().probes, start=1):
        lines += ["", "[[channel]]", f"number = {number}", f'name = "{probe.name}"', 'unit = "V"']
        lines += [f'sensitivity = "{SENSITIVITY_V_M / 1e3:g} V/mm"']
    lines += ["", "[[channel]]", f"number = {number + 1}", 'name = "tacho"', "tacho = true", ""]
    return "\n".join(lines)


def _truth(real: Machine, gains: np.ndarray, *, seed: int) -> str:
    model = find_machine(MACHINE)
    moved = {name: value for name, value in real.values.items() if value != model.values[name]}
    hidden: Mapping[str, float] = {one.name: getattr(HIDDEN, one.name) for one in HIDDEN.parameters()}
    parts = [
        f"# The truth of {CAMPAIGN}, which nothing reads before the answer is given. Made by",
        f"#   python -m rotorwise.diagnose.demo_campaign -o FOLDER --seed {seed}",
        f'\nmachine = "{MACHINE}"\neffect = "{HIDDEN.NAME}"\n',
        *_table("parameters", hidden),
        *_table("machine_off_by", {name: value / model.values[name] - 1 for name, value in moved.items()}),
        *_table("gains", {p.name: g for p, g in zip(real.bare_assembly().probes, gains, strict=True)}),
    ]
    return "\n".join(parts)


def _table(name: str, values: Mapping[str, float]) -> list[str]:
    return [f"[{name}]", *(f"{key} = {float(value):.6g}" for key, value in values.items()), ""]


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the campaign from a command line and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m rotorwise.diagnose.demo_campaign", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, help="new folder")
    parser.add_argument("--seed", type=int, required=True)
    given = parser.parse_args(arguments)
    try:
        made = write_campaign(given.output, seed=given.seed)
    except (RotorwiseError, OSError) as problem:
        print(f"rotorwise: {problem}", file=sys.stderr)
        return 2
    print(*made, sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())

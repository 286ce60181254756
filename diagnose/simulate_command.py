"""``rotorwise simulate``: a machine with effects, written as a recording that ``rotorwise analyse`` reads."""

from __future__ import annotations

import json
import math
import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..simulators.errors import InvalidValueError, RotorwiseError
from .cli_options import option
from .decimal_option import decimal_option

if TYPE_CHECKING:
    from ..datasets.simulated import SimulatedRecord
    from ..datasets.write import Destination

_DONE, _USAGE, _FAILED, _OUTPUT_FAILED = 0, 2, 3, 4
_LARGE_ERROR = 0.01
#: `analyse` refuses fewer turns.
_FEWEST_TURNS = 10
#: The decimation of the simulation is flat up to this share of the rate.
_FLAT = 0.4

MachineName = Annotated[
    str, typer.Argument(help="Name of a shipped machine, or a machine file.", metavar="MACHINE|FILE.toml")
]
Speed = Annotated[str, option("--speed", value="RPM|FROM..TO", text="Shaft speed, or a run-up over the duration.")]
Duration = Annotated[float, decimal_option("--duration", value="S", text="Length of the record.")]
Rate = Annotated[float, decimal_option("--rate", value="HZ", text="Sampling rate of the record.")]
Output = Annotated[Path, option("--output", "-o", value="FILE", text="File to write; a sidecar FILE.toml joins it.")]
Preset = Annotated[str, option("--preset", value="NAME", text="Preset; what a machine file states goes before it.")]
Settings = Annotated[
    list[str] | None, option("--set", value="NAME=VALUE", text="Parameter of the machine, SI units; repeat.")
]
Effects = Annotated[
    list[str] | None,
    option(
        "--with",
        value="EFFECT[@PLACE][:NAME=VALUE,...]",
        text="Effect, where it acts, its values in SI units; repeat. What is not given is as usual for it.",
    ),
]
Load = Annotated[
    float | None, decimal_option("--load", value="VALUE", text="Load of the machine, in the unit of its load.")
]
Seed = Annotated[int | None, option("--seed", value="N", text="Required when noise or an effect is random.")]
Chain = Annotated[
    str,
    option(
        "--chain",
        value="NAME[:SETTING=VALUE,...]",
        text="Measuring chain: ideal, accelerometer or mems; settings such as noise.m/s2=3e-4 or bits=12.",
    ),
]
Pulses = Annotated[
    int, option("--pulses-per-revolution", value="N", text="Of the tacho channel; 1 when left out, 0 for no tacho.")
]
Probes = Annotated[list[str] | None, option("--probe", value="NAME", text="Record only this probe; repeat.")]
Format = Annotated[
    str, option("--format", value="NAME", text="csv, wav, parquet, hdf5, mat or npz; the suffix says it too.")
]
Force = Annotated[bool, option("--force", text="Replace an earlier recording.")]
AsJson = Annotated[bool, option("--json", text="Print JSON: what was written and how it came about.")]
Threads = Annotated[int, option("--threads", value="N", text="Threads for the simulation.")]
Estimate = Annotated[bool, option("--estimate-error", text="Simulate again with half the step; state the difference.")]


def simulate(
    machine: MachineName,
    speed: Speed,
    duration: Duration,
    rate: Rate,
    output: Output,
    preset: Preset = "",
    settings: Settings = None,
    effects: Effects = None,
    load: Load = None,
    seed: Seed = None,
    chain: Chain = "ideal",
    pulses: Pulses = 1,
    probes: Probes = None,
    file_format: Format = "",
    force: Force = False,
    as_json: AsJson = False,
    threads: Threads = 1,
    estimate_error: Estimate = False,
) -> None:
    """Simulate a machine with effects and write the record, with tacho, label and origin.

    Every --with adds one effect; they combine freely. `rotorwise effects` explains them.
    """
    from ..datasets.write import destination

    made = _prepared(machine, preset, settings or [], effects or [], load)
    try:
        # Before the work, not after: nobody wants to wait for a refusal.
        destination(output, file_format=file_format, force=force)
        check_ours(output)
        request = _checked(made, speed, duration, rate, chain, pulses, seed, probes or [], threads)
        record = _simulated(made, duration, rate, request, threads=threads, estimate_error=estimate_error)
    except RotorwiseError as problem:
        raise _leave(problem, _USAGE if isinstance(problem, InvalidValueError) else _FAILED) from None
    try:
        written = _write(record, output, file_format, force)
    except RotorwiseError as problem:
        raise _leave(problem, _OUTPUT_FAILED) from None
    _tell(record, written, as_json=as_json)


def _prepared(machine: str, preset: str, settings: list[str], effects: list[str], load: float | None) -> Any:
    from .simulate_options import parse_effect, parse_machine

    try:
        chosen = parse_machine(machine, preset=preset, settings=settings, load=load)
        return chosen.with_effects(*(parse_effect(text) for text in effects))
    except RotorwiseError as problem:
        raise _leave(problem, _USAGE) from None


def check_ours(output: Path) -> None:
    """Raise InvalidValueError where writing would harm a file that is not an earlier recording of this name.

    Called after `destination`, so that what exists may be replaced as far as the user is concerned (--force).
    """
    from ..datasets.write_sidecar import FIRST_WORDS

    sidecar = output.with_suffix(".toml")
    owner = ""
    if sidecar.is_file():
        with sidecar.open(encoding="utf-8", errors="replace") as file:
            first = file.readline().rstrip("\n")
        owner = first.removeprefix(FIRST_WORDS).removesuffix(".") if first.startswith(FIRST_WORDS) else ""
    if output.exists() and owner != output.name:
        raise InvalidValueError(
            f"{output} exists, and no sidecar says that rotorwise has written it: it is never replaced. Choose another "
            "file name."
        )
    if owner and owner != output.name and output.with_name(owner).exists():
        raise InvalidValueError(
            f"{sidecar} is the sidecar of {owner}, which would lose it to {output.name}. Choose another file name."
        )
    if not os.access(output.parent, os.W_OK):
        raise InvalidValueError(f"Folder {output.parent} cannot be written to. Choose another one.")


def _checked(
    machine: Any,
    speed: str,
    duration: float,
    rate: float,
    chain: str,
    pulses: int,
    seed: int | None,
    probes: list[str],
    threads: int,
) -> dict[str, Any]:
    from .simulate_options import parse_chain, parse_speed

    if not (0 < duration < math.inf and 0 < rate < math.inf):
        raise InvalidValueError(
            f"{duration:g} s at {rate:g} Hz; allowed: more than 0, finite. Correct --duration or --rate."
        )
    if threads < 1:
        raise InvalidValueError(f"threads = {threads}; allowed: 1 or more. Correct --threads.")
    if pulses < 0 or pulses > 10_000:
        raise InvalidValueError(f"{pulses} pulses a revolution; allowed: 0 to 10000. Correct it.")
    profile = parse_speed(speed, duration_s=duration)
    # Effects look for their parts here, so that a wrong place is found before the work.
    machine.assembly(speed_rpm=profile)
    return {
        "speed_rpm": profile,
        "chain": parse_chain(chain, pulses_per_revolution=pulses),
        "seed": seed,
        "probes": probes,
    }


def _simulated(machine: Any, duration: float, rate: float, request: dict[str, Any], **options: Any) -> SimulatedRecord:
    from ..datasets.simulated import record_machine
    from .waiting import waiting

    with waiting(f"simulating {duration:g} s of {machine.name}"):
        return record_machine(machine, duration_s=duration, rate_hz=rate, **request, **options)


def _write(record: SimulatedRecord, output: Path, file_format: str, force: bool) -> Destination:
    from ..datasets.write import write_recording
    from .waiting import waiting

    command = shlex.join(["rotorwise", *sys.argv[1:]])
    origin = {"command": command, **record.provenance}
    remarks = [f"{key}: {text}" for key, text in origin.items() if key != "machine"]
    remarks += ["The machine, as a file that rotorwise simulate reads:", "", *origin["machine"].splitlines()]
    with waiting(f"writing {output.name}"):
        return write_recording(
            record.recording,
            output,
            file_format=file_format,
            notes={"provenance": json.dumps(origin)},
            remarks="\n".join(remarks),
            force=force,
        )


def _tell(record: SimulatedRecord, written: Destination, *, as_json: bool) -> None:
    recording = record.recording
    rms = (recording.signals - recording.signals.mean(axis=1, keepdims=True)).std(axis=1)
    if as_json:
        print(json.dumps(_as_json(record, written, rms.tolist()), indent=2))
        return
    print(f"{written.path}: {recording.duration_s:g} s at {recording.rate_hz:g} Hz, {written.writer.NAME}")
    print(f"sidecar: {written.sidecar}")
    print(f"label: {recording.label}")
    width = max(len(one.name) for one in recording.channels)
    for one, value in zip(recording.channels, rms, strict=True):
        if one.quantity == "tacho":
            text = f"{recording.pulses_per_revolution:g} pulses a revolution"
        else:
            text = f"{value:9.3g} {one.unit} rms"
            if one.name in record.errors:
                text += f", error about {record.errors[one.name]:.1%}"
        print(f"  {one.name:{width}}  {text}")
    for note in _notes(record):
        print(f"note: {note}")


def _notes(record: SimulatedRecord) -> list[str]:
    return [*_notes_of_length(record), *_notes_of_motion(record)]


def _notes_of_length(record: SimulatedRecord) -> list[str]:
    recording, notes = record.recording, []
    speed_rpm = recording.condition.speed_rpm
    if speed_rpm is None:
        return []
    turns = recording.duration_s * speed_rpm / 60
    if turns < _FEWEST_TURNS:
        notes.append(f"The record holds {turns:.3g} turns of the shaft; analyse wants {_FEWEST_TURNS} or more.")
    if _FLAT * recording.rate_hz < speed_rpm / 60:
        notes.append(
            f"At {recording.rate_hz:g} Hz the record ends at {_FLAT * recording.rate_hz:.3g} Hz, below the shaft's "
            f"{speed_rpm / 60:.3g} Hz: 1X and everything above it are filtered away. Give a higher --rate."
        )
    return notes


def _notes_of_motion(record: SimulatedRecord) -> list[str]:
    worst = max(record.errors.values(), default=0.0)
    if worst <= _LARGE_ERROR:
        return list(record.notes)
    name = max(record.errors, key=lambda one: record.errors[one])
    return [
        *record.notes,
        f"The step of {record.step_s:.3g} s changes {name} by {worst:.1%} against half of it: a chaotic motion, or a "
        "step that is too long; compare spectra, not samples.",
    ]


def _as_json(record: SimulatedRecord, written: Destination, rms: list[float]) -> dict[str, Any]:
    recording = record.recording
    return {
        "path": str(written.path),
        "sidecar": str(written.sidecar),
        "format": written.writer.NAME,
        "label": recording.label,
        "rate_hz": recording.rate_hz,
        "samples": recording.samples,
        "speed_rpm": recording.condition.speed_rpm,
        "pulses_per_revolution": recording.pulses_per_revolution,
        "channels": [
            {"name": one.name, "unit": one.unit, "direction": one.direction, "location": one.location, "rms": value}
            for one, value in zip(recording.channels, rms, strict=True)
        ],
        "step_s": record.step_s,
        "errors": dict(record.errors),
        "notes": _notes(record),
        "provenance": dict(record.provenance),
    }


def _leave(problem: Exception, code: int) -> typer.Exit:
    print(f"rotorwise: {problem}", file=sys.stderr)
    return typer.Exit(code)

"""What ``rotorwise machines`` does: list the machines that can be simulated, explain one, or write it as a file."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..simulators.errors import InvalidValueError
from .cli_options import option
from .label_rows import heading, row

if TYPE_CHECKING:
    from rich.console import Console

    from ..simulators.machine import Machine
    from ..simulators.parameter import Parameter

Name = Annotated[
    str | None, typer.Argument(help="Machine to explain; all are listed when left out.",
                               metavar="[MACHINE|FILE.toml]", show_default=False)
]  # fmt: skip
Preset = Annotated[str, option("--preset", value="NAME", text="Preset whose values are shown.")]
AsToml = Annotated[bool, option("--toml", text="Print a machine file with every parameter, to be edited.")]
AsJson = Annotated[bool, option("--json", text="Print JSON: one object, or a list of them.")]
_AXES = "x is horizontal, y vertical, axial along the shaft."


def machines(name: Name = None, preset: Preset = "", as_toml: AsToml = False, as_json: AsJson = False) -> None:
    """List the machines that can be simulated, or explain one: probes, load, parameters, as a file."""
    from ..simulators.machine import machine_catalogue
    from .simulate_options import parse_machine

    if name is None and (preset or as_toml):
        raise InvalidValueError(
            f"{'--toml' if as_toml else '--preset'} without a machine; allowed: {', '.join(machine_catalogue())}. "
            "Name one of them."
        )
    if as_toml and as_json:
        raise InvalidValueError("--toml and --json; allowed: one of them. Leave one out.")
    chosen = [parse_machine(name, preset=preset, settings=(), load=None)] if name else [*machine_catalogue().values()]
    if as_toml:
        print(file_text(chosen[0]), end="")
        return
    found = [machine_data(one) for one in chosen]
    if as_json:
        print(json.dumps(found[0] if name else found, indent=2))
        return
    from rich.console import Console

    console = Console(highlight=False)
    if name:
        explain(found[0], console)
        return
    for one in found:
        row(console, one["name"], one["meaning"])
    console.print("rotorwise machines NAME explains one; --toml writes it as a file to edit.", style="dim")


def machine_data(machine: Machine) -> dict[str, Any]:
    """Return what is declared of a machine, and its values, as JSON types; SI units."""
    definition, values = machine.definition, machine.values
    load = next((one for one in definition.parameters if one.name == definition.load_parameter), None)
    return {
        "name": machine.name,
        "meaning": definition.meaning,
        "preset": machine.preset_name,
        "presets": {name: own.meaning for name, own in definition.presets.items()},
        "load": {"parameter": load.name, "unit": load.unit, "meaning": load.meaning} if load else None,
        "probes": [
            {"name": one.name, "place": one.location, "direction": one.direction, "quantity": one.quantity,
             "unit": one.unit}
            for one in machine.bare_assembly().probes
        ],
        "parameters": [
            {"name": one.name, "value": values[one.name], "unit": one.unit, "lowest": one.bounds[0],
             "highest": one.bounds[1], "meaning": one.meaning, "source": one.source,
             "calibrated": one.prior is not None}
            for one in definition.parameters
        ],
        "references": list(definition.references),
    }  # fmt: skip


def file_text(machine: Machine) -> str:
    """Return a machine file with every parameter, its unit and its meaning, which reads back as the same machine."""
    given = machine.with_parameters(**machine.values).to_toml()
    declared = {one.name: one for one in machine.definition.parameters}
    lines, heading = [], ""
    for line in given.splitlines():
        heading = line if line.startswith("[") else heading
        own = declared.get(line.partition(" = ")[0]) if heading == "[parameters]" else None
        lines.append(f"{line}  # {_comment(own)}" if own else line)
    return "\n".join(lines) + "\n"


def _comment(own: Parameter) -> str:
    unit = f"{own.unit}: " if own.unit else ""
    lowest, highest = own.bounds
    return f"{unit}{' '.join(own.meaning.split())}; allowed {lowest:.4g} to {highest:.4g}"


def explain(data: dict[str, Any], console: Console) -> None:
    """Print one machine; fits 80 columns."""
    from rich.markup import escape

    console.print(f"[bold underline]{data['name']}[/]  [dim]preset {escape(data['preset'])}[/]")
    console.print(escape(data["meaning"]))
    heading(console, "Presets")
    for name, meaning in data["presets"].items():
        row(console, name, meaning)
    heading(console, "Load")
    load = data["load"]
    if load:
        row(console, load["parameter"], f"{load['unit']}: {load['meaning']}")
    else:
        console.print("none")
    heading(console, "Probes")
    for one in data["probes"]:
        row(console, one["name"], f"{one['place']}, {one['direction']}, {one['quantity']} in {one['unit']}")
    console.print(_AXES, style="dim")
    heading(console, "Parameters")
    for one in data["parameters"]:
        unit = f" {one['unit']}" if one["unit"] else ""
        mark = ", calibrated on healthy recordings" if one["calibrated"] else ""
        row(console, one["name"], one["meaning"])
        row(
            console,
            "",
            f"{one['value']:.6g}{unit}, allowed {one['lowest']:.4g} to {one['highest']:.4g}{mark}",
            style="dim",
        )
    console.print(
        f"\nTo change many: rotorwise machines {data['name']} --toml > mine.toml, then --machine mine.toml. One: "
        "--set NAME=VALUE.",
        style="dim",
    )

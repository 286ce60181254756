"""``rotorwise severity``: train estimators of how large a fault is, apply them to files, judge them on a dataset."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..simulators.errors import InvalidValueError, RotorwiseError
from . import cli_options as options
from .cli_options import option
from .learning_command import HIGHEST_SEED, check_whole_numbers, exit_codes

if TYPE_CHECKING:
    from ..datasets.store import Store
    from .learning.severity.model import SeverityModel
    from .learning.severity.reading import SeverityTable

_FAILED = 3

severity = typer.Typer(
    no_args_is_help=True, rich_markup_mode=None, help="How large is the fault? Estimates with intervals, and zones."
)

Location = Annotated[str, typer.Argument(help="Folder or address of a dataset.", metavar="STORE", show_default=False)]
ModelFile = Annotated[Path, typer.Argument(help="Severity model.", metavar="MODEL.skops", show_default=False)]
Output = Annotated[Path, option("--output", "-o", value="MODEL.skops", text="Write the model here.")]
Split = Annotated[
    str | None, option("--split", value="NAME", text="Only this split of the dataset; all when left out.")
]
TrainSplit = Annotated[str, option("--split", value="NAME", text="Of the dataset; train when left out.")]
Coverage = Annotated[float, option("--coverage", value="SHARE", text="Of the intervals; 0.9 when left out.")]
Seed = Annotated[int, option("--seed", value="N", text="Of folds and estimators; 0 when left out.")]
Calibration = Annotated[
    str | None,
    option(
        "--calibrate", value="STORE", text="Take the intervals from these machines, split calibration if it has one."
    ),
]
Alone = Annotated[bool, option("--alone", text="Each estimator takes its fault for the only one: sharper, if it is.")]
Force = Annotated[bool, option("--force", text="Replace an existing severity model.")]
AsJson = Annotated[bool, option("--json", text="Print JSON.")]


@severity.command()
def train(
    location: Location,
    output: Output,
    split: TrainSplit = "train",
    calibration: Calibration = None,
    coverage: Coverage = 0.9,
    seed: Seed = 0,
    alone: Alone = False,
    force: Force = False,
) -> None:
    """Train estimators from a simulated dataset of one machine."""
    from ..datasets.store import open_store
    from .learning.severity.model import calibrate
    from .learning.severity.model import train as train_model
    from .learning.severity.model_file import SeverityFileError, check_place, save_model

    with exit_codes(SeverityFileError):
        check_place(output, force=force)
        check_whole_numbers(seed=(seed, 0, HIGHEST_SEED))
        if not 0 < coverage < 1:
            raise InvalidValueError(f"--coverage {coverage:g}; allowed: above 0, below 1, such as 0.9. Correct it.")
        store = open_store(location)
        shifted = None if calibration is None else open_store(calibration)
        table, responses = _table(store)
        model = train_model(store, split=split, coverage=coverage, seed=seed, alone=alone, table=table)
        if shifted is not None:
            other, _ = _table(shifted, responses)
            own = other.splits == "calibration"
            calibrate(model, other.part(own) if own.any() else other)
        save_model(model, output, force=force)
    from .learning.severity.words import card_lines

    print("\n".join([*card_lines(model.card), *_refused(table), f"model: {output}"]))


@severity.command()
def estimate(
    model: ModelFile,
    files: options.Files,
    speed: options.Speed = None,
    bearing: options.Bearing = None,
    rate: options.Rate = None,
    unit: options.Unit = None,
    sensitivity: options.Sensitivity = None,
    channel_name: options.ChannelName = None,
    tacho: options.Tacho = None,
    pulses_per_revolution: options.Pulses = None,
    sidecar: options.Sidecar = None,
    as_json: AsJson = False,
) -> None:
    """Estimate severities in recordings of the machine that a model was trained on."""
    from ..datasets.reading import find_recordings, read
    from .learning.severity.model_file import load_model
    from .learning.severity.words import answer_data, answer_lines

    with exit_codes():
        loaded = load_model(model)
        record = options.record_metadata(rate, speed, tacho, pulses_per_revolution)
        channels = options.channel_metadata(unit, sensitivity, channel_name, None, None)
        machine = options.machine_metadata(bearing, None, None, None, None, None, None)
        metadata = record.merged_over(channels).merged_over(machine)
        # A file that is missing is told of beside the others.
        paths = [one for file in files for one in (find_recordings([file])[0] if file.is_dir() else [file])]
        if not paths:
            raise InvalidValueError(
                f"No recording in {', '.join(map(str, files))}; allowed: files that a reader knows. Name recordings."
            )
    found: list[dict[str, Any]] = []
    for file in paths:
        try:
            answer = loaded.estimate(read(file, metadata=metadata, sidecar=sidecar))
        except (RotorwiseError, OSError) as problem:
            said = str(problem)
            print(f"rotorwise: {said if str(file) in said else f'{file}: {said}'}", file=sys.stderr)
            found.append({"path": str(file), "refused": said})
            continue
        found.append({"path": str(file), **answer_data(answer)})
        if not as_json:
            print("\n".join(answer_lines(str(file), answer, coverage=loaded.card["coverage"])))
    if as_json:
        print(json.dumps(found, indent=2))
    raise typer.Exit(_FAILED if any("refused" in one for one in found) else 0)


@severity.command()
def evaluate(model: ModelFile, location: Location, split: Split = None, as_json: AsJson = False) -> None:
    """Compare estimates with the truth of a simulated dataset: errors, coverage, zones; by case."""
    from ..datasets.store import open_store
    from .learning.severity.evaluation import score_targets, score_zones
    from .learning.severity.model_file import load_model
    from .learning.severity.words import score_data, score_lines
    from .waiting import waiting

    with exit_codes():
        loaded = load_model(model)
        table, _ = _table(open_store(location), loaded.responses)
        _check_table(loaded, table, split, location)
        table = table if split is None else table.part(table.splits == split)
        with waiting("comparing zones"):
            targets, zones = score_targets(loaded, table), score_zones(loaded, table)
    if as_json:
        print(json.dumps(score_data(targets, zones), indent=2))
        return
    print("\n".join([*loaded.remarks, *score_lines(targets, zones, coverage=loaded.card["coverage"])]))


def _table(store: Store, responses: Any = None) -> tuple[SeverityTable, Any]:
    from .learning.severity.reading import probes_of, read_table, reference_machine
    from .learning.severity.unit_responses import UnitResponses
    from .waiting import waiting

    if responses is None:
        responses = UnitResponses(reference_machine(store.recipe), probes_of(store.recipe))
    with waiting(f"reading {store.folder.name}"):
        return read_table(store, responses=responses), responses


def _check_table(model: SeverityModel, table: SeverityTable, split: str | None, location: str) -> None:
    if table.names != model.features or set(model.regressors) - set(table.labels):
        raise InvalidValueError(
            f"{location} has other features or labels than the model was trained on. Use a dataset of the same probes, "
            "rate and severities."
        )
    if split is not None and not (table.splits == split).any():
        raise InvalidValueError(
            f"{location} has no rows of split {split!r}; allowed: {', '.join(sorted(set(table.splits)))}. Correct it."
        )


def _refused(table: SeverityTable) -> list[str]:
    return [f"{len(table.refused)} records left out; the first: {table.refused[0]}"] if table.refused else []

"""``rotorwise trials``: hide causes in simulated campaigns, let the gap engine look for them, and score it."""

from __future__ import annotations

import json
import math
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..simulators.errors import InvalidValueError
from .cli_options import option
from .decimal_option import decimal_option

if TYPE_CHECKING:
    from .gap.trials.outcome import Outcome
    from .gap.trials.run import Trials
    from .gap.trials.scores import Scores

_OUTPUT_FAILED = 4
Machine = Annotated[str, option("--machine", value="NAME", text="Shipped machine on which to hide causes.")]
Count = Annotated[int, option("--n", value="N", text="Number of trials; twenty hold all kinds in their shares.")]
Seed = Annotated[int, option("--seed", value="N", text="The same seed gives the same trials.")]
Noise = Annotated[
    float, decimal_option("--snr-db", value="DB", text="Signal-to-noise ratio of every record in dB: 20 or 30.")
]
Family = Annotated[
    str, option("--family", value="tune|score", text="Trials to set thresholds on, or to judge by; none is in both.")
]
WrongForm = Annotated[
    float,
    decimal_option(
        "--wrong-form", value="SHARE", text="Share of their stiffness by which the supports differ from the model's."
    ),
]
AsGiven = Annotated[bool, option("--as-given", text="The engine does not extend its model on healthy recordings.")]
Anywhere = Annotated[
    bool, option("--anywhere", text="The tacho's pulse and the machine's own unbalance are at any angle of the shaft.")
]
Jobs = Annotated[int | None, option("--jobs", value="J", text="Processes; one for every core when left out.")]
Output = Annotated[
    Path, option("--output", "-o", value="FOLDER", text="Where outcomes, scores and pictures go; a run goes on there.")
]
AsJson = Annotated[bool, option("--json", text="Print the scores as JSON.")]


def trials(
    machine: Machine,
    count: Count,
    seed: Seed,
    snr_db: Noise,
    family: Family = "score",
    wrong_form: WrongForm = 0.0,
    as_given: AsGiven = False,
    anywhere: Anywhere = False,
    jobs: Jobs = None,
    output: Output = Path("rotorwise-trials"),
    as_json: AsJson = False,
) -> None:
    """Test the gap engine blindly: hidden causes, nothing at all, pairs, and causes that it does not know.

    Every outcome is kept at once: the same command goes on where it was stopped.
    """
    from .gap.explain import explain_gap
    from .gap.trials.run import TrialFileError, Trials, run_trials
    from .gap.trials.scores import score

    which = Trials(machine, seed, snr_db, family, wrong_form, as_given, anywhere)
    jobs = _checked(count, jobs, output)
    name = f"{machine}-{family}-seed{seed}-{snr_db:g}db"
    name += (f"-wrong{wrong_form:g}" if wrong_form else "") + ("-as-given" if as_given else "")
    name += "-anywhere" if anywhere else ""
    try:
        with _progress(count) as tell:
            outcomes = run_trials(which, count, explain_gap, file=output / f"{name}.jsonl", jobs=jobs, tell=tell)
        found = score(outcomes)
        files = _write(found, which, output, name)
    except TrialFileError as problem:
        print(f"rotorwise: {problem}", file=sys.stderr)
        raise typer.Exit(_OUTPUT_FAILED) from None
    if as_json:
        print(json.dumps({**_origin(which), **_data(found), "files": [str(file) for file in files]}, indent=2))
        return
    _show(found, which)
    for file in files:
        print(file)


def _checked(count: int, jobs: int | None, output: Path) -> int:
    for name, value in (("--n", count), ("--jobs", 1 if jobs is None else jobs)):
        if value < 1:
            raise InvalidValueError(f"{name} {value}; allowed: 1 or more. Correct it.")
    if output.exists() and not output.is_dir():
        raise InvalidValueError(f"{output} is no folder. Choose another one with --output.")
    return jobs or os.cpu_count() or 1


def _progress(count: int) -> Any:
    from contextlib import contextmanager

    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    @contextmanager
    def bar() -> Any:
        columns = (
            TextColumn("trials"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            TextColumn("{task.description}"),
        )
        with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
            task = shown.add_task("", total=count)

            def tell(outcome: Outcome, done: int) -> None:
                words = f"{outcome.truth}: {outcome.answer}"
                shown.update(task, completed=done, description=words)
                if not shown.console.is_terminal:
                    print(f"rotorwise: trial {done} of {count}, {words}", file=sys.stderr, flush=True)

            yield tell

    return bar()


def _origin(which: Trials) -> dict[str, Any]:
    return {name: value for name, value in which.head.items() if name != "rotorwise_trials"}


def _data(found: Scores) -> dict[str, Any]:
    from .gap.trials.scores import as_json

    return as_json(found)


def _write(found: Scores, which: Trials, folder: Path, name: str) -> list[Path]:
    """Write scores and pictures; return all files."""
    from .gap.trials.picture import confusion_svg, reliability_svg
    from .gap.trials.run import TrialFileError
    from .papers_files import TableFileError, write_whole

    words = f"{which.machine}, {found.n} trials, {which.snr_db:g} dB, {which.family} {which.seed}"
    texts = {
        f"{name}.json": json.dumps({**_origin(which), **_data(found)}, indent=2) + "\n",
        f"{name}-confusion.svg": confusion_svg(found, title=words),
        f"{name}-reliability.svg": reliability_svg(found, title=words),
    }
    try:
        for file, text in texts.items():
            write_whole(folder / file, text)
    except TableFileError as problem:
        raise TrialFileError(str(problem)) from None
    return [folder / f"{name}.jsonl", *(folder / file for file in texts)]


def _show(found: Scores, which: Trials) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False)
    console.print(f"[bold]{found.n} blind trials of {which.machine} at {which.snr_db:g} dB[/]")
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for label, text in _rows(found):
        table.add_row(label, text)
    console.print(table)
    effects = Table(box=None, padding=(0, 2, 0, 0), title="One hidden effect", title_justify="left")
    for heading in ("effect", "n", "right", "right, d2 >= 100", "wrong name", "covered", "gain"):
        effects.add_column(heading, justify="left" if heading == "effect" else "right")
    for name, own in found.by_effect.items():
        clear = f"{_percent(own['top1_clear'])} of {own['n_clear']}"
        wrong, covered = _percent(own["named_wrong"]), _percent(own["coverage90"])
        effects.add_row(name, str(own["n"]), _percent(own["top1"]), clear, wrong, covered, _db(own["gain_db"]))
    console.print(effects)


def _rows(found: Scores) -> list[tuple[str, str]]:
    rows = [("one cause, right", _percent(found.top1))]
    rows += [(f"  d2 {label}", f"{_percent(part)} of {count}") for label, (count, part) in found.top1_by_d2.items()]
    rows += [
        ("wrong name", _percent(found.named_wrong)),
        ("false alarm, nothing hidden", _percent(found.null_false_alarm)),
        ("unknown, recognised", _percent(found.unknown_recall)),
        ("pair, both right", _percent(found.pair_exact)),
        ("pair, one right or both", _percent(found.pair_any)),
        ("calibration error", f"{found.calibration_error:.3f}"),
        ("90 % intervals that hold the truth", _percent(found.coverage90)),
        ("held-out gain", f"{_db(found.gain_db)}, knowing the truth {_db(found.oracle_gain_db)}"),
        ("seconds a trial", f"{found.seconds_per_trial:.1f}"),
    ]
    return rows + ([("engine failed", f"{found.errors} trials")] if found.errors else [])


def _percent(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.1%}"


def _db(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.1f} dB"

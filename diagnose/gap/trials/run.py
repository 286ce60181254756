"""Runs blind trials: makes each case, asks the engine, keeps every outcome at once in a file.

The file's first line says what the trials are; each further line is one outcome. A run that was stopped goes on where
it stopped, and a longer run begins with what is there.
"""

from __future__ import annotations

import inspect
import json
import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any

from ....simulators.errors import InvalidValueError, RotorwiseError
from .cases import TrialCase, check, make_case
from .outcome import Outcome, from_line, outcome_of, to_line
from .scores import DETECTABLE

#: Of the file and of the cases: raised when the same arguments make other cases than before.
FORMAT = 14
#: ``explain(campaign, machine, without=...)``, with ``only=...`` where the engine offers it.
Explain = Callable[..., Any]
Tell = Callable[[Outcome, int], None]


class TrialFileError(RotorwiseError):
    """A file of outcomes that cannot be gone on with."""


@dataclass(frozen=True)
class Trials:
    """Which trials: all with the same values except the number are the same trials.

    Attributes
    ----------
    machine : str
    seed : int
    snr_db : float
    family : str
    wrong_form : float
        Share of their stiffness by which the machine's supports are other than its model's.
    as_given : bool
        Whether the engine must not extend the model on healthy recordings.
    anywhere : bool
        Whether the tacho's pulse, and the machine's own unbalance, may be at any angle of the shaft.
    """

    machine: str
    seed: int
    snr_db: float
    family: str = "score"
    wrong_form: float = 0.0
    as_given: bool = False
    anywhere: bool = False

    def __post_init__(self) -> None:
        check(self.machine, seed=self.seed, snr_db=self.snr_db, family=self.family, wrong_form=self.wrong_form)

    @property
    def head(self) -> dict[str, Any]:
        """What the file of the outcomes says of them; what is as usual is not said."""
        every = {"rotorwise_trials": FORMAT, **asdict(self)}
        usual = ("wrong_form", "as_given", "anywhere")
        return {name: value for name, value in every.items() if name not in usual or value}


def run_trials(
    trials: Trials,
    count: int,
    explain: Explain,
    *,
    file: Path | None = None,
    jobs: int = 1,
    tell: Tell = lambda _outcome, _done: None,
) -> list[Outcome]:
    """Return the outcomes of the first ``count`` trials, by number.

    Parameters
    ----------
    trials : Trials
    count : int
    explain : callable
        The engine; a function of a module when there is more than one job.
    file : Path, optional
        Where outcomes are kept; those already there are not computed again.
    jobs : int
        Processes.
    tell : callable
        Called with every new outcome and how many there are now.

    Raises
    ------
    InvalidValueError
        For a count or a number of jobs below 1.
    TrialFileError
        When the file holds other trials, or cannot be read or written.
    """
    for name, value in (("n", count), ("jobs", jobs)):
        if value < 1:
            raise InvalidValueError(f"{name} = {value}; allowed: 1 or more. Correct it.")
    found = {one.number: one for one in _begun(file, trials)} if file else {}
    done = {number: one for number, one in found.items() if number < count}
    for outcome in _outcomes(trials, [number for number in range(count) if number not in done], explain, jobs):
        if file:
            _append(file, to_line(outcome))
        done[outcome.number] = outcome
        tell(outcome, len(done))
    return [done[number] for number in sorted(done)]


def _outcomes(trials: Trials, numbers: Sequence[int], explain: Explain, jobs: int) -> Iterator[Outcome]:
    if jobs == 1 or len(numbers) < 2:
        yield from (one_trial(trials, number, explain) for number in numbers)
        return
    others = set(active_children())
    # A forked process would inherit locks of numba and BLAS in any state.
    with ProcessPoolExecutor(min(jobs, len(numbers)), mp_context=get_context("spawn")) as pool:
        waiting = [pool.submit(one_trial, trials, number, explain) for number in numbers]
        try:
            for future in as_completed(waiting):
                yield future.result()
        except BaseException:
            # Whoever stops a run does not wait for the trials that are under way.
            pool.shutdown(wait=False, cancel_futures=True)
            for process in set(active_children()) - others:
                process.terminate()
            raise


def one_trial(trials: Trials, number: int, explain: Explain) -> Outcome:
    """Return the outcome of one trial. Whatever the engine raises becomes an outcome: one case must not end a run."""
    from threadpoolctl import threadpool_limits

    # The matrices are small, and the other cores have trials of their own.
    with threadpool_limits(1):
        case = make_case(
            trials.machine,
            number=number,
            seed=trials.seed,
            snr_db=trials.snr_db,
            family=trials.family,
            wrong_form=trials.wrong_form,
            anywhere=trials.anywhere,
        )
        begun = time.perf_counter()
        try:
            options = {"as_given": True} if trials.as_given else {}
            result = explain(case.campaign, case.machine, without=case.left_out, **options)
        except Exception as problem:
            text = f"{type(problem).__name__}: {problem}"
            return outcome_of(case, None, seconds=time.perf_counter() - begun, error=text)
        seconds = time.perf_counter() - begun
        return outcome_of(case, result, seconds=seconds, oracle_gain_db=_oracle_gain_db(case, explain))


def _oracle_gain_db(case: TrialCase, explain: Explain) -> float:
    """Return the gain of an engine that considers the true effects only; NaN where that says nothing."""
    takes_only = "only" in inspect.signature(explain).parameters
    if case.kind not in ("one", "two") or case.d2 < DETECTABLE or not takes_only:
        return math.nan
    try:
        result = explain(case.campaign, case.machine, only=frozenset(one.effect.NAME for one in case.hidden))
    except Exception:
        return math.nan
    return float(result.gain.held_out_db)


def _begun(file: Path, trials: Trials) -> list[Outcome]:
    """Return the outcomes that a file holds; begin it when there is none."""
    head = json.dumps(trials.head)
    try:
        if not file.exists():
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(head + "\n", encoding="utf-8")
            return []
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as problem:
        raise TrialFileError(f"{file} cannot be used for outcomes: {problem}. Choose another folder.") from None
    first, *lines = text.splitlines() or [""]
    if first != head:
        raise TrialFileError(f"{file} holds other trials ({first[:80]}); allowed: {head}. Choose another folder.")
    # A run that was killed while it wrote leaves half a line.
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        file.write_text(whole, encoding="utf-8")
        lines = whole.splitlines()[1:]
    try:
        return [from_line(line) for line in lines]
    except (ValueError, KeyError, TypeError) as problem:
        raise TrialFileError(f"{file} holds a line that is no outcome: {problem}. Choose another folder.") from None


def _append(file: Path, line: str) -> None:
    try:
        with file.open("a", encoding="utf-8") as opened:
            opened.write(line + "\n")
            opened.flush()
            os.fsync(opened.fileno())
    except OSError as problem:
        raise TrialFileError(f"{file} cannot be written: {problem.strerror or problem}. Make room.") from None

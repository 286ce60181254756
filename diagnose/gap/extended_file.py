"""The extended machine as a file: what `rotorwise simulate` reads, with where its values come from as comments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path

from ...datasets.sidecar import FOLDER_SIDECAR
from ...simulators.effect import effect_catalogue
from ...simulators.effects.empirical_force import EmpiricalForce
from ...simulators.errors import RotorwiseError
from ...simulators.machine import machine_from_toml
from ..papers_files import write_whole
from .result import AddedForce, Cause, GapResult
from .words import not_compared_words, probability_words, sentence_of

#: A file that starts so was made here, and may be replaced.
FIRST_WORDS = "# Machine extended by rotorwise gap"
#: Effects that were added on the healthy recordings.
OF_HEALTHY = frozenset(name for name, effect in effect_catalogue().items() if effect.EMPIRICAL) - {EmpiricalForce.NAME}
_WIDTH = 96


class ExtendedFileError(RotorwiseError):
    """An extended machine cannot be written where it was asked for."""


def extended_text(result: GapResult, *, sources: Sequence[str] = (), notes: Sequence[str] = ()) -> str:
    """Return the extended machine as TOML with comments; without a date, so that equal runs give equal files.

    Parameters
    ----------
    result : GapResult
    sources : sequence of str
        Names of the recordings that it was fitted to.
    notes : sequence of str
        Further lines of the head.

    Raises
    ------
    ExtendedFileError
        When the text does not give the machine back: a mistake of rotorwise.
    """
    head = [f"{FIRST_WORDS}, rotorwise {version('rotorwise')}.", *_head(result, sources, notes)]
    body = result.extended.to_toml()
    text = "\n".join([*head, "", *_annotated(body, result)]) + "\n"
    if machine_from_toml(text).to_toml() != body:
        raise ExtendedFileError(
            f"The extended machine {result.extended.name} does not survive being written; allowed: a text that gives "
            "it back. Please report it."
        )
    return text


def check_extended_place(path: Path, *, force: bool, recordings: Sequence[Path] = (), machine: str = "") -> None:
    """Raise ExtendedFileError when an extended machine cannot go here.

    Parameters
    ----------
    path : Path
    force : bool
        Whether an earlier extended machine may be replaced.
    recordings : sequence of Path
        A file beside one of them would be taken for its sidecar.
    machine : str
        The machine file that was read, which stays as it is.
    """
    target = path.resolve()
    if target.suffix.casefold() != ".toml":
        raise ExtendedFileError(f"{path}: a machine file; allowed: a name that ends in .toml. Correct it.")
    if target.is_dir():
        raise ExtendedFileError(f"{path} is a folder; allowed: a file. Add a name, for example extended.toml.")
    if not target.parent.is_dir():
        raise ExtendedFileError(f"Folder {path.parent} of {path.name} does not exist. Make it first.")
    beside = [one.resolve() for one in recordings]
    if any(target in (one.with_suffix(".toml"), one.parent / FOLDER_SIDECAR) for one in beside):
        raise ExtendedFileError(f"{path} would be taken for the sidecar of a recording. Choose another name or folder.")
    if machine.casefold().endswith(".toml") and target == Path(machine).resolve():
        raise ExtendedFileError(f"{path} is the machine that is to be extended; it stays. Choose another name.")
    if not target.exists():
        return
    if not force:
        raise ExtendedFileError(f"{path} exists already. Choose another name, or allow overwriting (--force).")
    if not target.is_file() or not _is_ours(target):
        raise ExtendedFileError(
            f"{path} exists and was not made by rotorwise gap: it is never replaced. Choose another name."
        )


def write_extended(
    result: GapResult,
    path: Path,
    *,
    force: bool = False,
    recordings: Sequence[Path] = (),
    healthy: Sequence[Path] = (),
    notes: Sequence[str] = (),
) -> None:
    """Write the extended machine; see `extended_text` and `check_extended_place`.

    Raises
    ------
    ExtendedFileError, TableFileError
        When the file exists and ``force`` is not set, is not ours, or cannot be written.
    """
    sources = [one.name for one in recordings]
    sources += [f"{one.name} (healthy)" for one in healthy]
    text = extended_text(result, sources=sources, notes=notes)
    check_extended_place(path, force=force, recordings=(*recordings, *healthy))
    write_whole(path, text)


def _is_ours(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(FIRST_WORDS)) == FIRST_WORDS.encode()
    except OSError:
        return False


def _head(result: GapResult, sources: Sequence[str], notes: Sequence[str]) -> Iterator[str]:
    yield "#"
    yield from _comment(sentence_of(result))
    if result.kind in ("none", "cannot tell") or (result.kind == "unknown" and not result.empirical):
        yield from _comment("No effect was added: this is the machine as calibrated.")
    yield "#"
    every, held_out = result.measured.conditions, result.gain.held_out
    fitted = [str(one) for i, one in enumerate(every) if i not in held_out]
    apart = f" Held out: {'; '.join(str(every[i]) for i in held_out)}." if held_out else ""
    yield from _comment(f"Fitted to {'; '.join(fitted)} at {', '.join(result.measured.probes)}.{apart}")
    if sources:
        yield from _comment(f"Recordings: {', '.join(sources)}.")
    yield from _comment(
        "Intervals hold 90 %. Angles are counted from the model's zero: the tacho's pulse, unless said otherwise."
    )
    for names in result.indistinguishable:
        yield from _comment(f"Not distinguishable from these data: {', '.join(names)}.")
    for text in (*notes, *result.remarks, *(not_compared_words(result.not_compared))):
        yield from _comment(text)


def _comment(text: str) -> list[str]:
    from textwrap import wrap

    # TOML allows no control characters in comments.
    printable = "".join(letter if letter.isprintable() else " " for letter in text)
    return [f"# {line}" for line in wrap(printable, _WIDTH, break_long_words=False, break_on_hyphens=False)]


def _annotated(body: str, result: GapResult) -> Iterator[str]:
    """Yield the lines of a machine's text with a comment where a value was fitted."""
    effect, at, fitted = "", "", result.extended.values
    given = result.machine.values
    blocks = iter(result.extended.effects)
    current, numbers = None, dict[str, int]()
    for line in body.rstrip("\n").splitlines():
        if line == "[[effects]]":
            current = next(blocks)
            effect, at = current.NAME, current.at
            numbers[effect] = numbers.get(effect, -1) + 1
            yield line
            continue
        name, equals, _ = line.partition(" = ")
        remark = ""
        if equals and current is None and name in given and fitted[name] != given[name]:
            beside = ", fitted beside what was added" if result.causes or result.empirical else ""
            remark = f"calibrated{beside}; given: {given[name]:.6g}"
        elif equals and current is not None and effect == EmpiricalForce.NAME and result.empirical:
            # The last ones: the machine as given may have some of its own.
            own = numbers[effect] - sum(effect == e.NAME for e in result.extended.effects) + len(result.empirical)
            remark = _force_remark(result.empirical[own], name) if own >= 0 else ""
        elif equals and current is not None and effect in OF_HEALTHY:
            remark = "what the healthy recordings ask for" if name == "effect" else ""
        elif equals and current is not None:
            remark = _interval(result.causes, effect, at, name)
        yield f"{line}  # {remark}" if remark else line


def _force_remark(force: AddedForce, name: str) -> str:
    fitted = {
        {"axial": "axial_n", "torsion": "torque_n_m"}.get(force.direction, "force_n"): force.amplitude,
        "phase_rad": force.phase,
        "speed_exponent": force.speed_exponent,
        "load_exponent": force.load_exponent,
    }
    if name == "effect":
        return "its cause is unknown"
    one = fitted.get(name)
    return f"{one.low:.4g} to {one.high:.4g} {one.unit}".rstrip() if one else ""


def _interval(causes: Sequence[Cause], effect: str, at: str, name: str) -> str:
    cause = next((one for one in causes if one.effect == effect and one.at == at), None)
    if cause is None:
        return ""
    if name == "effect":
        return f"probability {probability_words(cause.probability)}"
    one = cause.parameters.get(name)
    if one is None:
        return ""
    ends = f"{one.low:.4g} to {one.high:.4g} {one.unit}".rstrip()
    return ends if one.is_told else f"not told by the data: {ends} possible"

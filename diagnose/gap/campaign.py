"""From files and folders to a campaign for a machine: what is explained, what is healthy, which channel is what.

A sub-folder ``baseline`` of a folder holds recordings of the healthy machine unless they are named otherwise. Files
that cannot be read are left out and told of; what contradicts the machine stops everything.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path

from ...datasets.errors import MissingMetadataError, UnreadableFileError
from ...datasets.metadata import Metadata
from ...datasets.reading import find_recordings, read
from ...datasets.recording import Campaign, Recording
from ...datasets.sidecar import FOLDER_SIDECAR, find_sidecar
from ...simulators.errors import InvalidValueError
from ...simulators.machine import Machine
from ...simulators.parameter import Parameter
from ..signal.speed import speed_from_tacho
from .asked import not_shared
from .channels import SAME_WAY, Matched, as_probes, match_channels, parse_probes
from .fitness import UnfitRecordingError, fit, in_few_words
from .reader_warnings import warnings_told
from .repeated_recordings import without_repeated

BASELINE_FOLDER = "baseline"
#: Of a longer file the beginning is taken: order lines do not need more.
MOST_SAMPLES = 4_000_000
#: Units of a load, as they are compared, with how many of the machine's one of the file's is.
UNITS_OF_LOAD = {("lb", "kg"): 0.45359237, ("lbf", "kg"): 0.45359237, ("kn", "n"): 1e3, ("knm", "nm"): 1e3}
#: Why a probe is left out that only some recordings have.
NOT_IN_ALL = "it cannot be used in every recording"

Tell = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class ReadCampaign:
    """A campaign whose channels have the names of the machine's probes.

    Attributes
    ----------
    campaign : Campaign
        Without labels: what is to be found out must not be known.
    probes : tuple of str
        The probes that every recording has.
    notes : tuple of str
        What was left out and why, and what was assumed.
    unreadable : tuple of str
        One message a file that could not be read or compared.
    channels : mapping of str to str
        The channel, as it is called in the first recording that can be used, by probe.
    """

    campaign: Campaign
    probes: tuple[str, ...]
    notes: tuple[str, ...] = ()
    unreadable: tuple[str, ...] = ()
    channels: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Sources:
    """The files of a campaign.

    Attributes
    ----------
    recordings, baseline : tuple of Path
    left_out : tuple of Path
        Files in the folders that no reader knows.
    """

    recordings: tuple[Path, ...]
    baseline: tuple[Path, ...]
    left_out: tuple[Path, ...] = ()


def find_sources(paths: Sequence[Path], *, baseline: Sequence[Path] = ()) -> Sources:
    """Return the files to explain and those of the healthy machine.

    Parameters
    ----------
    paths : sequence of Path
        Files or folders.
    baseline : sequence of Path
        Files or folders of the healthy machine; the sub-folders ``baseline`` of the folders when left out.

    Raises
    ------
    UnreadableFileError
        When a path does not exist.
    InvalidValueError
        When there is nothing to explain, or nothing in what was named as baseline.
    """
    healthy = list(baseline) or [one / BASELINE_FOLDER for one in paths if (one / BASELINE_FOLDER).is_dir()]
    found, left = find_recordings(paths)
    known, other = find_recordings(healthy)
    reference = {one.resolve() for one in known}
    recordings = tuple(dict.fromkeys(one for one in found if one.resolve() not in reference))
    if found and not recordings:
        raise InvalidValueError(
            f"All recordings of {', '.join(map(str, paths))} are named as healthy ones as well; allowed: others to "
            "explain. Correct --baseline."
        )
    if not recordings:
        raise InvalidValueError(
            f"No recording to explain in {', '.join(map(str, paths))}; allowed: files that a reader knows. Healthy "
            f"recordings belong into the sub-folder {BASELINE_FOLDER}, or are named with --baseline."
        )
    if baseline and not known:
        raise InvalidValueError(
            f"No recording in {', '.join(map(str, baseline))}; allowed: files that a reader knows. Correct --baseline."
        )
    return Sources(recordings, tuple(dict.fromkeys(known)), (*left, *other))


def read_campaign(
    sources: Sources,
    machine: Machine,
    *,
    metadata: Metadata | None = None,
    sidecar: Path | None = None,
    probes: Sequence[str] = (),
    loads: Sequence[str] = (),
    tell: Tell = lambda _: None,
) -> ReadCampaign:
    """Return the campaign that the files hold, as probes of a machine.

    Parameters
    ----------
    sources : Sources
    machine : Machine
    metadata : Metadata, optional
        What the user says of every file.
    sidecar : Path, optional
        Instead of the sidecars beside the files. A folder's `recording.toml` also holds for its ``baseline``.
    probes : sequence of str
        Texts ``CHANNEL=PROBE``.
    loads : sequence of str
        Texts ``VALUE``, or ``PATTERN=VALUE`` for the files whose name matches, in the unit of the machine's load.
    tell : callable
        Takes what is being done.

    Raises
    ------
    InvalidValueError
        When channels, units or loads do not fit the machine.
    UnfitRecordingError
        When no recording is left.
    """
    if sidecar is not None and not sidecar.is_file():
        raise InvalidValueError(f"Sidecar {sidecar}: no such file. Check --sidecar.")
    declared = machine.bare_assembly().probes
    given, stated = parse_probes(probes, declared), parse_loads(loads, machine)

    def opened(path: Path) -> tuple[Recording, Matched, list[str]]:
        tell(f"reading {path.name}")
        recording = _loaded(_read(path, metadata, sidecar), machine, stated)
        return fit(recording, match_channels(recording, declared, given=given))

    kept, unreadable, doubts = _opened(sources, opened)
    repeated = without_repeated(kept, sources.baseline)
    _check_left(sources, kept, unreadable)
    shared = _shared(sources, kept, [probe.name for probe in declared])
    notes = (
        *_notes(sources, kept, shared, machine, unreadable),
        *_idle_patterns(stated, sources),
        *repeated,
        *warnings_told([recording for recording, _ in kept.values()]),
        *in_few_words(doubts),
    )
    campaign = _campaign_of(sources, kept, shared)
    return ReadCampaign(campaign, shared, notes, tuple(unreadable), _channels_of(kept, shared))


def _campaign_of(sources: Sources, kept: Mapping[Path, tuple[Recording, Matched]], shared: Sequence[str]) -> Campaign:
    ready = {path: _prepared(recording, matched, shared) for path, (recording, matched) in kept.items()}
    return Campaign(
        tuple(ready[path] for path in sources.recordings if path in ready),
        tuple(ready[path] for path in sources.baseline if path in ready),
        name=_name(sources),
    )


def _opened(
    sources: Sources, opened: Callable[[Path], tuple[Recording, Matched, list[str]]]
) -> tuple[dict[Path, tuple[Recording, Matched]], list[str], list[str]]:
    """Return the recordings that can be used, why others cannot, and what is doubtful about those that can."""
    kept, unreadable, doubts = {}, [], []
    for path in (*sources.recordings, *sources.baseline):
        try:
            recording, matched, found = opened(path)
        except (UnreadableFileError, MissingMetadataError, UnfitRecordingError) as problem:
            unreadable.append(str(problem) if path.name in str(problem) else f"{path}: {problem}")
            continue
        kept[path] = recording, matched
        doubts += found
    return kept, unreadable, doubts


def parse_loads(texts: Sequence[str], machine: Machine) -> dict[str, float]:
    """Return loads by pattern of the file name from texts ``VALUE`` (for all) or ``PATTERN=VALUE``.

    Raises
    ------
    InvalidValueError
        For a machine without load, a text of another form, or a load out of bounds.
    """
    found = {}
    for text in texts:
        pattern, equals, value = (part.strip() for part in text.rpartition("="))
        parameter = load_parameter(machine)
        if parameter is None:
            raise InvalidValueError(f"--load {text}: machine {machine.name} has no load. Leave --load out.")
        if equals and not pattern:
            raise InvalidValueError(f"--load {text!r}; allowed: VALUE or PATTERN=VALUE. Correct it.")
        found[pattern or "*"] = parameter.checked(value)
    return found


def _idle_patterns(stated: Mapping[str, float], sources: Sources) -> list[str]:
    """Return notes on loads whose pattern no file meets."""
    names = [path.name for path in (*sources.recordings, *sources.baseline)]
    idle = [one for one in stated.items() if not any(fnmatchcase(name, one[0]) for name in names)]
    return [f"--load {pattern}={value:g}: no recording has such a name." for pattern, value in idle]


def load_parameter(machine: Machine) -> Parameter | None:
    """Return the parameter that is the machine's load; None when it has none."""
    name = machine.definition.load_parameter
    return next((one for one in machine.definition.parameters if one.name == name), None)


def _read(path: Path, metadata: Metadata | None, sidecar: Path | None) -> Recording:
    if sidecar is None and path.parent.name == BASELINE_FOLDER and find_sidecar(path) is None:
        above = path.parent.parent / FOLDER_SIDECAR
        sidecar = above if above.is_file() else None
    return read(path, metadata=metadata, sidecar=sidecar, stop=MOST_SAMPLES)


def _loaded(recording: Recording, machine: Machine, stated: Mapping[str, float]) -> Recording:
    """Return the recording with its load in the unit of the machine's, checked."""
    parameter = load_parameter(machine)
    if parameter is None:
        return recording
    path, said = Path(recording.provenance.path or ""), recording.condition
    fitting = [value for pattern, value in stated.items() if fnmatchcase(path.name, pattern)]
    if fitting:
        return _with_load(recording, fitting[-1], parameter)
    if said.load is None:
        return recording
    units = _plain(said.load_unit or parameter.unit), _plain(parameter.unit)
    factor = 1.0 if units[0] == units[1] else UNITS_OF_LOAD.get(units)
    if factor is None:
        raise InvalidValueError(
            f"{path}: load {said.load:g} {said.load_unit}; machine {machine.name} takes {parameter.name} in "
            f"{parameter.unit}. Give it with --load {path.name}=VALUE."
        )
    try:
        return _with_load(recording, parameter.checked(factor * said.load), parameter)
    except InvalidValueError as problem:
        raise InvalidValueError(f"{path}: {problem} Or give another with --load {path.name}=VALUE.") from None


def _with_load(recording: Recording, load: float, parameter: Parameter) -> Recording:
    condition = replace(recording.condition, load=load, load_unit=parameter.unit)
    return replace(recording, condition=condition)


def _plain(unit: str) -> str:
    return unit.replace("*", ".").replace("·", ".").replace(" ", "").replace(".", "").casefold()


def _check_left(sources: Sources, kept: Mapping[Path, object], unreadable: Sequence[str]) -> None:
    if not any(path in kept for path in sources.recordings):
        raise UnfitRecordingError(f"No recording can be used; allowed: one or more. {' '.join(unreadable[:3])}")
    if sources.baseline and not any(path in kept for path in sources.baseline):
        # Without them the answer would be another one, and nobody would know.
        names = {path.name for path in sources.baseline}
        own = [text for text in unreadable if any(name in text for name in names)]
        raise UnfitRecordingError(
            f"None of the {len(names)} recordings of the healthy machine can be used; allowed: one or more, or none "
            f"named at all. {' '.join(own[-2:])} Mend them, or take them away."
        )


def _channels_of(kept: Mapping[Path, tuple[Recording, Matched]], shared: Sequence[str]) -> dict[str, str]:
    """Return the channel of each shared probe, as the first recording calls it."""
    first, matched = next(iter(kept.values()))
    return {name: first.channels[i].name for i, name in matched.probes.items() if name in shared}


def _shared(sources: Sources, kept: Mapping[Path, tuple[Recording, Matched]], names: Sequence[str]) -> tuple[str, ...]:
    """Return the probes that all recordings have, in the machine's order."""
    own = {path: set(matched.probes.values()) for path, (_, matched) in kept.items()}

    def in_all(paths: Collection[Path]) -> list[str]:
        return [name for name in names if all(name in own[path] for path in paths)]

    shared = in_all(own)
    if shared:
        return tuple(shared)
    measured, healthy = (
        in_all([path for path in paths if path in own]) for paths in (sources.recordings, sources.baseline)
    )
    if measured and healthy and sources.baseline:
        raise InvalidValueError(not_shared(measured, healthy))
    words = "; ".join(f"{path.name}: {', '.join(m.probes.values())}" for path, (_, m) in list(kept.items())[:6])
    raise InvalidValueError(
        f"The recordings have no probe in common ({words}); allowed: one or more. Leave files out, or say which "
        "channel is which with --probe."
    )


def _prepared(recording: Recording, matched: Matched, shared: Sequence[str]) -> Recording:
    chosen = replace(matched, probes={i: name for i, name in matched.probes.items() if name in shared})
    return replace(as_probes(recording, chosen), label=None)


def _name(sources: Sources) -> str:
    folders = list(dict.fromkeys(path.resolve().parent.name for path in sources.recordings))
    return folders[0] if len(folders) == 1 else sources.recordings[0].name


def _notes(
    sources: Sources,
    kept: Mapping[Path, tuple[Recording, Matched]],
    shared: Sequence[str],
    machine: Machine,
    unreadable: Sequence[str],
) -> list[str]:
    notes = [f"{path.name}: no format that a reader knows; left out." for path in sources.left_out]
    for paths, what in ((sources.recordings, "recordings"), (sources.baseline, "recordings of the healthy machine")):
        unused = [path.name for path in paths if path not in kept]
        if unused:
            more = ", ..." if len(unused) > 6 else ""
            why = next((f" {text}" for name in unused for text in unreadable if name in text), "")
            notes.append(f"{len(unused)} of {len(paths)} {what} cannot be used: {', '.join(unused[:6])}{more}.{why}")
    left: dict[tuple[str, str], int] = {}
    for recording, matched in kept.values():
        reasons = {name: why for name, why in matched.left.items()}
        reasons |= {name: NOT_IN_ALL for name in matched.probes.values() if name not in shared}
        for item in reasons.items():
            left[item] = left.get(item, 0) + 1
        total = recording.provenance.total_samples
        if total is not None and total > recording.samples:
            notes.append(
                f"{Path(recording.provenance.path or '').name}: the first {recording.duration_s:.4g} s are looked at."
            )
    notes += [f"Channel {name} is not compared: {why}{_times(n, len(kept))}." for (name, why), n in left.items()]
    parameter = load_parameter(machine)
    silent = [path.name for path, (recording, _) in kept.items() if recording.condition.load is None]
    if parameter is not None and silent and parameter.name not in machine.changed:
        notes.append(
            f"Load not known in {len(silent)} of {len(kept)} recordings: the machine's own "
            f"{machine.values[parameter.name]:g} {parameter.unit} is taken (--load says it)."
        )
    notes += _turned(kept, machine)
    unpaced = [path.name for path, (recording, _) in kept.items() if not _is_phased(recording)]
    if unpaced:
        notes.append(
            f"No tacho with one pulse a turn in {len(unpaced)} of {len(kept)} recordings ({', '.join(unpaced[:3])}"
            f"{', ...' if len(unpaced) > 3 else ''}): phases there do not refer to the shaft."
        )
    return notes


def _turned(kept: Mapping[Path, tuple[Recording, Matched]], machine: Machine) -> list[str]:
    """Return notes on channels that the recordings say point elsewhere than their probes do."""
    ways = {probe.name: probe.direction for probe in machine.bare_assembly().probes}
    found = {}
    for recording, matched in kept.values():
        for i, name in matched.probes.items():
            one = recording.channels[i]
            said = SAME_WAY.get(one.direction or "", one.direction)
            if said in ("x", "y", "axial") and ways[name] in ("x", "y", "axial") and said != ways[name]:
                found[one.name, name] = f"{one.direction}, and probe {name} along {ways[name]}"
    return [f"Channel {own} is {words}. Check --probe." for (own, _), words in found.items()]


def _is_phased(recording: Recording) -> bool:
    return recording.pulses_per_revolution == 1 and has_pulses(recording)


def has_pulses(recording: Recording) -> bool:
    """Return whether a tacho channel shows pulses."""
    how = {"rate_hz": recording.rate_hz, "pulses_per_revolution": recording.pulses_per_revolution}
    pairs = zip(recording.signals, recording.channels, strict=True)
    return any(one.quantity == "tacho" and speed_from_tacho(signal, **how) is not None for signal, one in pairs)


def _times(count: int, whole: int) -> str:
    return "" if count == whole else f" ({count} of {whole} recordings)"

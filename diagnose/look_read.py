"""Reading the file, or the part of it, that ``rotorwise orders``, ``envelope`` and ``sidebands`` look at."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..simulators.errors import InvalidValueError
from .look_options import Request
from .memory import MemoryNeed, available_bytes, check_fits

if TYPE_CHECKING:
    from ..datasets.recording import Recording

LEAST_SAMPLES = 256
_MOST_A_BYTE = 200  # bytes of memory for a byte of a file, with room for what compresses well


def read_part(request: Request, need: MemoryNeed | None) -> Recording:
    """Return the file or its part; what would fill the memory is refused before it does, where its length is known."""
    from ..datasets.reading import read

    options: dict[str, Any] = {"metadata": request.metadata, "sidecar": request.sidecar}
    first, last = 0, None
    if request.is_part or (need is not None and _may_be_too_large(request.file)):
        head = read(request.file, start=0, stop=LEAST_SAMPLES, **options)
        total = head.provenance.total_samples
        first = round(request.start_s * head.rate_hz)
        last = None if request.stop_s is None else round(request.stop_s * head.rate_hz)
        if need is not None and total is not None:
            samples = max(min(last or total, total) - first, 0)
            check_fits(need, samples=samples, channels=_vibrations(head), rate_hz=head.rate_hz)
    recording = read(request.file, start=first, stop=last, **options)
    if request.is_part and recording.samples < LEAST_SAMPLES:
        raise InvalidValueError(
            f"Part of {recording.samples} samples; allowed: {LEAST_SAMPLES} or more. Give an earlier --start, within "
            "the record, or a later --stop."
        )
    if need is not None:
        held, channels = float(recording.signals.nbytes), _vibrations(recording)
        check_fits(need, samples=recording.samples, channels=channels, rate_hz=recording.rate_hz, held_bytes=held)
    return recording


def _may_be_too_large(file: Path) -> bool:
    """Return whether a file that is well compressed could hold too much; most files need no second look."""
    available = available_bytes()
    return available is not None and file.is_file() and file.stat().st_size * _MOST_A_BYTE > available


def _vibrations(recording: Recording) -> int:
    return max(sum(channel.is_vibration for channel in recording.channels), 1)


def part_words(request: Request, recording: Recording) -> list[str]:
    """Say which part it is; times in answers and pages count from its beginning."""
    if not request.is_part:
        return []
    first = recording.provenance.start_sample / recording.rate_hz
    words = f"Only the part from {first:.4g} to {first + recording.duration_s:.4g} s was looked at; times begin there."
    return [words]

"""Whether a record fits into memory, said before it is filled: a machine that swaps answers nobody."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..simulators.errors import InvalidValueError

_MEMINFO = Path("/proc/meminfo")
#: Limit and use of a container, of both kinds of control groups.
_GROUPS = (
    ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
    ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
)
ADVICE = "Take a part with --start and --stop (in s), or leave channels out with --skip."


@dataclass(frozen=True)
class MemoryNeed:
    """What a command takes at its peak, in bytes: whatever the record, for each sample, for each sample and channel."""

    always: float
    a_sample: float
    a_value: float

    def of(self, samples: int, channels: int) -> float:
        """Return the bytes for a record of so many samples in each channel."""
        return self.always + samples * (self.a_sample + self.a_value * channels)

    def samples_within(self, available: float, channels: int) -> int:
        """Return how many samples fit."""
        return max(int((available - self.always) / (self.a_sample + self.a_value * channels)), 0)


def available_bytes() -> float | None:
    """Return the memory that can be had without swapping, limits of a container included; None where nothing says."""
    found = [
        float(words[1]) * 1024
        for words in (line.split() for line in _text(_MEMINFO).splitlines())
        if words and words[0] == "MemAvailable:"
    ]
    for limit, used in _GROUPS:
        values = _text(Path(limit)).strip(), _text(Path(used)).strip()
        if all(value.isdigit() for value in values):
            found.append(max(float(values[0]) - float(values[1]), 0.0))
    return min(found, default=None)


def check_fits(need: MemoryNeed, *, samples: int, channels: int, rate_hz: float, held_bytes: float = 0.0) -> None:
    """Raise InvalidValueError where a record of this size would fill the memory; ``held_bytes`` of it is here already.

    Parameters
    ----------
    need : MemoryNeed
    samples, channels : int
    rate_hz : float
    held_bytes : float
    """
    available = available_bytes()
    if available is None or need.of(samples, channels) - held_bytes <= available:
        return
    fits = need.samples_within(available + held_bytes, channels) / rate_hz
    part = f" {fits:.3g} s fit." if fits > 1 else ""
    raise InvalidValueError(
        f"{samples / rate_hz:.4g} s of {channels} channel{'s' if channels > 1 else ''} need about "
        f"{need.of(samples, channels) / 1e9:.2g} GB of memory; allowed: {(available + held_bytes) / 1e9:.2g} GB, what "
        f"is free.{part} {ADVICE}"
    )


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError):
        return ""

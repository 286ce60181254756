"""WAV and FLAC sound files. Values are fractions of full scale: the sensor's scale is not in the file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import UnreadableFileError
from ..file_content import FileContent

NAME = "WAV or FLAC"
SUFFIXES = (".wav", ".flac")


def recognises(path: Path, head: bytes) -> bool:
    """Whether the file starts as RIFF/RF64 WAVE or FLAC."""
    return (head[:4] in (b"RIFF", b"RF64") and head[8:12] == b"WAVE") or head.startswith(b"fLaC")


def read(path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return samples ``start`` to ``stop``, full scale being 1; no unit, because the file has none.

    Raises
    ------
    UnreadableFileError
        On a file without samples or one that the decoder refuses.
    """
    import soundfile

    with soundfile.SoundFile(str(path)) as sound:
        total = _believable_frames(sound.frames, sound.channels, path)
        rate, subtype, channels = sound.samplerate, sound.subtype, sound.channels
        if total == 0:
            raise UnreadableFileError(f"{path} holds no samples; it was cut off in its header. Copy it again.")
        start = min(start, total)
        stop = total if stop is None else min(stop, total)
        sound.seek(start)
        # 24-bit integers fit a float32 exactly, 32-bit ones do not.
        dtype = "float64" if subtype in ("PCM_32", "DOUBLE") else "float32"
        data = sound.read(stop - start, dtype=dtype, always_2d=True)
    warnings = list(_cut_off_warning(path))
    if data.shape[0] < stop - start:
        warnings.append(f"{path.name} is cut off: {data.shape[0]} of {stop - start} samples could be read.")
    if data.shape[0] == 0 and stop > start:
        raise UnreadableFileError(f"{path}: no sample could be decoded; the file is damaged. Copy it again.")
    names = ("channel",) if channels == 1 else tuple(f"channel[{index}]" for index in range(channels))
    return FileContent(
        signals=np.ascontiguousarray(data.T),
        channel_names=names,
        units=(None,) * channels,
        rate_hz=float(rate),
        total_samples=total,
        start_sample=start,
        warnings=tuple(warnings),
        notes={"encoding": subtype, "scale": "fraction of full scale"},
    )


def _believable_frames(frames: int, channels: int, path: Path) -> int:
    # A damaged header can promise any length; FLAC of pure silence packs some thousands to one, not more.
    if frames * channels > 100_000 * path.stat().st_size:
        raise UnreadableFileError(
            f"{path}: its header promises {frames} samples, far more than the file can hold. Copy it again."
        )
    return frames


def _cut_off_warning(path: Path) -> tuple[str, ...]:
    """Compare the length in a RIFF header with the file's: the decoder itself hides the difference."""
    with path.open("rb") as handle:
        head = handle.read(8)
    promised = int.from_bytes(head[4:8], "little") + 8
    actual = path.stat().st_size
    # 0 and 0xFFFFFFFF mean "length not known" in files written as a stream.
    if head[:4] == b"RIFF" and promised not in (8, 0xFFFFFFFF + 8) and promised > actual:
        return (f"{path.name} is cut off: {actual} of {promised} bytes are there; the samples present are used.",)
    return ()

"""Text files of numbers: CSV and its relatives, with or without header, preamble, time column, gzip.

Plain rows are parsed by NumPy's C parser; rows with missing or odd cells, and dates, go to pandas. Files are
read in chunks of lines, so a file larger than memory can be streamed.
"""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np

from ..errors import UnreadableFileError
from ..file_content import FileContent
from ._names import unique_names
from ._text_columns import Columns, TimeStamps, choose_columns, sampling_rate
from ._text_layout import TextLayout, decode_head, detect_layout
from ._text_rows import Rows, parse_rows

NAME = "CSV or text"
IS_TEXT = True
SUFFIXES = (".csv", ".txt", ".tsv", ".dat", ".asc", ".csv.gz", ".txt.gz")

_GZIP = b"\x1f\x8b"
_HEAD = 65536
_CHUNK_LINES = 200_000
#: A table with fewer rows and neither time column nor rate is no waveform: 0.01 s even at 10 kHz.
_FEWEST_ROWS = 100


@dataclass
class _Parsed:
    """Running state over the chunks of one file."""

    layout: TextLayout
    columns: Columns
    stamps: TimeStamps
    rows: int = 0
    warnings: tuple[str, ...] = ()


def recognises(path: Path, head: bytes) -> bool:
    """Whether it is text (or gzipped text) with rows of numbers, and no other format's text."""
    if head.startswith(_GZIP):
        try:
            head = _head_of(path)
        except (OSError, EOFError, ValueError, zlib.error):
            return False
    if head.lstrip()[:1] in (b"<", b"{") or _is_uff(head):
        return False
    decoded = decode_head(head, complete=len(head) < _HEAD)
    return decoded is not None and detect_layout(*decoded) is not None


def read(path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return samples ``start`` to ``stop``; rows before ``start`` are parsed but not kept.

    Raises
    ------
    UnreadableFileError
        On text that is no waveform: words in columns, a table over speed or frequency, too few rows.
    """
    kept: list[np.ndarray] = []
    last: FileContent | None = None
    state: _Parsed | None = None
    for last, state in _chunks(path, chunk_lines=_CHUNK_LINES, stop=stop):  # noqa: B007
        kept.append(last.signals[:, max(0, start - last.start_sample) :])
    assert last is not None
    assert state is not None
    rate, found = sampling_rate(state.stamps, state.layout)
    total = state.rows if stop is None or state.rows < stop else None
    return replace(
        last,
        signals=np.concatenate(kept, axis=1) if len(kept) > 1 else kept[0],
        rate_hz=rate,
        start_sample=min(start, state.rows),
        total_samples=total,
        warnings=tuple(dict.fromkeys((*state.warnings, *found, *_block_size_warning(state, total)))),
    )


def blocks(path: Path, *, block_samples: int) -> Iterator[FileContent]:
    """Yield the file block by block in bounded memory; the rate comes from the first block's time stamps."""
    rate: float | None = None
    for index, (part, state) in enumerate(_chunks(path, chunk_lines=block_samples, stop=None)):
        found, warnings = sampling_rate(state.stamps, state.layout)
        rate = found if index == 0 else rate
        state.stamps.restart()
        yield replace(part, rate_hz=rate, warnings=tuple(dict.fromkeys((*part.warnings, *warnings))))


def _is_uff(head: bytes) -> bool:
    return head[:200].lstrip().startswith(b"-1") and head[:200].split()[1:2] in (
        [b"58"],
        [b"58b"],
        [b"151"],
        [b"164"],
    )


def _head_of(path: Path) -> bytes:
    with path.open("rb") as raw:
        packed = raw.read(2) == _GZIP
    if not packed:
        with path.open("rb") as raw:
            return raw.read(_HEAD)
    with gzip.open(path, "rb") as handle:
        try:
            return handle.read(_HEAD)
        except EOFError:
            # Cut off early: what comes before the cut is enough to recognise the text.
            handle.seek(0)
            return handle.read1(_HEAD)  # pyright: ignore[reportAttributeAccessIssue]


def _open(path: Path, encoding: str) -> TextIO:
    with path.open("rb") as raw:
        packed = raw.read(2) == _GZIP
    if packed:
        return gzip.open(path, "rt", encoding=encoding, errors="replace")
    return path.open(encoding=encoding, errors="replace")


def _lines(handle: TextIO, skip: int, comment: str | None) -> Iterator[str]:
    for _ in range(skip):
        handle.readline()
    # str.strip keeps exactly the lines that are not blank, at C speed.
    rows = filter(str.strip, handle)
    return rows if comment is None else (line for line in rows if not line.lstrip().startswith(comment))


def _take(lines: Iterator[str], count: int, notes: list[str]) -> list[str]:
    out: list[str] = []
    try:
        for line in islice(lines, count):
            out.append(line)
    except (EOFError, OSError, ValueError, zlib.error) as error:
        notes.append(f"The compressed file is cut off or damaged ({error}); what comes before is used.")
    return out


def _chunks(path: Path, *, chunk_lines: int, stop: int | None) -> Iterator[tuple[FileContent, _Parsed]]:
    head = _head_of(path)
    decoded = decode_head(head, complete=len(head) < _HEAD)
    layout = detect_layout(*decoded) if decoded else None
    if layout is None:
        raise UnreadableFileError(
            f"{path}: text without rows of numbers. Export the waveform itself as columns of numbers."
        )
    _refuse_words(layout, path)
    state: _Parsed | None = None
    with _open(path, layout.encoding) as handle:
        lines = _lines(handle, layout.skip_lines, layout.comment)
        done = False
        pending = _take(lines, chunk_lines, notes := [])
        while not done:
            wanted = chunk_lines if stop is None else min(chunk_lines, stop - (state.rows if state else 0))
            following = _take(lines, chunk_lines, notes) if not notes else []
            done = not following or (stop is not None and wanted < len(pending))
            rows = parse_rows(pending, layout, path, first_row=state.rows if state else 0, is_last=not following)
            if state is None:
                state = _first_chunk(rows, layout, path, whole=not following)
            state.warnings = tuple(dict.fromkeys((*state.warnings, *rows.warnings, *notes)))
            part = _content(rows, state, wanted)
            state.rows += part.samples
            done = done or (stop is not None and state.rows >= stop)
            yield part, state
            pending = following


def _first_chunk(rows: Rows, layout: TextLayout, path: Path, *, whole: bool) -> _Parsed:
    if rows.values.shape[0] == 0:
        raise UnreadableFileError(f"{path}: no complete row of numbers. The file was cut off; export it again.")
    columns, stamps, warnings = choose_columns(rows, layout, path)
    rate, _ = sampling_rate(stamps, layout, peek=rows)
    if whole and rate is None and stamps.column is None and rows.values.shape[0] < _FEWEST_ROWS:
        raise UnreadableFileError(
            f"{path}: a table of {rows.values.shape[0]} rows without time column or sampling rate is not a "
            "waveform. "
            "Give the file with the sampled signal itself."
        )
    return _Parsed(layout, columns, stamps, warnings=warnings)


def _content(rows: Rows, state: _Parsed, wanted: int) -> FileContent:
    values = rows.values[:wanted]
    columns = state.columns
    state.stamps.add(rows)
    return FileContent(
        signals=np.ascontiguousarray(values[:, list(columns.signals)].T),
        channel_names=unique_names(list(columns.names)),
        units=columns.units,
        speed_rpm=columns.speed_rpm,
        label=columns.label,
        start_sample=state.rows,
        warnings=state.warnings,
        notes=columns.notes,
    )


def _refuse_words(layout: TextLayout, path: Path) -> None:
    if not layout.text_columns:
        return
    titles = layout.header or tuple(f"column {index + 1}" for index in range(layout.columns))
    named = ", ".join(titles[index] for index in sorted(layout.text_columns)[:5])
    raise UnreadableFileError(
        f"{path}: columns with words ({named}), so this is a table of results, not a waveform with one "
        "sample a row. "
        "Give the file with the sampled signal, or delete those columns."
    )


def _block_size_warning(state: _Parsed, total: int | None) -> tuple[str, ...]:
    promised = state.columns.promised_rows
    if total is None or promised is None or total >= promised:
        return ()
    return (f"The header promises {promised} samples but {total} are there; the file was cut off.",)

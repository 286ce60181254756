"""How a text file of numbers is laid out: encoding, separator, decimal mark, preamble, header, columns."""

from __future__ import annotations

import codecs
import re
from collections import Counter
from dataclasses import dataclass, field

from ..units import parse_unit
from ._names import number_in, seconds_per

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eEdD][-+]?\d+)?|[-+]?(nan|inf|infinity)", re.IGNORECASE)
_NUMBER_COMMA = re.compile(r"[-+]?(\d+(,\d+)?|,\d+)([eE][-+]?\d+)?|[-+]?(nan|inf|infinity)", re.IGNORECASE)
_STAMP = re.compile(
    r"\d{4}[-/.]\d{1,2}[-/.]\d{1,2}([T ]\d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?(Z|[-+]\d{2}:?\d{2})?)?"
    r"|\d{1,2}[-/.]\d{1,2}[-/.]\d{4} \d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?|\d{1,2}:\d{2}:\d{2}([.,]\d+)?"
)
_MISSING = {"", "null", "none", "na", "n/a", "#n/a", "-", "--"}
_COMMENTS = "#%;"
#: Tried in this order; the first wins a tie, since blanks often surround another separator.
_SEPARATORS = (";", "\t", "|", ",", None)


@dataclass(frozen=True)
class TextLayout:
    """Layout of a text file of numbers; ``separator`` None stands for blanks."""

    encoding: str
    separator: str | None
    decimal: str
    skip_lines: int
    columns: int
    header: tuple[str, ...] | None = None
    units: tuple[str, ...] | None = None
    fields: tuple[tuple[str, str], ...] = ()
    comment: str | None = None
    stamp_columns: frozenset[int] = frozenset()
    text_columns: frozenset[int] = frozenset()
    extra_first_row: tuple[str, ...] = field(default=())

    def split(self, line: str) -> list[str]:
        """Return the cells of a line, without blanks and quotes."""
        return split_cells(line, self.separator)


def decode_head(head: bytes, *, complete: bool) -> tuple[str, str] | None:
    """Return (text, encoding) of a file's beginning, or None when it is not text."""
    encoding = _encoding(head)
    if encoding is None:
        return None
    try:
        text = codecs.getincrementaldecoder(encoding)("strict").decode(head, final=False)
    except UnicodeDecodeError:
        encoding = "latin-1"
        text = head.decode(encoding)
    sample = text[:20000]
    odd = sum(1 for character in sample if ord(character) < 32 and character not in "\t\r\n\f\x1a")
    if odd > 0.002 * len(sample) + 1 or "\x00" in sample:
        return None
    if not complete and "\n" in text:
        text = text[: text.rindex("\n") + 1]
    return text, encoding


def _encoding(head: bytes) -> str | None:
    if head.startswith(codecs.BOM_UTF8):
        return "utf-8-sig"
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    zeros = head[:1000].count(0)
    if zeros == 0:
        return "utf-8"
    even, odd = head[:1000:2].count(0), head[1:1000:2].count(0)
    if zeros > 0.35 * min(len(head), 1000) and min(even, odd) < 0.02 * zeros:
        return "utf-16-le" if odd > even else "utf-16-be"
    return None


def split_cells(line: str, separator: str | None) -> list[str]:
    """Split a line into cells without surrounding blanks and quotes."""
    cells = line.split() if separator is None else line.rstrip("\r\n").split(separator)
    return [cell.strip().strip('"').strip() for cell in cells]


def detect_layout(text: str, encoding: str) -> TextLayout | None:
    """Return the layout of the text that a file begins with; None when it has no rows of numbers."""
    lines = text.splitlines()
    best: tuple[float, tuple[str | None, str], list[int]] | None = None
    body = [(index, line) for index, line in enumerate(lines) if line.strip() and line.lstrip()[0] not in "#%"]
    sample = body[-60:]
    for separator in _SEPARATORS:
        for decimal in (".", ","):
            if decimal == separator:
                continue
            score, widths = _score(sample, separator, decimal)
            if score > (best[0] if best else 0.0):
                best = (score, (separator, decimal), widths)
    if best is None:
        return None
    separator, decimal = best[1]
    if separator == "," and _is_decimal_comma(sample, lines, body):
        separator, decimal = None, ","
    return _layout(lines, body, sample, encoding, separator, decimal)


def _is_number(cell: str, decimal: str) -> bool:
    return (_NUMBER if decimal == "." else _NUMBER_COMMA).fullmatch(cell) is not None


def _score(sample: list[tuple[int, str]], separator: str | None, decimal: str) -> tuple[float, list[int]]:
    """Score a separator by the share of cells that are numbers; rows of equal width and more columns win."""
    numbers = cells_seen = 0
    widths: list[int] = []
    for _, line in sample:
        cells = split_cells(line, separator)
        known = sum(_is_number(cell, decimal) or _STAMP.fullmatch(cell) is not None for cell in cells)
        if known * 2 >= len(cells) and known:
            widths.append(len(cells))
        numbers += known
        cells_seen += sum(1 for cell in cells if cell.casefold() not in _MISSING)
    if not widths or len(widths) < 0.5 * len(sample):
        return 0.0, widths
    width, count = Counter(widths).most_common(1)[0]
    share = numbers / max(1, cells_seen)
    return share * count / len(sample) * (1 + 0.001 * min(width, 100)), widths


def _is_decimal_comma(sample: list[tuple[int, str]], lines: list[str], body: list[tuple[int, str]]) -> bool:
    """Tell one column of ``0,0123`` from two columns of whole numbers: a fraction keeps its leading zeros."""
    rows = [re.fullmatch(r"\s*[-+]?\d+,(\d+)([eE][-+]?\d+)?\s*", line) for _, line in sample]
    fractions = [match.group(1) for match in rows if match]
    if len(fractions) < 0.9 * len(sample):
        return False
    return any(text.startswith("0") and len(text) > 1 for text in fractions) or any(m and m.group(2) for m in rows)


def _layout(
    lines: list[str],
    body: list[tuple[int, str]],
    sample: list[tuple[int, str]],
    encoding: str,
    separator: str | None,
    decimal: str,
) -> TextLayout | None:
    rows = [split_cells(line, separator) for _, line in sample]
    is_row = [2 * sum(_is_known(cell, decimal) for cell in cells) >= len(cells) for cells in rows]
    widths = Counter(len(cells) for cells, good in zip(rows, is_row, strict=True) if good)
    if not widths:
        return None
    width = widths.most_common(1)[0][0]
    typical = [cells for cells, good in zip(rows, is_row, strict=True) if good and len(cells) == width]
    stamps = frozenset(c for c in range(width) if _mostly(typical, c, lambda cell: _STAMP.fullmatch(cell) is not None))
    text = frozenset(
        c for c in range(width) if c not in stamps and _mostly(typical, c, lambda cell: not _is_known(cell, decimal))
    )
    first = _first_row(body, separator, decimal, width, text)
    if first is None:
        return None
    row_cells = split_cells(lines[first], separator)
    header, units, fields = _preamble(lines[:first], separator, width)
    comments = [line.lstrip()[0] for line in lines if line.strip() and line.lstrip()[0] in "#%"]
    return TextLayout(
        encoding=encoding,
        separator=separator,
        decimal=decimal,
        skip_lines=first,
        columns=width,
        header=header,
        units=units,
        fields=fields,
        comment=comments[0] if comments else None,
        stamp_columns=stamps,
        text_columns=text,
        extra_first_row=tuple(row_cells[width:]),
    )


def _is_known(cell: str, decimal: str) -> bool:
    return _is_number(cell, decimal) or _STAMP.fullmatch(cell) is not None or cell.casefold() in _MISSING


def _mostly(rows: list[list[str]], column: int, test) -> bool:
    return 2 * sum(test(row[column]) for row in rows) > len(rows)


def _first_row(
    body: list[tuple[int, str]], separator: str | None, decimal: str, width: int, text: frozenset[int]
) -> int | None:
    """Return the line of the first data row; it may be wider (some exports put offsets there)."""
    for index, line in body:
        cells = split_cells(line, separator)
        known = [
            column
            for column in range(min(width, len(cells)))
            if column not in text and _is_known(cells[column], decimal)
        ]
        has_number = any(_is_number(cell, decimal) for cell in cells)
        if len(cells) >= width and len(known) >= width - len(text) and has_number:
            return index
    return None


def _preamble(
    lines: list[str], separator: str | None, width: int
) -> tuple[tuple[str, ...] | None, tuple[str, ...] | None, tuple[tuple[str, str], ...]]:
    """Take header cells, a row of units and ``key: value`` fields from the lines above the data."""
    remaining = [line.strip("\r\n") for line in lines if line.strip()]
    header = units = None
    while remaining and header is None:
        bare = remaining[-1].lstrip(_COMMENTS + " ") if remaining[-1].lstrip()[:1] in _COMMENTS else remaining[-1]
        cells = split_cells(bare, separator)
        if separator is None and len(cells) != width:
            cells = split_cells(bare, ",")
        if len(cells) < width or (width == 1 and re.search(r"[:=]\s*\S", bare) and "(" not in bare):
            break
        if width > 1 and len(cells) > width and any(cells[width:]):
            break
        cells = cells[:width]
        if units is None and _is_row_of_units(cells, remaining[:-1], separator):
            units = tuple(cells)
        else:
            header = tuple(cells)
        remaining.pop()
    return header, units, tuple(pair for line in remaining if (pair := _field(line, separator)))


def _is_row_of_units(cells: list[str], above: list[str], separator: str | None) -> bool:
    """Whether the cells are units under a row of names; channels may be named ``a`` and ``v`` like units."""
    if not above or not any(cells) or not all(_is_unit(cell) for cell in cells):
        return False
    names = split_cells(above[-1], separator)
    return len(names) >= len(cells) and not any(cell and number_in(cell) is not None for cell in names)


def _is_unit(cell: str) -> bool:
    return cell in ("", "-", "()") or parse_unit(cell) is not None or seconds_per(cell) is not None


def _field(line: str, separator: str | None) -> tuple[str, str] | None:
    bare = line.strip().lstrip(_COMMENTS + " ")
    match = re.fullmatch(r"\"?([^:=\t;,]{1,60}?)\"?\s*[:=]+[\s;,]*(.*)", bare) or re.fullmatch(
        r"\"?([^:=\t;,]{1,60}?)\"?\s*[\t;,]+\s*(.*)", bare
    )
    if match is None:
        return None
    return match.group(1).strip(), match.group(2).strip().strip('";,').strip()

"""Pictures of trial scores as SVG: the confusion matrix, and stated against true probability."""

from __future__ import annotations

from xml.sax.saxutils import escape

from .scores import Scores

_CELL, _TEXT, _MARGIN = 22, 11, 12
#: Answers and truths that are no effect, in the order in which they stand behind the effects.
_LAST = ("nothing", "unknown", "two effects", "cannot tell", "error")
_SIDE = 320


def confusion_svg(scores: Scores, *, title: str) -> str:
    """Return the confusion matrix: a row for what was hidden, a column for what was answered, shares as shades.

    Two effects share a row and a column; a pair lies on the diagonal only when both are rightly named.
    """
    counts: dict[tuple[str, str], int] = {}
    for (truth, answer), count in scores.confusion.items():
        # A wrong pair is no success: it stands beside the diagonal.
        column = "another pair" if "+" in truth and "+" in answer and truth != answer else _group(answer)
        counts[_group(truth), column] = counts.get((_group(truth), column), 0) + count
    rows = _ordered({truth for truth, _ in counts})
    columns = _ordered({answer for _, answer in counts} | set(rows))
    left, top = 7 * max(map(len, (*rows, "hidden"))) + 50, 7 * max(map(len, (*columns, "answer"))) + 34
    width, height = left + _CELL * len(columns) + _MARGIN, top + _CELL * len(rows) + _MARGIN
    parts = [_text(_MARGIN, 18, title, weight="bold")]
    for j, name in enumerate(columns):
        x = left + _CELL * j + _CELL / 2 + 4
        parts.append(f'<text x="{x:.0f}" y="{top - 6}" transform="rotate(-90 {x:.0f} {top - 6})">{escape(name)}</text>')
    for i, truth in enumerate(rows):
        total = sum(counts.get((truth, answer), 0) for answer in columns)
        y = top + _CELL * i
        parts.append(_text(left - 6, y + 15, f"{truth} ({total})", anchor="end"))
        for j, answer in enumerate(columns):
            parts.append(_cell(left + _CELL * j, y, counts.get((truth, answer), 0), total, right=truth == answer))
    return _svg(max(width, 8 * len(title) + 2 * _MARGIN), height, parts)


def _group(name: str) -> str:
    return "two effects" if "+" in name else name


def _ordered(names: set[str]) -> list[str]:
    effects = sorted(name for name in names if name not in (*_LAST, "another pair"))
    return effects + [name for name in (*_LAST, "another pair") if name in names]


def _cell(x: float, y: float, count: int, total: int, *, right: bool) -> str:
    colour = "#2b7a3d" if right else "#b3261e"
    opacity = count / total if total else 0.0
    box = f'<rect x="{x}" y="{y}" width="{_CELL}" height="{_CELL}" fill="{colour}" fill-opacity="{opacity:.2f}"'
    box += ' stroke="#ccc" stroke-width="0.5"/>'
    if not count:
        return box
    ink = "#fff" if opacity > 0.5 else "#222"
    return f'{box}<text x="{x + _CELL / 2}" y="{y + 15}" text-anchor="middle" fill="{ink}">{count}</text>'


def reliability_svg(scores: Scores, *, title: str) -> str:
    """Return the reliability plot: how often the top hypothesis was right, over the probability that it stated.

    A dot's area is the number of trials; on the diagonal, probabilities mean what they say.
    """
    left, top = 52, 40
    right, bottom = left + _SIDE, top + _SIDE
    parts = [_text(_MARGIN, 18, title, weight="bold")]
    parts.append(f'<rect x="{left}" y="{top}" width="{_SIDE}" height="{_SIDE}" fill="none" stroke="#888"/>')
    parts.append(f'<line x1="{left}" y1="{bottom}" x2="{right}" y2="{top}" stroke="#888" stroke-dasharray="4 4"/>')
    for k in range(0, 11, 2):
        at = k / 10 * _SIDE
        parts.append(_text(left + at, bottom + 16, f"{k / 10:g}", anchor="middle"))
        parts.append(_text(left - 6, bottom - at + 4, f"{k / 10:g}", anchor="end"))
    parts.append(_text(left + _SIDE / 2, bottom + 34, "probability stated", anchor="middle"))
    middle = top + _SIDE / 2
    parts.append(
        f'<text x="14" y="{middle}" text-anchor="middle" transform="rotate(-90 14 {middle})">share right</text>'
    )
    most = max((one.count for one in scores.reliability), default=0)
    for one in scores.reliability:
        if one.count:
            x, y, radius = left + one.stated * _SIDE, bottom - one.right * _SIDE, 3 + 9 * (one.count / most) ** 0.5
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="#1f5fa8" fill-opacity="0.7"/>')
            parts.append(_text(x + radius + 2, y + 4, str(one.count)))
    parts.append(_text(left + 8, top + 18, f"calibration error {scores.calibration_error:.3f}"))
    return _svg(max(right + 40, 8 * len(title) + 2 * _MARGIN), bottom + 46, parts)


def _text(x: float, y: float, text: str, *, anchor: str = "start", weight: str = "normal") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-weight="{weight}">{escape(text)}</text>'


def _svg(width: float, height: float, parts: list[str]) -> str:
    size = f'width="{width:.0f}" height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="{_TEXT}" fill="#222">'
    return "\n".join([head, '<rect width="100%" height="100%" fill="#fff"/>', *parts, "</svg>"]) + "\n"

"""A heading, and a label with a text beside it, on the screen."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console


def heading(console: Console, text: str) -> None:
    """Print a heading after an empty line."""
    console.print(f"\n[bold]{text}[/]")


def row(console: Console, label: str, text: str, *, style: str = "") -> None:
    """Print a label, and the text in a column of its own."""
    from rich.markup import escape
    from rich.table import Table

    grid = Table(box=None, show_header=False, padding=(0, 2, 0, 0), show_edge=False)
    grid.add_column(no_wrap=True, min_width=24, style="cyan")
    grid.add_column(ratio=1, style=style or None)
    grid.add_row(label, escape(text))
    console.print(grid)

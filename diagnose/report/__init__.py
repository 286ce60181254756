"""One self-contained HTML page that shows analyses, their evidence and their curves."""

from .page import render_report
from .write import write_report

__all__ = ["render_report", "write_report"]

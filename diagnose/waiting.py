"""A sign of life for work whose length nobody knows."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_QUIET_SECONDS = 2.0


@contextmanager
def waiting(what: str) -> Iterator[None]:
    """Say on stderr what is being done once it has taken two seconds; on a terminal, with the seconds so far."""
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    if not sys.stderr.isatty():
        timer = threading.Timer(_QUIET_SECONDS, lambda: print(f"rotorwise: {what} ...", file=sys.stderr, flush=True))
        bar = None
    else:
        columns = SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn()
        bar = Progress(*columns, console=Console(stderr=True), transient=True)
        bar.add_task(what)
        timer = threading.Timer(_QUIET_SECONDS, bar.start)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        if bar is not None:
            timer.join()
            bar.stop()

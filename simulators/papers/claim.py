"""A claim of a paper and what the simulation says about it."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass

VERDICTS = ("reproduced", "partly", "only with an extra effect", "not reproduced", "cannot be checked")


@dataclass(frozen=True)
class Claim:
    """One checked claim.

    Parameters
    ----------
    paper : str
        "000", "001" or "002".
    place : str
        Figure, table, equation or section.
    says : str
        The claim in our own words, with its numbers.
    as_printed, corrected, with_effect : str
        What we get with the preset ``as_printed``, with ``plausible``, and with which extra effect it appears;
        numbers with units, "" where it does not apply.
    verdict : str
        One of `VERDICTS`.
    """

    paper: str
    place: str
    says: str
    as_printed: str
    corrected: str
    with_effect: str
    verdict: str


def all_claims() -> Iterator[Claim]:
    """Compute every claim, paper by paper: every module here named ``paper_...`` with a function ``claims()``."""
    for name in paper_modules():
        yield from importlib.import_module(f"{__package__}.{name}").claims()


def paper_modules() -> list[str]:
    """Return the names of the modules with claims."""
    package = importlib.import_module(str(__package__))
    return sorted(info.name for info in pkgutil.iter_modules(package.__path__) if info.name.startswith("paper_"))

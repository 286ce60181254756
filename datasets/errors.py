"""Errors about recordings and files."""

from ..simulators.errors import InvalidValueError, RotorwiseError

__all__ = ["InvalidValueError", "MissingMetadataError", "RotorwiseError", "UnreadableFileError"]


class UnreadableFileError(RotorwiseError):
    """A file is missing, truncated, corrupted, empty, or in no format that a reader recognises."""


class MissingMetadataError(RotorwiseError):
    """The file lacks something (a sampling rate, a unit) that rotorwise never guesses."""

"""Errors about recordings and files."""

from ..simulators.errors import InvalidValueError, RotorwiseError

__all__ = ["BuildError", "InvalidValueError", "MissingMetadataError", "RotorwiseError", "UnreadableFileError"]


class UnreadableFileError(RotorwiseError):
    """A file is missing, truncated, corrupted, empty, or in no format that a reader recognises."""


class MissingMetadataError(RotorwiseError):
    """The file lacks something (a sampling rate, a unit) that rotorwise never guesses."""


class BuildError(RotorwiseError):
    """A dataset could not be built to its end; what has been built is whole."""

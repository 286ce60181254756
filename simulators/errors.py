"""The base of every error that rotorwise raises on purpose."""


class RotorwiseError(Exception):
    """Base class. The message says the value received, what is allowed, and what to do.

    The command line prints the message and exits with a documented code; it never shows a traceback
    for this class.
    """


class InvalidValueError(RotorwiseError, ValueError):
    """An argument or a field has a value that is not allowed."""

"""What roadbench refuses: one parent, and under it one kind for each of Python's own that it stands for."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


class Error(Exception):
    """What roadbench refuses, with what to do in its message; the parent of the others."""


class Invalid(Error, ValueError):
    """An argument, or a file that it names, is not what it should be."""


class InvalidType(Error, TypeError):
    """An argument is of a kind that is not taken there."""


class OutputError(Error, OSError):
    """An output cannot be read or written."""


class NoOutput(OutputError, FileNotFoundError):
    """There is no such output folder."""


class NoTable(Error, KeyError):
    """A table that an output or a session does not have."""

    def __str__(self) -> str:
        return str(self.args[0])  # a KeyError would show its repr


class NotInstalled(Error, ImportError):
    """A library that the call needs is not installed; the message says how to install it."""


class Internal(Error, RuntimeError):
    """A mistake of roadbench's own; please report it."""


class Rejected(Error):
    """A log that cannot be used; the batch would write it to the table ``rejected``.

    Attributes:
        stage: where it was refused: ``discover``, ``ingest``, ...
        code: short stable name, e.g. ``truncated``.
        message: for people: what is wrong and what to do.

    Example:
        >>> try:
        ...     roadbench.run_session("broken.parquet", "bike.toml")
        ... except roadbench.Rejected as why:
        ...     print(why.code)
        truncated
    """

    def __init__(self, stage: str, code: str, message: str) -> None:
        super().__init__(stage, code, message)  # all three, so that it can be pickled
        self.stage = stage
        self.code = code
        self.message = message

    def __str__(self) -> str:
        return f"{self.stage}: {self.message} ({self.code})"


def call(function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """Calls the compiled part, whose errors are Python's own: here they become :class:`Error`."""
    try:
        return function(*args, **kwargs)
    except Error:
        raise
    except ValueError as why:
        raise Invalid(str(why)) from None
    except TypeError as why:
        raise InvalidType(str(why)) from None
    except OSError as why:
        raise OutputError(str(why)) from None
    except RuntimeError as why:
        raise Internal(str(why)) from None

"""Errors that a user reads: what happened, where, and what to do about it."""

from __future__ import annotations


class LeafscopeError(Exception):
    """Base of every error that is meant to be shown.

    Parameters
    ----------
    what : str
        One sentence that says what is wrong and where.
    hint : str
        One sentence that says what to do; may be empty.
    """

    exit_code = 1

    def __init__(self, what: str, hint: str = "") -> None:
        super().__init__(what, hint)
        self.what = what
        self.hint = hint

    def __str__(self) -> str:
        return f"{self.what} {self.hint}".strip()


class WrongUse(LeafscopeError):
    """A command, field, model or option that does not exist or does not fit."""

    exit_code = 2


class BadInput(LeafscopeError):
    """A file or table that cannot be used as it is."""

    exit_code = 3


class UnclearLayout(BadInput):
    """A text file whose columns cannot be told; the user can name them.

    Parameters
    ----------
    path : str
        The file.
    """

    def __init__(self, what: str, hint: str, path: str) -> None:
        super().__init__(what, hint)
        self.path = path


class MissingScanner(BadInput):
    """Something needs the scanner's position and the scan has none."""

    def __init__(self, needed_for: str) -> None:
        super().__init__(
            f"The scanner's position is unknown, and {needed_for} needs it.",
            "Give it with --origin X,Y,Z or in the Scans panel.",
        )


class MissingChannel(BadInput):
    """Something needs intensity or a wavelength that the scan does not carry."""


class Cancelled(LeafscopeError):
    """The user asked to stop; nothing was changed."""

    exit_code = 4

    def __init__(self, what: str = "Cancelled.") -> None:
        super().__init__(what)

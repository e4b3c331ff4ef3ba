"""What names or a table say of scans, row by row: those that do not fit do not stop the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from app.core.errors import LeafscopeError
from app.services.series.entries import Entry, Understood

Reader = Callable[[Sequence[Path]], Understood]


@dataclass(frozen=True, slots=True)
class Filled:
    """Entries of files, and why there is none for some.

    Attributes
    ----------
    entries : tuple of Entry or None
        In the order of the files.
    problems : tuple of str
        A sentence where there is no entry, else empty.
    how : str
        How the others were understood.
    """

    entries: tuple[Entry | None, ...]
    problems: tuple[str, ...]
    how: str

    @property
    def bad(self) -> int:
        """How many files have no entry."""
        return sum(bool(problem) for problem in self.problems)


def fill_entries(files: Sequence[Path], read: Reader) -> Filled:
    """Read what files are; where some do not fit, tell which.

    Parameters
    ----------
    files : sequence of Path
    read : callable
        Such as `read_names`, or `match_names` with its pattern; it raises when one does not fit.

    Raises
    ------
    LeafscopeError
        What is read does not fit any of them.
    """
    try:
        understood = read(files)
        return Filled(understood.entries, ("",) * len(files), understood.how)
    except LeafscopeError:
        problems = [_try(file, read) for file in files]
        good = [file for file, problem in zip(files, problems, strict=True) if not problem]
        if not good:
            raise
    # All together once more: hours are counted from the first moment of the series.
    understood = read(good)
    found = iter(understood.entries)
    entries = tuple(None if problem else next(found) for problem in problems)
    return Filled(entries, tuple(problems), understood.how)


def _try(file: Path, read: Reader) -> str:
    """Why one file does not fit; empty where it does."""
    try:
        read([file])
    except LeafscopeError as error:
        return str(error)
    return ""

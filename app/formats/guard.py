"""Turns what a third-party reader throws into one sentence."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.core.errors import BadInput, LeafscopeError

_LONGEST = 200


@contextmanager
def library_errors(path: Path, library: str) -> Iterator[None]:
    """Raise `BadInput` for every failure of `library` on the file `path`.

    lazrs reports a Rust panic as an exception that is no `Exception`, hence the wide net.
    """
    try:
        yield
    except (LeafscopeError, MemoryError, KeyboardInterrupt, SystemExit, GeneratorExit):
        raise
    except BaseException as error:
        raise BadInput(
            f"{path.name} cannot be read: {library} stopped with “{first_line(error)}”.",
            "The file is damaged, or of a kind that Leafscope does not know.",
        ) from error


def first_line(error: BaseException) -> str:
    """What an exception says, cut to one short line without control characters."""
    text = str(error).strip() or type(error).__name__
    return clean(text.splitlines()[0])[:_LONGEST]


def clean(text: str) -> str:
    """Text from a file without control characters, safe to show."""
    return "".join(letter for letter in text if letter.isprintable()).strip()

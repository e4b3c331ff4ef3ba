"""TOML files that come with the program, by name, and reading them like a user's own."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable

from app.core.errors import BadInput


def find_ready(folder: str) -> dict[str, Traversable]:
    """The TOML files of a folder of `resources`, by their names without the ending."""
    found = (files("resources") / folder).iterdir()
    return {f.name.removesuffix(".toml"): f for f in found if f.name.endswith(".toml")}


def read_start(file: Traversable, most: int, what: str) -> bytes:
    """The first `most` bytes of a file, and one more where there is more.

    Raises
    ------
    BadInput
        It cannot be read; `what` says what it was to be.
    """
    try:
        with file.open("rb") as stream:
            return stream.read(most + 1)
    except OSError as error:
        raise BadInput(
            f"The {what} {file.name} cannot be read: {error.strerror or error}.", "Check the path."
        ) from error

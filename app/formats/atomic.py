"""Files appear whole or not at all: write beside, flush to the disk, rename."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.core.errors import BadInput


@contextmanager
def atomic_path(target: Path, overwrite: bool = False) -> Iterator[Path]:
    """Give a temporary path in the folder of `target`; rename it when the block ends well.

    On any failure (cancel included) the temporary file goes and an older file stays as it was.

    Parameters
    ----------
    target : Path
        The file that shall exist afterwards.
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    BadInput
        The target exists and may not be replaced, or its folder cannot be written to.
    """
    refuse_target(target, overwrite)
    temporary = target.with_name(f"{target.name}.tmp-{os.getpid()}")
    try:
        yield temporary
        _flush(temporary)
        os.replace(temporary, target)
        _flush_folder(target.parent)
    except OSError as error:
        raise BadInput(
            f"{target} could not be written: {error.strerror or error}.",
            "Choose another folder or make room on the disk; nothing was changed.",
        ) from error
    finally:
        temporary.unlink(missing_ok=True)


def refuse_target(target: Path, overwrite: bool, folder_follows: bool = False) -> None:
    """Raise `BadInput` where `target` must not or cannot be written; cheap, call it early.

    With `folder_follows` the folder is made later.
    """
    if target.is_dir():
        raise BadInput(f"{target} is a folder.", "Give the name of a file.")
    if target.exists() and not overwrite:
        hint = "Choose another name, or allow it with --overwrite."
        raise BadInput(f"{target} exists already.", hint)
    if not target.parent.is_dir() and not folder_follows:
        raise BadInput(f"The folder {target.parent} does not exist.", "Make it first.")


def _flush(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def _flush_folder(folder: Path) -> None:
    if os.name != "posix":  # Windows cannot open folders
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)

"""Files appear whole or not at all: write beside, flush to the disk, rename."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from app.core.errors import BadInput

Begin = Callable[[Path, bool], Path]


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
    with atomic_files() as begin:
        yield begin(target, overwrite)


@contextmanager
def atomic_files() -> Iterator[Begin]:
    """As `atomic_path` for files that belong together: all of them appear, or none.

    The block calls ``begin(target, overwrite)`` for each file and writes to the path that
    it gets.
    """
    pairs: list[tuple[Path, Path]] = []

    def begin(target: Path, overwrite: bool) -> Path:
        refuse_target(target, overwrite)
        pairs.append((target.with_name(f"{target.name}.tmp-{os.getpid()}"), target))
        return pairs[-1][0]

    try:
        yield begin
        for temporary, _ in pairs:
            _flush(temporary)
        _rename(pairs)
        for folder in {target.parent for _, target in pairs}:
            _flush_folder(folder)
    except OSError as error:
        raise BadInput(
            f"{pairs[0][1] if pairs else 'The file'} could not be written: "
            f"{error.strerror or error}.",
            "Choose another folder or make room on the disk; nothing was changed.",
        ) from error
    finally:
        for temporary, _ in pairs:
            temporary.unlink(missing_ok=True)


def refuse_target(
    target: Path, overwrite: bool, folder_follows: bool = False, sources: Iterable[Path] = ()
) -> None:
    """Raise `BadInput` where `target` must not or cannot be written; cheap, call it early.

    With `folder_follows` the folder is made later. `sources` are files that are read: they are
    never replaced, by whatever path they are named and whatever may be overwritten.
    """
    if target.is_dir():
        raise BadInput(f"{target} is a folder.", "Give the name of a file.")
    if any(is_same_file(target, source) for source in sources):
        raise BadInput(
            f"{target} is what is read: the result would replace the measurements.",
            "Choose another name.",
        )
    if target.exists() and not overwrite:
        hint = "Choose another name, or allow it with --overwrite."
        raise BadInput(f"{target} exists already.", hint)
    folder = target.parent
    if not folder.is_dir() and not folder_follows:
        raise BadInput(f"The folder {folder} does not exist.", "Make it first.")
    if folder.is_dir() and not os.access(folder, os.W_OK):
        raise BadInput(f"You may not write to the folder {folder}.", "Choose another folder.")


def refuse_targets(
    targets: Iterable[Path],
    overwrite: bool,
    sources: Iterable[Path] = (),
    folder_follows: bool = False,
) -> None:
    """As `refuse_target` for files of one command, none of which may be another of them."""
    sources = list(sources)
    taken: list[Path] = []
    for target in targets:
        if any(is_same_file(target, other) for other in taken):
            raise BadInput(f"{target} is named for two results.", "Give each a name of its own.")
        refuse_target(target, overwrite, folder_follows, sources)
        taken.append(target)


def is_same_file(one: Path, other: Path) -> bool:
    """Whether two paths name one file, through links as well."""
    try:
        return one.resolve() == other.resolve() or one.samefile(other)
    except (OSError, RuntimeError):  # one of them is not there, or its links run in a circle
        return False


def _rename(pairs: list[tuple[Path, Path]]) -> None:
    """Put all files in place; where one cannot be, the older ones come back."""
    asides: list[tuple[Path, Path]] = []
    try:
        for temporary, target in pairs:
            if target != pairs[-1][1]:  # after the last one nothing can fail
                asides.append((_set_aside(target), target))
            os.replace(temporary, target)
    except OSError:
        for aside, target in asides:
            _put_back(aside, target)
        raise
    for aside, _ in asides:
        aside.unlink(missing_ok=True)


def _set_aside(target: Path) -> Path:
    """Another name under which an older file, if there is one, can be had back."""
    aside = target.with_name(f"{target.name}.old-{os.getpid()}")
    if target.exists():
        try:
            os.link(target, aside)
        except OSError:  # no hard links on this file system
            os.replace(target, aside)
    return aside


def _put_back(aside: Path, target: Path) -> None:
    if aside.exists():
        os.replace(aside, target)
        aside.unlink(missing_ok=True)  # renaming one link of a file to another does nothing
    else:
        target.unlink(missing_ok=True)


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

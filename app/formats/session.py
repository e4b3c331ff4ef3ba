"""The session file: sources, the log of operations and the view, in one HDF5 file.

Written whole to a new file, read back, then renamed: a crash cannot leave half a session.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from app import __version__
from app.core.arrays import AnyArray
from app.core.errors import BadInput
from app.formats.atomic import atomic_path
from app.model.codec import decode, encode
from app.model.history import Entry
from app.model.operations import AnyOperation
from app.model.scan import Source
from app.model.view_state import ViewState

SUFFIX = ".leafscope"
VERSION = 1
MAGIC = b"\x89HDF\r\n\x1a\n"
MOST_META = 64 * 2**20
CHUNK = 262_144
# Our arrays are stored plain or lzf-packed; claims beyond this, taken together, are a bomb.
MOST_RATIO = 200


class StoredEntry(msgspec.Struct, frozen=True):
    """A line of the log with its operation as JSON text."""

    deed: str
    operation: str | None = None


class Record(msgspec.Struct, frozen=True):
    """The JSON part of a session file."""

    version: int
    written_by: str
    sources: dict[str, Source]
    log: list[StoredEntry]
    view: ViewState


class Session(msgspec.Struct, frozen=True):
    """What a session file holds, ready to be replayed."""

    sources: dict[str, Source]
    log: list[Entry]
    view: ViewState
    written_by: str = f"leafscope {__version__}"


def write(path: Path, session: Session, overwrite: bool = False) -> None:
    """Write a session; a file that is replaced stays as ``NAME.bak``.

    Raises
    ------
    BadInput
        The file exists and `overwrite` is not given, or the disk refuses.
    """
    with atomic_path(path, overwrite) as temporary:
        _store(temporary, session)
        if len(read(temporary).log) != len(session.log):
            raise BadInput(f"{path} was not written completely.", "Try another disk.")
        if path.exists():
            _keep_backup(path)


def read(path: Path) -> Session:
    """Read a session file without trusting it.

    Raises
    ------
    BadInput
        Not a session, damaged, too new, or claiming more than the file can hold.
    """
    _check_magic(path)
    import h5py

    try:
        with h5py.File(path, "r") as file:
            record = _read_record(path, file)
            arrays = _read_arrays(path, file)
    except (OSError, KeyError, RuntimeError) as error:
        raise BadInput(
            f"The session {path} is damaged: {error}.", f"An older copy may be {path}.bak."
        ) from error
    try:
        log = [_revive(entry, arrays) for entry in record.log]
    except (msgspec.MsgspecError, ValueError) as error:
        raise BadInput(f"The session {path} is damaged: {error}.") from error
    return Session(record.sources, log, record.view, record.written_by)


def _store(path: Path, session: Session) -> None:
    import h5py

    arrays: dict[str, AnyArray] = {}
    log = [_freeze(entry, arrays, number) for number, entry in enumerate(session.log)]
    record = Record(VERSION, f"leafscope {__version__}", session.sources, log, session.view)
    text = msgspec.json.encode(record)
    with h5py.File(path, "w", libver=("earliest", "v108"), track_order=True) as file:
        file.create_dataset(
            "meta", data=np.frombuffer(text, np.uint8), track_times=False, **_layout(len(text))
        )
        group = file.create_group("arrays")
        for name, values in arrays.items():
            group.create_dataset(name, data=values, track_times=False, **_layout(values.shape))


def _layout(shape: int | tuple[int, ...]) -> dict[str, Any]:
    shape = (shape,) if isinstance(shape, int) else shape
    if shape[0] == 0:
        return {}
    chunks = (min(shape[0], CHUNK), *shape[1:])
    return {"chunks": chunks, "fletcher32": True, "shuffle": True, "compression": "lzf"}


def _freeze(entry: Entry, arrays: dict[str, AnyArray], number: int) -> StoredEntry:
    if entry.operation is None:
        return StoredEntry(entry.deed)
    return StoredEntry(entry.deed, encode(entry.operation, arrays, f"step{number}").decode())


def _revive(entry: StoredEntry, arrays: Mapping[str, AnyArray]) -> Entry:
    operation: AnyOperation | None = None
    if entry.operation is not None:
        operation = decode(entry.operation, arrays)
    if entry.deed == "do" and operation is not None:
        return Entry("do", operation)
    if entry.deed == "undo":
        return Entry("undo")
    if entry.deed == "redo":
        return Entry("redo")
    raise ValueError(f"unknown line {entry.deed!r} in its log")


def _check_magic(path: Path) -> None:
    try:
        with path.open("rb") as file:
            head = file.read(len(MAGIC))
    except OSError as error:
        raise BadInput(f"{path} cannot be opened: {error.strerror or error}.") from error
    if head != MAGIC:
        raise BadInput(f"{path} is not a Leafscope session.", "Open scans with Open instead.")


def _read_record(path: Path, file: Any) -> Record:
    meta = file.get("meta")
    if getattr(meta, "ndim", None) != 1 or meta.dtype != np.uint8:
        raise BadInput(f"{path} is an HDF5 file, but not a Leafscope session.")
    if meta.shape[0] > MOST_META:
        raise BadInput(f"The description in {path} is too large to be true.")
    text = meta[...].tobytes()
    try:
        version = msgspec.json.decode(text, type=_Version).version
        if version > VERSION:
            raise BadInput(
                f"{path} was written by a newer Leafscope (session format {version}).",
                "Update Leafscope to open it.",
            )
        return msgspec.json.decode(text, type=Record)
    except (msgspec.MsgspecError, RecursionError) as error:
        raise BadInput(f"The session {path} is damaged: {error}.") from error


class _Version(msgspec.Struct):
    version: int


def _read_arrays(path: Path, file: Any) -> dict[str, AnyArray]:
    import h5py

    room = MOST_RATIO * os.path.getsize(path)
    group = file["arrays"]
    if not isinstance(group, h5py.Group):
        raise BadInput(f"{path} is an HDF5 file, but not a Leafscope session.")
    arrays: dict[str, AnyArray] = {}
    for name in group:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise BadInput(f"The session {path} points to another place: {name}.")
        values = group[name]
        if not isinstance(values, h5py.Dataset) or values.dtype.kind not in "iuf":
            raise BadInput(f"The session {path} holds something that is not a number: {name}.")
        if values.external or values.is_virtual:
            raise BadInput(f"The session {path} keeps numbers in another file: {name}.")
        room -= max(values.nbytes, math.prod(values.chunks or ()) * values.dtype.itemsize)
        if room < 0:
            raise BadInput(f"The session {path} claims more numbers than it can hold.")
        arrays[name] = values[...]
    return arrays


def _keep_backup(path: Path) -> None:
    backup = path.with_name(path.name + ".bak")
    backup.unlink(missing_ok=True)
    try:
        os.link(path, backup)
    except OSError:  # no hard links on this file system
        backup.write_bytes(path.read_bytes())

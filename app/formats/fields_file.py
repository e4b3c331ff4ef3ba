"""Columns that a format has no place for: ``NAME.ext.fields.npz`` beside the data file.

One array per column, one row per point in the order of the data file, not compressed and
without pickle: ``numpy.load`` reads it. The sidecar holds its size and hash; a file that
the sidecar does not vouch for is ignored with a warning.
"""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from app.core.arrays import AnyArray
from app.core.errors import BadInput
from app.core.progress import Progress
from app.formats.binary_rows import read_rows
from app.formats.column_names import give_file_names
from app.formats.guard import library_errors
from app.formats.npz import clean_name, write_arrays
from app.formats.sidecar import TYPES, FieldsFile, hash_file

ENDING = ".fields.npz"


def fields_path(path: Path) -> Path:
    """Where the columns of a data file lie that it cannot hold itself."""
    return path.with_name(path.name + ENDING)


def write_fields(path: Path, columns: Mapping[str, AnyArray], progress: Progress) -> FieldsFile:
    """Write columns to `path`; give what the sidecar has to know of the file.

    Raises
    ------
    BadInput
        A column holds neither numbers nor booleans.
    """
    names = give_file_names(columns, taken=(), clean=clean_name)
    arrays = {names[name]: _to_little_endian(name, v) for name, v in columns.items()}
    write_arrays(path, arrays, progress)
    back = {stored: name for name, stored in names.items()}
    return FieldsFile(path.stat().st_size, hash_file(path), back)


def find_fields(
    path: Path, mark: FieldsFile | None, points: int, every_nth: int, progress: Progress
) -> tuple[dict[str, AnyArray] | None, tuple[str, ...]]:
    """Columns beside the data file `path`, and warnings.

    Parameters
    ----------
    path : Path
    mark : FieldsFile or None
        What the sidecar says about them.
    points : int
        Points that were read: each n-th row of the columns must be as many.
    every_nth : int

    Returns
    -------
    dict of str to (points,) arrays, or None
        Empty where the data file has no columns; None where they are missing, damaged or
        not those that the sidecar vouches for.
    """
    place = fields_path(path)
    if mark is None and place.is_file():
        return None, (f"{place.name} is not vouched for by a sidecar. It is ignored.",)
    if mark is None:
        return {}, ()
    try:
        with library_errors(place, "its reader"):
            return _read(place, mark, points, every_nth, progress), ()
    except BadInput as error:
        return None, (f"{error.what} Only what {path.name} itself holds was read.",)


def _to_little_endian(name: str, values: AnyArray) -> AnyArray:
    wanted = values.dtype.newbyteorder("<")
    if wanted.str not in TYPES:
        raise BadInput(f"{name} holds {values.dtype}, which is no number.")
    return values.astype(wanted, copy=False)


def _read(
    place: Path, mark: FieldsFile, points: int, every_nth: int, progress: Progress
) -> dict[str, AnyArray]:
    if not place.is_file():
        raise BadInput(f"{place.name} is missing.")
    if place.stat().st_size != mark.size:
        raise BadInput(f"{place.name} has changed since it was written.")
    columns: dict[str, AnyArray] = {}
    with place.open("rb") as file:
        if hashlib.file_digest(file, "sha256").hexdigest() != mark.sha256:
            raise BadInput(f"{place.name} has changed since it was written.")
        with zipfile.ZipFile(file) as archive:
            entries = archive.infolist()
            # Entries may claim the same bytes again and again.
            if sum(entry.file_size for entry in entries) > mark.size:
                raise BadInput(f"{place.name} claims more than it can hold.")
            for entry in entries:
                values = _read_array(archive, entry, every_nth, progress.part(1.0, 1.0))
                if len(values) != points:
                    raise BadInput(f"{place.name} has {len(values)} rows for {points} points.")
                stored = entry.filename.removesuffix(".npy")
                columns[mark.names.get(stored, stored)] = values
    return columns


def _read_array(
    archive: zipfile.ZipFile, entry: zipfile.ZipInfo, every_nth: int, progress: Progress
) -> AnyArray:
    """One column; what it claims is held against the size of its entry before it is made."""
    if entry.compress_type != zipfile.ZIP_STORED:
        raise BadInput(f"{entry.filename} is compressed, which our files never are.")
    with archive.open(entry) as file:
        if np.lib.format.read_magic(file) != (2, 0):
            raise BadInput(f"{entry.filename} is no array of ours.")
        shape, _, dtype = np.lib.format.read_array_header_2_0(file)
        room = entry.file_size - file.tell()
        if len(shape) != 1 or dtype.str not in TYPES or shape[0] * dtype.itemsize != room:
            raise BadInput(f"{entry.filename} is no column of numbers.")
        values, found = read_rows(file, dtype, shape[0], every_nth, progress)
        file.read(1)  # the checksum is looked at when the end is reached
    if found != shape[0]:
        raise BadInput(f"{entry.filename} ends early.")
    return values

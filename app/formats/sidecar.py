"""What a format has no place for: a JSON file beside the data file.

``NAME.ext.leafscope.json`` holds pose, size of the grid, channels, units, types and
provenance, and the size and hash of the file that it belongs to: after a change of
that file it is ignored with a warning. It also vouches for the columns in
``NAME.ext.fields.npz`` (`fields_file`), where the format has no place for them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec
import numpy as np

from app.core.arrays import AnyArray, Ints
from app.core.errors import BadInput
from app.formats.cloud import Cloud
from app.model.scan import Channel, Grid, Pose, Scan

ENDING = ".leafscope.json"
VERSION = 1
LARGEST = 64 << 20
MOST_CELLS = 1 << 27
_LONGEST_FACT = 1 << 16  # characters
# Facts of a scan that are true of the file that it was read from, not of its points.
_OF_THE_FILE = frozenset(
    {"format", "software", "guid", "las_scale", "las_offset", "comments", "intensityMinimum",
     "intensityMaximum", "beams without echo", "separator", "header_lines", "columns"}
)  # fmt: skip
_LONGEST_TO_INDENT = 1 << 18  # lonely beams without echo would take four times the space
TYPES = frozenset(np.dtype(item).str for item in "?bBhHiIqQefd")


@dataclass(frozen=True, slots=True)
class GridSize:
    """A grid without its points; `no_return` holds runs of (first cell, cells)."""

    rows: int
    columns: int
    no_return: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, slots=True)
class FieldsFile:
    """The file of columns beside the data; `names` of columns go by their names in it."""

    size: int
    sha256: str
    names: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Sidecar:
    """Content of a sidecar file.

    Attributes
    ----------
    version : int
    size, sha256 :
        Of the data file.
    pose, grid, channels : as in `Scan`
    units : mapping of str to str
        By the name of a field or attribute.
    types : mapping of str to str
        numpy's name of the type that a text file cannot hold, e.g. ``<f4``.
    provenance : mapping of str to object
    fields : FieldsFile or None
        Where the columns are, when the data file cannot hold them.
    metadata : mapping of str to str
        Facts of the points: instrument, what the numbers of an attribute mean.
    """

    version: int
    size: int
    sha256: str
    pose: Pose | None = None
    grid: GridSize | None = None
    channels: tuple[Channel, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    types: Mapping[str, str] = field(default_factory=dict)
    provenance: Mapping[str, object] = field(default_factory=dict)
    fields: FieldsFile | None = None
    metadata: Mapping[str, str] = field(default_factory=dict)


def sidecar_path(path: Path) -> Path:
    """Where the sidecar of a data file lies."""
    return path.with_name(path.name + ENDING)


def write_sidecar(path: Path, data: Path, cloud: Cloud, fields: FieldsFile | None = None) -> None:
    """Write to `path` the sidecar of the file `data`, which is complete."""
    content = describe_cloud(cloud, size=data.stat().st_size, sha256=hash_file(data))
    path.write_bytes(encode_json(replace(content, fields=fields)))


def encode_json(content: object) -> bytes:
    """JSON of plain values, dataclasses and numpy numbers, indented for readers if it is short."""
    text = msgspec.json.encode(content, enc_hook=_encode_numpy)
    return text if len(text) > _LONGEST_TO_INDENT else msgspec.json.format(text)


def describe_cloud(cloud: Cloud, size: int = 0, sha256: str = "") -> Sidecar:
    """All of a cloud that is no column of numbers."""
    scan = cloud.scan
    return Sidecar(
        version=VERSION,
        size=size,
        sha256=sha256,
        pose=scan.pose,
        grid=None if scan.grid is None else _describe_grid(scan.grid),
        channels=scan.channels,
        units=cloud.units,
        types={name: values.dtype.str for name, values in cloud.columns.items()},
        provenance=cloud.provenance,
        metadata=_keep_facts(scan.metadata),
    )


def read_sidecar(path: Path) -> Sidecar | None:
    """The sidecar of a data file; None where there is none.

    Raises
    ------
    BadInput
        It is damaged, or the data file has changed since it was written.
    """
    place = sidecar_path(path)
    if not place.is_file():
        return None
    if place.stat().st_size > LARGEST:
        raise BadInput(f"{place.name} is larger than {LARGEST >> 20} MB.")
    try:
        sidecar = msgspec.json.decode(place.read_bytes(), type=Sidecar)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise BadInput(f"{place.name} is damaged: {error}.") from error
    if sidecar.version != VERSION:
        raise BadInput(f"{place.name} has version {sidecar.version}, not {VERSION}.")
    if sidecar.size != path.stat().st_size or sidecar.sha256 != hash_file(path):
        raise BadInput(f"{path.name} has changed since {place.name} was written.")
    return sidecar


def find_sidecar(path: Path) -> tuple[Sidecar | None, tuple[str, ...]]:
    """As `read_sidecar`, with a warning in place of the error."""
    try:
        return read_sidecar(path), ()
    except BadInput as error:
        return None, (f"{error.what} It is ignored.",)


def restore_sidecar(path: Path, scan: Scan) -> Scan:
    """The scan that was read from `path`, with what its sidecar knows."""
    sidecar, warnings = find_sidecar(path)
    if sidecar is not None:
        return apply_sidecar(scan, sidecar)
    return replace(scan, warnings=scan.warnings + warnings)


def apply_sidecar(scan: Scan, sidecar: Sidecar) -> Scan:
    """The scan with pose, grid, channels, units, types and facts of the sidecar.

    The columns ``row`` and ``column`` become the grid where the sidecar gives its size
    and all of them lie inside it. A grid that the file holds itself learns which of its
    empty cells were beams without echo.
    """
    attributes = {
        name: _cast(values, sidecar.types.get(name)) for name, values in scan.attributes.items()
    }
    grid, warnings = scan.grid, scan.warnings
    if sidecar.grid is not None and grid is not None:
        found, warning = _restore_grid(sidecar.grid, grid.row, grid.column)
        grid, warnings = found or grid, warnings + warning
    elif sidecar.grid is not None and {"row", "column"} <= set(attributes):
        grid, warning = _restore_grid(sidecar.grid, attributes["row"], attributes["column"])
        warnings += warning
        if grid is not None:
            del attributes["row"], attributes["column"]
    channels = tuple(c for c in sidecar.channels if c.attribute in attributes)
    units = {f"unit of {name}": unit for name, unit in sidecar.units.items()}
    return replace(
        scan,
        attributes=attributes,
        pose=sidecar.pose or scan.pose,
        grid=grid,
        channels=channels or scan.channels,
        metadata={**sidecar.metadata, **scan.metadata, **units},
        warnings=warnings,
    )


def hash_file(path: Path) -> str:
    """SHA-256 of a file, as hexadecimal text."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _keep_facts(metadata: Mapping[str, str]) -> dict[str, str]:
    return {
        key: value
        for key, value in metadata.items()
        if key not in _OF_THE_FILE and len(value) <= _LONGEST_FACT
    }


def _describe_grid(grid: Grid) -> GridSize:
    cells = np.unique(grid.no_return)
    firsts = np.flatnonzero(np.diff(cells, prepend=-2) != 1)
    lengths = np.diff(firsts, append=len(cells))
    runs = zip(cells[firsts].tolist(), lengths.tolist(), strict=True)
    return GridSize(grid.rows, grid.columns, tuple(runs))


def _restore_grid(
    size: GridSize, row: AnyArray, column: AnyArray
) -> tuple[Grid | None, tuple[str, ...]]:
    inside = size.rows > 0 and size.columns > 0 and size.rows * size.columns <= MOST_CELLS
    for cells, count in ((row, size.rows), (column, size.columns)):
        inside = inside and bool(
            np.all((cells >= 0) & (cells < count) & (np.floor(cells) == cells))
        )
    if not inside:
        return None, ("Rows or columns lie outside the grid; it is ignored.",)
    empty = _expand_runs(size)
    if empty is None:
        return None, ("The cells without echo lie outside the grid; it is ignored.",)
    return Grid(size.rows, size.columns, row.astype(np.int32), column.astype(np.int32), empty), ()


def _expand_runs(size: GridSize) -> Ints | None:
    end = 0
    for first, length in size.no_return:
        if first < end or length < 1:
            return None
        end = first + length
    # Runs of one small file can claim any number of cells: bound them before making them.
    if end > size.rows * size.columns or end > MOST_CELLS:
        return None
    parts = [np.arange(first, first + length) for first, length in size.no_return]
    return np.concatenate(parts) if parts else np.empty(0, np.int64)


def _cast(values: AnyArray, type_name: str | None) -> AnyArray:
    """Values in the type they had, where no value changes by it (NaN stays as it is)."""
    if type_name not in TYPES or type_name == values.dtype.str:
        return values
    wanted = np.dtype(type_name)
    with np.errstate(invalid="ignore", over="ignore"):
        cast = values.astype(wanted)
        unchanged = wanted.kind == "f" or np.array_equal(cast.astype(values.dtype), values)
    return cast if unchanged else values


def _encode_numpy(value: object) -> object:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, Path):
        return str(value)
    raise NotImplementedError(f"JSON has no place for {type(value).__name__}")

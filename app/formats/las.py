"""LAS and LAZ 1.0 to 1.4, COPC as LAZ: records in chunks, extra bytes in their own type."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.progress import Progress
from app.formats.channels import recognise_channels
from app.formats.guard import library_errors
from app.formats.header import Header
from app.formats.las_preflight import Layout, describe, parse_names, read_layout
from app.formats.las_rescue import rescue_records
from app.formats.las_waveforms import describe_waveforms, find_waveforms
from app.formats.las_write import write
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.sidecar import restore_sidecar
from app.model.scan import Scan

__all__ = ["NAME", "SUFFIXES", "matches", "preflight", "read", "write"]

NAME = "LAS"
SUFFIXES = (".las", ".laz")
_CHUNK = 500_000  # records
_LARGEST_CHUNK = 1 << 26  # bytes of a compressed chunk that lazrs may unpack at once
Decode = Callable[[bytearray], object]


def matches(head: bytes, path: Path) -> bool:  # noqa: ARG001 (the magic decides)
    """Whether the file begins with ``LASF``."""
    return head[:4] == b"LASF"


def preflight(path: Path, options: ReadOptions = DEFAULTS) -> Header:
    """Check the header against the size of the file; see `read_layout` for the errors."""
    return describe(read_layout(path, options.recover))


def read(path: Path, options: ReadOptions, progress: Progress) -> list[Scan]:
    """Read all points.

    Raises
    ------
    BadInput
        As `preflight`, and when the compressed points are damaged.
    """
    layout = read_layout(path, options.recover)
    table = _Table(layout, options.every_nth)
    with library_errors(path, "the LAS reader"), path.open("rb") as file:
        for records in _read_chunks(file, layout):
            table.take(records)
            progress.report(table.seen / layout.points, "Reading points")
    return [restore_sidecar(path, _make_scan(path, layout, table))]


@dataclass(frozen=True, slots=True)
class _Column:
    """How one attribute comes out of a record."""

    name: str
    field: str
    item: int | None = None
    scale: float | None = None
    offset: float = 0.0
    boolean: bool = False

    def take(self, records: AnyArray, point_format: int) -> AnyArray:
        """The values of the attribute, (n,) in their final type."""
        from laspy import PointFormat
        from laspy.point.record import PackedPointRecord

        values = np.asarray(PackedPointRecord(records, PointFormat(point_format))[self.field])
        if self.item is not None:
            values = values[:, self.item]
        if self.scale is not None:
            values = values * self.scale + self.offset
        return values.astype(bool) if self.boolean else values


class _Table:
    """Columns that fill up chunk by chunk; keeps each n-th record."""

    def __init__(self, layout: Layout, every_nth: int) -> None:
        self._layout = layout
        self._nth = every_nth
        self._columns = _list_columns(layout)
        self._rows = -(-layout.points // every_nth)
        self._xyz = np.empty((self._rows, 3))
        self._values: dict[str, AnyArray] = {}
        self._filled = 0
        self.seen = 0
        self._store(np.empty(0, make_record_type(layout)))

    def take(self, records: AnyArray) -> None:
        """Add a chunk of records."""
        first = -self.seen % self._nth
        self.seen += len(records)
        self._store(records[first :: self._nth])

    @property
    def xyz(self) -> Floats:
        """Coordinates of what was read, (n, 3)."""
        return self._xyz[: self._filled]

    @property
    def values(self) -> dict[str, AnyArray]:
        """All other columns."""
        return {name: values[: self._filled] for name, values in self._values.items()}

    def _store(self, records: AnyArray) -> None:
        rows = slice(self._filled, self._filled + len(records))
        for axis, key in enumerate("XYZ"):
            scale, offset = self._layout.scales[axis], self._layout.offsets[axis]
            self._xyz[rows, axis] = records[key] * scale + offset
        for column in self._columns:
            values = column.take(records, self._layout.point_format)
            if column.name not in self._values:
                self._values[column.name] = np.empty(self._rows, values.dtype)
            self._values[column.name][rows] = values
        self._filled = rows.stop


def make_record_type(layout: Layout) -> np.dtype[np.void]:
    """The numpy type of one record; extra fields are named by their place."""
    from laspy import PointFormat

    standard = PointFormat(layout.point_format).dtype().descr
    extra = [(f"extra {i}", f.type, (f.count,)) for i, f in enumerate(layout.extra)]
    known = np.dtype([*standard, *extra])
    return np.dtype([*known.descr, ("rest", f"V{layout.record_bytes - known.itemsize}")])


def _list_columns(layout: Layout) -> list[_Column]:
    """Attributes in file order; a file of ours says which of them it needs, and their names."""
    from laspy import PointFormat

    names = [n for n in PointFormat(layout.point_format).dimension_names if n not in "XYZ"]
    columns = [_Column(name, name) for name in names]
    for i, field in enumerate(layout.extra):
        for item, name in enumerate(field.columns):
            scaling = (field.scale[item], field.offset[item]) if field.scale else (None, 0.0)
            columns.append(_Column(_free_name(name, columns), f"extra {i}", item, *scaling))
    notes = parse_names(layout)
    if not notes:
        return columns
    return [
        _Column(
            str(notes[c.name].get("name", c.name)),
            *(c.field, c.item, c.scale, c.offset),
            boolean=notes[c.name].get("type") == "bool",
        )
        for c in columns
        if c.name in notes
    ]


def _free_name(name: str, columns: list[_Column]) -> str:
    taken = {column.name for column in columns}
    while name in taken:
        name += "_2"
    return name


def _read_chunks(file: BinaryIO, layout: Layout) -> Iterator[AnyArray]:
    if layout.points == 0:
        return
    file.seek(layout.offset)
    record_type = make_record_type(layout)
    if layout.shortfall and layout.compressed:
        for block in rescue_records(file, layout):
            yield np.frombuffer(block, record_type)
        return
    decode = _unpack(file, layout) if layout.compressed else _fill(file)
    for start in range(0, layout.points, _CHUNK):
        buffer = bytearray(min(_CHUNK, layout.points - start) * layout.record_bytes)
        decode(buffer)
        yield np.frombuffer(buffer, record_type)


def _fill(file: BinaryIO) -> Decode:
    def fill(buffer: bytearray) -> None:
        if file.readinto(buffer) < len(buffer):  # type: ignore[attr-defined]
            raise EOFError("the file became shorter while it was read")

    return fill


def _unpack(file: BinaryIO, layout: Layout) -> Decode:
    import lazrs

    packing = layout.compression
    assert packing is not None  # noqa: S101 (for mypy: `read_layout` refused)
    small = packing.varies or packing.chunk * layout.record_bytes <= _LARGEST_CHUNK
    if packing.compressor != 1 and small:
        parallel = lazrs.ParLasZipDecompressor(file, packing.raw)
        return parallel.decompress_many  # type: ignore[no-any-return]
    return _unpack_in_sequence(file, layout)


def _unpack_in_sequence(file: BinaryIO, layout: Layout) -> Decode:
    import lazrs

    packing = layout.compression
    assert packing is not None  # noqa: S101 (for mypy: `read_layout` refused)
    raw = packing.raw
    if packing.compressor == 1:
        # LASzip 1.x wrote one chunk without a table; lazrs reads it when told its length.
        raw = raw[:12] + min(layout.points, 0xFFFFFFFE).to_bytes(4, "little") + raw[16:]
    decoder = lazrs.LasZipDecompressor(file, raw)
    return decoder.decompress_many  # type: ignore[no-any-return]


def _make_scan(path: Path, layout: Layout, table: _Table) -> Scan:
    attributes = table.values
    warnings = list(layout.warnings)
    if table.seen < layout.points:
        warnings.append(f"Only {table.seen} of {layout.points} points could be recovered.")
    metadata = dict(describe(layout).details)
    waveforms, notes = find_waveforms(path, layout, attributes)
    if waveforms is not None:
        metadata["waveforms"] = describe_waveforms(waveforms)
    return Scan(
        name=path.stem,
        xyz=table.xyz,
        attributes=attributes,
        channels=recognise_channels(attributes),
        metadata=metadata,
        warnings=(*warnings, *notes),
        waveforms=waveforms,
    )

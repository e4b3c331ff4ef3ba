"""Writer of LAS 1.4 and LAZ: fine scale, every column in its own type, units in the file."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.core.arrays import AnyArray, Floats, finite_rows
from app.core.errors import BadInput
from app.core.progress import Progress
from app.formats.cloud import Cloud
from app.formats.column_names import give_file_names
from app.formats.las_preflight import OUR_VLR

COARSEST = 1e-4  # metres
_FINEST = 1e-5
_LARGEST = 2**31 - 1
_NAME_BYTES = 32
_CHUNK = 500_000
_TYPES = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8")
_COLOURS = ("red", "green", "blue")
# Largest value of each standard column of formats 6 to 8, and its type.
_STANDARD = {
    "intensity": ("u2", 65535), "return_number": ("u1", 15), "number_of_returns": ("u1", 15),
    "synthetic": ("u1", 1), "key_point": ("u1", 1), "withheld": ("u1", 1), "overlap": ("u1", 1),
    "scanner_channel": ("u1", 3), "scan_direction_flag": ("u1", 1),
    "edge_of_flight_line": ("u1", 1), "classification": ("u1", 255), "user_data": ("u1", 255),
    "scan_angle": ("i2", 32767), "point_source_id": ("u2", 65535), "gps_time": ("f8", np.inf),
    "red": ("u2", 65535), "green": ("u2", 65535), "blue": ("u2", 65535), "nir": ("u2", 65535),
}  # fmt: skip
_RESERVED = ("X", "Y", "Z", "bit_fields", "classification_flags", *_STANDARD)


def write(path: Path, cloud: Cloud, progress: Progress) -> None:
    """Write a cloud; LAZ where ``.laz`` is the last known ending of the name.

    Coordinates are rounded to 0.01 mm, or to 0.1 mm where the extent needs it; points that
    came from LAS with such a scale keep it, and are written bit for bit.

    Raises
    ------
    BadInput
        A point is not finite, the extent is above 200 km, or a column holds no numbers.
    """
    import laspy

    table = _plan(cloud)
    lattice = choose_lattice(cloud.scan.xyz, cloud.scan.metadata)
    header = _make_header(cloud, table, lattice)
    with (
        path.open("wb") as file,
        laspy.open(
            file, mode="w", header=header, do_compress=_is_laz(path), closefd=False
        ) as writer,
    ):
        for start in range(0, len(cloud.scan), _CHUNK):
            progress.report(start / len(cloud.scan), "Writing LAS")
            rows = slice(start, min(start + _CHUNK, len(cloud.scan)))
            writer.write_points(_pack(cloud.scan.xyz[rows], table, rows, header))


@dataclass(frozen=True, slots=True)
class Lattice:
    """Scale and offset that turn coordinates into 32-bit integers."""

    scales: Floats
    offsets: Floats

    def round(self, xyz: Floats) -> Floats:
        """Integers of the coordinates, (n, 3), as float64."""
        return np.round((xyz - self.offsets) / self.scales)

    def fits(self, xyz: Floats) -> bool:
        """Whether all integers are within 32 bits."""
        if len(xyz) == 0:
            return True
        lowest, highest = self.round(_corners(xyz))
        return bool(lowest.min() >= -_LARGEST - 1 and highest.max() <= _LARGEST)

    def is_exact(self, xyz: Floats) -> bool:
        """Whether the coordinates come back bit for bit."""
        return np.array_equal(self.round(xyz) * self.scales + self.offsets, xyz)


def choose_lattice(xyz: Floats, metadata: Any) -> Lattice:
    """The source's own lattice where it is fine and exact, else the finest that fits."""
    if not finite_rows(xyz).all():
        raise BadInput(
            "LAS has no place for points whose coordinates are not finite.",
            "Export them as E57, PLY or NPZ, or leave them out.",
        )
    own = _read_lattice(metadata)
    if own is not None and own.fits(xyz) and own.is_exact(xyz):
        return own
    offsets = np.floor(_corners(xyz)[0]) if len(xyz) else np.zeros(3)
    for scale in (_FINEST, COARSEST):
        lattice = Lattice(np.full(3, scale), offsets)
        if lattice.fits(xyz):
            return lattice
    raise BadInput(
        "The points are further apart than LAS can hold at 0.1 mm (214 km).",
        "Export the scans one by one, or as E57 or NPZ.",
    )


def _read_lattice(metadata: Any) -> Lattice | None:
    try:
        scales, offsets = (
            np.array([float(word) for word in metadata[key].split()])
            for key in ("las_scale", "las_offset")
        )
    except (KeyError, ValueError):
        return None
    usable = len(scales) == 3 == len(offsets) and np.all((scales > 0) & (scales <= COARSEST))
    return Lattice(scales, offsets) if usable and np.isfinite(offsets).all() else None


def _corners(xyz: Floats) -> Floats:
    return np.stack((xyz.min(axis=0), xyz.max(axis=0)))


@dataclass(frozen=True, slots=True)
class _Column:
    """A column of the program and where it goes in the file."""

    name: str
    stored: str
    values: AnyArray
    boolean: bool
    standard: bool
    unit: str

    @property
    def notes(self) -> dict[str, str]:
        """What the reader needs to give the column back as it was."""
        kind = "bool" if self.boolean else ""
        notes = {"name": self.name, "unit": self.unit, "type": kind}
        return {key: value for key, value in notes.items() if value}


def _plan(cloud: Cloud) -> list[_Column]:
    """Every column of the cloud with its place in the file."""
    columns = cloud.columns
    standard = {name for name, values in columns.items() if _is_standard(name, values)}
    if not set(_COLOURS) <= standard:
        standard -= {*_COLOURS, "nir"}
    extra = give_file_names(
        (name for name in columns if name not in standard), taken=_RESERVED, clean=_shorten
    )
    return [
        _Column(
            name,
            extra.get(name, name),
            _to_las_type(name, values),
            values.dtype.kind == "b",
            name in standard,
            cloud.units.get(name, ""),
        )
        for name, values in columns.items()
    ]


def _is_standard(name: str, values: AnyArray) -> bool:
    if name not in _STANDARD or values.dtype != np.dtype(_STANDARD[name][0]):
        return False
    return len(values) == 0 or values.dtype.kind == "f" or values.max() <= _STANDARD[name][1]


def _shorten(name: str) -> str:
    # Three bytes are left for the number that tells equal names apart.
    return name.encode()[: _NAME_BYTES - 3].decode("utf-8", "ignore")


def _to_las_type(name: str, values: AnyArray) -> AnyArray:
    if values.dtype.kind == "b":
        return values.astype("u1")
    if values.dtype.str[1:] in _TYPES:
        return values
    if values.dtype == np.float16:
        return values.astype("f4")
    raise BadInput(f"LAS has no type for the values of {name} ({values.dtype}).")


def _make_header(cloud: Cloud, table: list[_Column], lattice: Lattice) -> Any:
    import laspy

    header = laspy.LasHeader(point_format=_point_format(table), version="1.4")
    header.scales, header.offsets = lattice.scales, lattice.offsets
    header.generating_software = "Leafscope"
    header.system_identifier = str(cloud.scan.metadata.get("system", ""))[:31]
    header.add_extra_dims(
        [
            laspy.ExtraBytesParams(c.stored, c.values.dtype.str[1:], _shorten(c.unit))
            for c in table
            if not c.standard
        ]
    )
    notes = json.dumps({"columns": {c.stored: c.notes for c in table}})
    header.vlrs.append(laspy.VLR(*OUR_VLR, "names of columns", notes.encode()))
    return header


def _point_format(table: list[_Column]) -> int:
    standard = {column.stored for column in table if column.standard}
    if "nir" in standard:
        return 8
    return 7 if "red" in standard else 6


def _pack(xyz: Floats, table: list[_Column], rows: slice, header: Any) -> Any:
    from laspy import ScaleAwarePointRecord

    records = ScaleAwarePointRecord.zeros(len(xyz), header=header)
    integers = Lattice(header.scales, header.offsets).round(xyz).astype(np.int32)
    for axis, key in enumerate("XYZ"):
        records.array[key] = integers[:, axis]
    for column in table:
        records[column.stored] = column.values[rows]
    return records


def _is_laz(path: Path) -> bool:
    """Look past the ending of a temporary file."""
    known = [s for s in path.suffixes if s.lower() in (".las", ".laz")]
    return bool(known) and known[-1].lower() == ".laz"

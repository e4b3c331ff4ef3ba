"""What an E57 file says about its scans (ASTM E2807), checked before libE57 opens it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.formats.e57_xml import Node, logical_bytes, read_xml
from app.formats.header import Header
from app.model.scan import Pose, Vector

CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
OUR_URI = "urn:leafscope:e57:1"
NOTES = "leafscope:notes"
_MOST_SCANS = 10_000
_MOST_FIELDS = 1_000
_INT64 = (-(2**63), 2**63 - 1)
_INTEGERS = ("u1", "i1", "u2", "i2", "u4", "i4", "i8")
_WORKING_MEMORY = 1 << 26


@dataclass(frozen=True, slots=True)
class Element:
    """One number of a record: its name, numpy type, and bits in the file."""

    name: str
    type: str
    bits: int


@dataclass(frozen=True, slots=True)
class ScanLayout:
    """One entry of ``data3D``; `index` is its place there."""

    index: int
    name: str
    records: int
    elements: tuple[Element, ...]
    pose: Pose | None
    bounds: tuple[int, int, int, int] | None
    metadata: dict[str, str] = field(default_factory=dict)
    notes: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the elements that can be read."""
        return tuple(element.name for element in self.elements)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The three names of its coordinates; Cartesian where there are both."""
        for names in (CARTESIAN, SPHERICAL):
            if set(names) <= set(self.names):
                return names
        return ()


@dataclass(frozen=True, slots=True)
class Layout:
    """All scans of a file."""

    scans: tuple[ScanLayout, ...]
    details: dict[str, str]


def read_layout(path: Path) -> Layout:
    """Read and check what the XML section says.

    Raises
    ------
    BadInput
        See `read_xml`; or a scan claims what its file cannot hold, or has no coordinates.
    """
    root = read_xml(path)
    data = root.child("data3D")
    entries = data.children if data is not None else []
    if not entries:
        raise BadInput(f"{path.name} holds no scan (an E57 file may hold images only).")
    if len(entries) > _MOST_SCANS:
        raise BadInput(f"{path.name} holds more than {_MOST_SCANS} scans.", "Split it.")
    size = path.stat().st_size
    scans = tuple(_read_scan(path, i, entry, size) for i, entry in enumerate(entries))
    details = {
        "format": "E57 1.0",
        "software": root.string("e57LibraryVersion"),
        "crs": root.string("coordinateMetadata"),
    }
    return Layout(scans, {key: value for key, value in details.items() if value})


def describe(layout: Layout) -> Header:
    """The layout as every format tells it."""
    names = dict.fromkeys(name for scan in layout.scans for name in scan.names)
    return Header(
        points=sum(scan.records for scan in layout.scans),
        scans=len(layout.scans),
        attributes=tuple(n for n in names if n not in CARTESIAN + SPHERICAL),
        memory=sum(_memory(scan) for scan in layout.scans) + _WORKING_MEMORY,
        details=layout.details,
        warnings=tuple(warning for scan in layout.scans for warning in scan.warnings),
    )


def _memory(scan: ScanLayout) -> int:
    """Bytes while reading: all elements, then world coordinates and what is left of them."""
    return scan.records * (2 * sum(np.dtype(e.type).itemsize for e in scan.elements) + 60)


def _read_scan(path: Path, index: int, entry: Node, size: int) -> ScanLayout:
    name = entry.string("name") or f"{path.stem} {index + 1}"
    where = f"{path.name}, scan {index + 1}"
    points = entry.child("points")
    if points is None or points.attributes.get("type") != "CompressedVector":
        raise BadInput(f"{where} has no points.")
    records = _whole(points.attributes.get("recordCount"), 0, f"{where}: recordCount")
    prototype = points.child("prototype")
    if prototype is None or not prototype.children:
        raise BadInput(f"{where} does not say what its records hold (no prototype).")
    elements, warnings = _read_prototype(prototype, where)
    scan = ScanLayout(
        index=index,
        name=name,
        records=records,
        elements=elements,
        pose=_read_pose(entry, where),
        bounds=_read_bounds(entry),
        metadata=_read_metadata(entry),
        notes=entry.string(NOTES),
        warnings=warnings,
    )
    _check_size(scan, points, size, where)
    return scan


def _check_size(scan: ScanLayout, points: Node, size: int, where: str) -> None:
    offset = _whole(points.attributes.get("fileOffset"), 0, f"{where}: fileOffset")
    if not scan.coordinates:
        raise BadInput(f"{where} has neither Cartesian nor spherical coordinates.")
    bits = sum(element.bits for element in scan.elements)
    room = 8 * logical_bytes(max(size - offset, 0))
    if scan.records < 0 or (scan.records and (offset <= 0 or scan.records * bits > room)):
        raise BadInput(
            f"{where} claims {scan.records} points from byte {offset}, which the file of "
            f"{size} bytes cannot hold."
        )


def _read_prototype(prototype: Node, where: str) -> tuple[tuple[Element, ...], tuple[str, ...]]:
    if len(prototype.children) > _MOST_FIELDS:
        raise BadInput(f"{where}: more than {_MOST_FIELDS} numbers in a record.")
    elements: list[Element] = []
    left_out: list[str] = []
    for node in prototype.children:
        element = _read_element(node, where)
        if element is None or node.name in (e.name for e in elements):
            left_out.append(node.name)
        else:
            elements.append(element)
    warnings = (f"{where}: {', '.join(left_out)} is not numeric and was left out.",)
    return tuple(elements), warnings if left_out else ()


def _read_element(node: Node, where: str) -> Element | None:
    kind = node.attributes.get("type")
    if kind == "Float":
        single = node.attributes.get("precision") == "single"
        return Element(node.name, "f4" if single else "f8", 32 if single else 64)
    if kind not in ("Integer", "ScaledInteger"):
        return None
    low, high = (
        _whole(node.attributes.get(key), default, f"{where}: {key} of {node.name}")
        for key, default in zip(("minimum", "maximum"), _INT64, strict=True)
    )
    if not _INT64[0] <= low <= high <= _INT64[1]:
        raise BadInput(f"{where}: the limits of {node.name} are impossible ({low} to {high}).")
    bits = (high - low).bit_length()
    return Element(node.name, "f8" if kind == "ScaledInteger" else _integer(low, high), bits)


def _integer(low: int, high: int) -> str:
    """The smallest type for the limits."""
    fits = (t for t in _INTEGERS if np.iinfo(t).min <= low and high <= np.iinfo(t).max)
    return next(fits)


def _read_pose(entry: Node, where: str) -> Pose | None:
    """The pose that the file states; a missing part of it is zero, or no turn."""
    pose = entry.child("pose")
    if pose is None:
        return None
    shift = [pose.number("translation", axis) or 0.0 for axis in "xyz"]
    turn = [pose.number("rotation", axis) or 0.0 for axis in "wxyz"]
    if pose.child("rotation") is None:
        turn = [1.0, 0.0, 0.0, 0.0]
    length = math.sqrt(sum(q * q for q in turn))
    if not all(map(math.isfinite, (*shift, length))) or length == 0:
        raise BadInput(f"{where}: its pose is impossible (position {shift}, rotation {turn}).")
    x, y, z = quaternion_matrix([q / length for q in turn]).tolist()
    return Pose((shift[0], shift[1], shift[2]), (_vector(x), _vector(y), _vector(z)))


def _vector(values: list[float]) -> Vector:
    return values[0], values[1], values[2]


def quaternion_matrix(quaternion: list[float]) -> Floats:
    """Rotation matrix (scanner to world) of a unit quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _read_bounds(entry: Node) -> tuple[int, int, int, int] | None:
    """First row, last row, first column, last column."""
    keys = ("rowMinimum", "rowMaximum", "columnMinimum", "columnMaximum")
    values = [entry.number("indexBounds", key) for key in keys]
    if any(value is None or not abs(value) < 2**31 for value in values):
        return None
    first_row, last_row, first_column, last_column = (int(value or 0) for value in values)
    return first_row, last_row, first_column, last_column


def _read_metadata(entry: Node) -> dict[str, str]:
    plain = ("guid", "description", "sensorVendor", "sensorModel", "sensorSerialNumber")
    facts = {name: entry.string(name) for name in plain}
    for limit in ("intensityMinimum", "intensityMaximum"):
        value = entry.number("intensityLimits", limit)
        facts[limit] = "" if value is None else repr(value)
    return {key: value for key, value in facts.items() if value}


def _whole(text: str | None, default: int, what: str) -> int:
    if text is None:
        return default
    digits = text.strip()
    if len(digits) > 20 or not digits.lstrip("+-").isascii() or not digits.lstrip("+-").isdigit():
        raise BadInput(f"{what} is no whole number: {digits[:40]}.")
    return int(digits)

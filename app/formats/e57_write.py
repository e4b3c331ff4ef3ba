"""Writer of E57: every column, pose, rows and columns, and beams without echo."""

from __future__ import annotations

import uuid
from pathlib import Path
from typing import Any

import numpy as np

from app.core.arrays import AnyArray, Floats, finite_rows
from app.core.progress import Progress
from app.formats.cloud import Cloud
from app.formats.e57_columns import OURS, Column, find_quaternion, plan_columns
from app.formats.e57_notes import write_notes
from app.formats.e57_preflight import NOTES, OUR_URI
from app.model.scan import Pose

_CHUNK = 500_000
_INTEGER_TYPES = "biu"


def write(path: Path, cloud: Cloud, progress: Progress) -> None:
    """Write a cloud as one scan.

    Coordinates go to the scanner's own system (double precision) where the pose is known;
    a pose that is no proper rotation is written as its position alone. Cells without echo
    follow the points, marked as records without coordinates.

    Raises
    ------
    BadInput
        A column holds what E57 has no type for.
    """
    from pye57 import libe57

    table = plan_columns(cloud)
    image = libe57.ImageFile(str(path), "w")
    try:
        image.extensionsAdd("", libe57.E57_V1_0_URI)
        image.extensionsAdd(OURS, OUR_URI)
        file = _File(libe57, image)
        scans = file.write_root()
        points = file.write_scan(scans, cloud, table)
        _write_records(file, points, table, progress)
    except BaseException:
        image.cancel()
        raise
    image.close()


def transport(values: AnyArray) -> AnyArray:
    """Values in a type that pye57 takes: it reads numpy's int64 as 32 bits, not longlong."""
    wide = values.dtype.kind in "iu" and values.dtype.itemsize >= 4
    return values.astype(np.longlong) if wide else values


def _write_records(file: _File, points: Any, table: list[Column], progress: Progress) -> None:
    total = table[0].length
    if total == 0:
        return
    capacity = min(_CHUNK, total)
    arrays = {c.element: np.zeros(capacity, transport(c.values[:0]).dtype) for c in table}
    writer = points.writer(file.make_buffers(arrays, capacity))
    for start in range(0, total, capacity):
        progress.report(start / total, "Writing E57")
        stop = min(start + capacity, total)
        for column in table:
            arrays[column.element][: stop - start] = column.rows(start, stop)
        writer.write(stop - start)
    writer.close()


class _File:
    """Builds nodes of one E57 file."""

    def __init__(self, library: Any, image: Any) -> None:
        self._library = library
        self._image = image

    def write_root(self) -> Any:
        """Fill in the root; give the empty vector of scans."""
        root = self._image.root()
        root.set("formatName", self._text("ASTM E57 3D Imaging Data File"))
        root.set("guid", self._text(f"{{{uuid.uuid4()}}}"))
        root.set("versionMajor", self._library.IntegerNode(self._image, 1))
        root.set("versionMinor", self._library.IntegerNode(self._image, 0))
        root.set("e57LibraryVersion", self._text(str(self._library.E57_LIBRARY_ID)))
        root.set("coordinateMetadata", self._text(""))
        scans = self._library.VectorNode(self._image, True)
        root.set("data3D", scans)
        root.set("images2D", self._library.VectorNode(self._image, True))
        return scans

    def write_scan(self, scans: Any, cloud: Cloud, table: list[Column]) -> Any:
        """Describe the scan; give the node that takes its records."""
        scan = self._structure()
        scan.set("guid", self._text(f"{{{uuid.uuid4()}}}"))
        scan.set("name", self._text(cloud.scan.name))
        scan.set("description", self._text(str(cloud.scan.metadata.get("description", ""))))
        names = {c.element: c.name for c in table if c.element.startswith(OURS)}
        scan.set(NOTES, self._text(write_notes(cloud, names)))
        if cloud.scan.pose is not None:
            scan.set("pose", self._pose(cloud.scan.pose))
        self._write_limits(scan, cloud, {c.element: c for c in table})
        prototype = self._structure()
        for column in table:
            prototype.set(column.element, self._prototype(column.values.dtype))
        points = self._library.CompressedVectorNode(
            self._image, prototype, self._library.VectorNode(self._image, True)
        )
        scan.set("points", points)
        scans.append(scan)
        return points

    def make_buffers(self, arrays: dict[str, AnyArray], capacity: int) -> Any:
        """Buffers of all elements, over arrays that stay alive."""
        buffers = self._library.VectorSourceDestBuffer()
        for name, array in arrays.items():
            buffers.append(
                self._library.SourceDestBuffer(self._image, name, array, capacity, True, True)
            )
        return buffers

    def _write_limits(self, scan: Any, cloud: Cloud, columns: dict[str, Column]) -> None:
        corners = _finite_corners(cloud.scan.xyz)
        if corners is not None:
            scan.set("cartesianBounds", self._numbers(corners))
        grid = cloud.scan.grid
        if grid is not None:
            cells = {"rowMinimum": 0, "rowMaximum": grid.rows - 1,
                     "columnMinimum": 0, "columnMaximum": grid.columns - 1}  # fmt: skip
            scan.set("indexBounds", self._numbers(cells))
        if "intensity" in columns:
            limits = self._limits({"intensity": columns["intensity"]})
            scan.set("intensityLimits", self._numbers(limits))
        if "colorRed" in columns:
            colours = {n: columns[n] for n in ("colorRed", "colorGreen", "colorBlue")}
            scan.set("colorLimits", self._numbers(self._limits(colours)))

    def _limits(self, columns: dict[str, Column]) -> dict[str, Any]:
        """Smallest and largest finite value of each column."""
        limits = {}
        for name, column in columns.items():
            finite = column.values[np.isfinite(column.values)]
            low, high = (finite.min(), finite.max()) if len(finite) else (0, 0)
            limits[f"{name}Minimum"] = np.asarray(low).item()
            limits[f"{name}Maximum"] = np.asarray(high).item()
        return limits

    def _prototype(self, dtype: np.dtype[Any]) -> Any:
        if dtype.kind in _INTEGER_TYPES:
            limits = np.iinfo(dtype)
            return self._library.IntegerNode(self._image, 0, int(limits.min), int(limits.max))
        if dtype == np.float32:
            lowest, highest = self._library.E57_FLOAT_MIN, self._library.E57_FLOAT_MAX
            single = self._library.E57_SINGLE
            return self._library.FloatNode(self._image, 0.0, single, lowest, highest)
        return self._library.FloatNode(self._image, 0.0)

    def _pose(self, pose: Pose) -> Any:
        node = self._structure()
        turn = zip("wxyz", find_quaternion(pose), strict=True)
        node.set("rotation", self._numbers(dict(turn)))
        shift = zip("xyz", map(float, pose.position), strict=True)
        node.set("translation", self._numbers(dict(shift)))
        return node

    def _numbers(self, values: dict[str, Any]) -> Any:
        node = self._structure()
        for name, value in values.items():
            kind = self._library.IntegerNode if type(value) is int else self._library.FloatNode
            node.set(name, kind(self._image, value))
        return node

    def _structure(self) -> Any:
        return self._library.StructureNode(self._image)

    def _text(self, text: str) -> Any:
        return self._library.StringNode(self._image, text)


def _finite_corners(xyz: Floats) -> dict[str, float] | None:
    finite = xyz[finite_rows(xyz)]
    if len(finite) == 0:
        return None
    corners = {"Minimum": finite.min(axis=0), "Maximum": finite.max(axis=0)}
    return {f"{a}{end}": float(c["xyz".index(a)]) for end, c in corners.items() for a in "xyz"}

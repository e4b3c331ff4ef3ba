"""Columns of an E57 file: names, types, and what stands in records without echo."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Ints
from app.core.errors import BadInput
from app.formats.cloud import Cloud
from app.formats.column_names import give_file_names
from app.formats.e57_preflight import CARTESIAN, quaternion_matrix
from app.model.scan import Pose

OURS = "leafscope"  # prefix of the columns that E57 has no name for
_NO_POINT = 2  # value of cartesianInvalidState for a record without coordinates
_STANDARD = {
    "intensity": "intensity", "red": "colorRed", "green": "colorGreen", "blue": "colorBlue",
    "row": "rowIndex", "column": "columnIndex", "timeStamp": "timeStamp",
}  # fmt: skip
_COLOURS = ("red", "green", "blue")


@dataclass(frozen=True, slots=True)
class Column:
    """A column, its name in the file, and what stands in records without echo."""

    name: str
    element: str
    values: AnyArray
    silent: AnyArray

    @property
    def length(self) -> int:
        """Records: points and beams without echo."""
        return len(self.values) + len(self.silent)

    def rows(self, start: int, stop: int) -> AnyArray:
        """Values of some records: points first, then beams without echo."""
        n = len(self.values)
        return np.concatenate(
            (self.values[start:stop], self.silent[max(start - n, 0) : max(stop - n, 0)])
        )


def plan_columns(cloud: Cloud) -> list[Column]:
    """All columns of a cloud, coordinates in the scanner's system first.

    Raises
    ------
    BadInput
        A column holds what E57 has no type for.
    """
    cells = cloud.scan.grid.no_return if cloud.scan.grid is not None else np.empty(0, np.int64)
    columns = _coordinates(cloud)
    if len(cells):
        columns["cartesianInvalidState"] = np.zeros(len(cloud.scan), np.uint8)
    columns |= {name: _to_e57_type(name, values) for name, values in cloud.columns.items()}
    names = _name_elements(columns)
    return [
        Column(name, names[name], values, _fill_silent(name, values, cells, cloud))
        for name, values in columns.items()
    ]


def _coordinates(cloud: Cloud) -> dict[str, AnyArray]:
    xyz = cloud.scan.xyz
    if cloud.scan.pose is not None:
        rotation = quaternion_matrix(find_quaternion(cloud.scan.pose))
        xyz = (xyz - np.array(cloud.scan.pose.position)) @ rotation
    return dict(zip(CARTESIAN, xyz.T, strict=True))


def _name_elements(columns: dict[str, AnyArray]) -> dict[str, str]:
    standard = {name: _STANDARD[name] for name in columns if name in _STANDARD}
    colours = [columns[name].dtype.kind for name in _COLOURS if name in columns]
    if len(colours) < len(_COLOURS) or set(colours) - {"i", "u"}:
        standard = {k: v for k, v in standard.items() if k not in _COLOURS}
    own = {name: name for name in (*CARTESIAN, "cartesianInvalidState") if name in columns}
    rest = [name for name in columns if name not in standard and name not in own]
    ours = give_file_names(rest, taken=(), clean=_clean)
    return {**standard, **own, **{name: f"{OURS}:{ours[name]}" for name in rest}}


def _clean(name: str) -> str:
    """A name that XML takes: letters, digits and underscores after a letter."""
    return re.sub(r"^(?![A-Za-z])", "x", re.sub(r"[^A-Za-z0-9]", "_", name))


def _to_e57_type(name: str, values: AnyArray) -> AnyArray:
    kind, size = values.dtype.kind, values.dtype.itemsize
    if kind == "b":
        return values.astype(np.uint8)
    if kind == "f" and size <= 8:
        return values.astype(np.float32 if size <= 4 else np.float64)
    if kind in "iu" and (kind == "i" or size < 8 or len(values) == 0 or values.max() < 2**63):
        return values.astype(np.int64) if size == 8 else values
    raise BadInput(f"E57 has no type for the values of {name} ({values.dtype}).", "Use NPZ.")


def _fill_silent(name: str, values: AnyArray, cells: Ints, cloud: Cloud) -> AnyArray:
    if name == "cartesianInvalidState":
        return np.full(len(cells), _NO_POINT, values.dtype)
    if name in ("row", "column") and cloud.scan.grid is not None:
        row, column = np.divmod(cells, cloud.scan.grid.columns)
        return (row if name == "row" else column).astype(values.dtype)
    return np.zeros(len(cells), values.dtype)


def find_quaternion(pose: Pose) -> list[float]:
    """Unit quaternion (w, x, y, z) of a pose; no turn where it is no proper rotation."""
    matrix = np.array(pose.rotation)
    # The eigenvector of Bar-Itzhack (2000), stable for every angle.
    (a, b, c), (d, e, f), (g, h, i) = matrix
    symmetric = np.array(
        [
            [a - e - i, b + d, c + g, h - f],
            [b + d, e - a - i, f + h, c - g],
            [c + g, f + h, i - a - e, d - b],
            [h - f, c - g, d - b, a + e + i],
        ]
    )
    x, y, z, w = np.linalg.eigh(symmetric)[1][:, -1].tolist()
    found = [w, x, y, z]
    proper = np.allclose(quaternion_matrix(found), matrix, rtol=0.0, atol=1e-9)
    return found if proper else [1.0, 0.0, 0.0, 0.0]

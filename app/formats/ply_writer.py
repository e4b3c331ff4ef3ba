"""Writer of binary little-endian PLY: double coordinates, then all attributes and fields."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.core.arrays import AnyArray
from app.core.errors import BadInput
from app.core.progress import Progress
from app.formats.cloud import Cloud
from app.formats.column_names import give_file_names
from app.formats.ply_comments import describe_names, describe_pose, describe_provenance

_CHUNK = 1 << 18
_WORDS = {
    "i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint",
    "f4": "float", "f8": "double",
}  # fmt: skip


def write(path: Path, cloud: Cloud, progress: Progress) -> None:
    """Write a cloud; its sidecar is the caller's business (`saving.save`).

    Raises
    ------
    BadInput
        A column holds integers that no type of PLY can hold.
    """
    columns = {name: _to_ply_type(name, values) for name, values in cloud.columns.items()}
    names = give_file_names(columns, taken=("x", "y", "z"), clean=_clean)
    xyz = dict(zip("xyz", cloud.scan.xyz.astype("<f8").T, strict=True))
    table = {**xyz, **{names[name]: values for name, values in columns.items()}}
    with path.open("wb") as file:
        file.write(_make_header(cloud, table, names).encode("utf-8"))
        dtype = np.dtype([(name, values.dtype) for name, values in table.items()])
        for start in range(0, len(cloud.scan), _CHUNK):
            progress.report(start / len(cloud.scan), "Writing PLY")
            rows = np.empty(min(_CHUNK, len(cloud.scan) - start), dtype)
            for name, values in table.items():
                rows[name] = values[start : start + _CHUNK]
            file.write(rows.tobytes())


def _make_header(cloud: Cloud, table: dict[str, AnyArray], names: dict[str, str]) -> str:
    comments = describe_provenance(cloud.provenance) + describe_names(names)
    if cloud.scan.pose is not None:
        comments.append(describe_pose(cloud.scan.pose))
    lines = ["ply", "format binary_little_endian 1.0"]
    lines += [f"comment {comment}" for comment in comments]
    lines.append(f"element vertex {len(cloud.scan)}")
    lines += [f"property {_WORDS[v.dtype.str[1:]]} {name}" for name, v in table.items()]
    return "\n".join([*lines, "end_header\n"])


def _clean(name: str) -> str:
    return "".join(c if c.isprintable() and not c.isspace() else "_" for c in name)


def _to_ply_type(name: str, values: AnyArray) -> AnyArray:
    kind, size = values.dtype.kind, values.dtype.itemsize
    if kind == "b":
        return values.astype("u1")
    if kind == "f" and size <= 8:
        return values.astype("<f4" if size <= 4 else "<f8")
    if kind in "iu" and size <= 4:
        return values.astype(values.dtype.newbyteorder("<"))
    as_double = values.astype("<f8")
    if kind in "iu" and np.all(np.abs(as_double) <= 2.0**53):
        return as_double
    raise BadInput(
        f"PLY has no type for the values of {name} ({values.dtype}).", "Export it as NPZ."
    )

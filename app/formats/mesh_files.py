"""Triangles in files: PLY with leaf and angle of each face, OBJ with a group per leaf, STL."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.errors import BadInput, WrongUse
from app.formats.atomic import atomic_path

SUFFIXES = (".ply", ".obj", ".stl")
FAR = 1000.0
"""Metres from the origin up to which single precision keeps a tenth of a millimetre."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Triangles of one leaf: corners (v, 3) metres, faces (f, 3), angle (f,) degrees.

    Normals (f, 3) are told where they are others than those of the triangles.
    """

    name: str
    vertices: Floats
    faces: Ints
    omega: Floats
    normals: Floats | None = None


def refuse_suffix(path: Path) -> None:
    """Raise `WrongUse` where the name is none of a file of triangles."""
    if path.suffix.lower() not in SUFFIXES:
        raise WrongUse(
            f"{path.name} is no name of a file of triangles.",
            f"End it with one of {', '.join(SUFFIXES)}.",
        )


def write_parts(path: Path, parts: Sequence[Part], overwrite: bool = False) -> None:
    """Write triangles, whole or not at all.

    PLY holds corners in double precision and per face `leaf` (number of the part, from 0) and
    `omega` (degrees), and normals where these are told; the names of the parts stand in its
    comments. STL knows normals, but neither leaf nor angle, and only single precision.

    Raises
    ------
    BadInput
        There is no triangle, coordinates are too far from the origin for STL, or the file
        cannot be written.
    WrongUse
        The suffix is not known.
    """
    refuse_suffix(path)
    if not sum(len(part.faces) for part in parts):
        raise BadInput("There is no triangle to write.")
    writers = {".ply": _write_ply, ".obj": _write_obj, ".stl": _write_stl}
    with atomic_path(path, overwrite) as temporary:
        writers[path.suffix.lower()](temporary, parts)


def _write_ply(path: Path, parts: Sequence[Part]) -> None:
    vertices = np.concatenate([part.vertices for part in parts])
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    names = [f"comment leaf {k}: {_clean(part.name)}" for k, part in enumerate(parts)]
    row = [("n", "u1"), ("v", "<i4", 3), ("leaf", "<i4"), ("omega", "<f4")]
    told = any(part.normals is not None for part in parts)
    if told:
        row.append(("normal", "<f4", 3))
    table = np.empty(sum(len(part.faces) for part in parts), np.dtype(row))
    table["n"] = 3
    table["v"] = np.concatenate([p.faces + f for p, f in zip(parts, first, strict=False)])
    table["leaf"] = np.repeat(np.arange(len(parts)), [len(part.faces) for part in parts])
    table["omega"] = np.concatenate([part.omega for part in parts])
    if told:
        table["normal"] = np.concatenate([_normals_of(part) for part in parts])
    header = [
        "ply", "format binary_little_endian 1.0", "comment omega in degrees", *names,
        f"element vertex {len(vertices)}", *(f"property double {axis}" for axis in "xyz"),
        f"element face {len(table)}", "property list uchar int vertex_indices",
        "property int leaf", "property float omega",
        *(f"property float n{axis}" for axis in ("xyz" if told else "")), "end_header",
    ]  # fmt: skip
    with path.open("wb") as file:
        file.write(("\n".join(header) + "\n").encode("utf-8"))
        file.write(vertices.astype("<f8").tobytes())
        file.write(table.tobytes())


def _write_obj(path: Path, parts: Sequence[Part]) -> None:
    first = 1  # OBJ counts from 1, through all groups
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for part in parts:
            file.write(f"g {_clean(part.name).replace(' ', '_')}\n")
            np.savetxt(file, part.vertices, "v %.6f %.6f %.6f")
            np.savetxt(file, part.faces + first, "f %d %d %d")
            first += len(part.vertices)


def _write_stl(path: Path, parts: Sequence[Part]) -> None:
    corners = np.concatenate([part.vertices[part.faces] for part in parts])
    if np.abs(corners).max() > FAR:
        raise BadInput(
            f"STL keeps too few digits for coordinates more than {FAR:g} m from the origin.",
            "Write PLY or OBJ.",
        )
    row = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("tail", "<u2")])
    table = np.zeros(len(corners), row)
    table["normal"] = np.concatenate([_normals_of(part) for part in parts])
    table["corners"] = corners
    with path.open("wb") as file:
        file.write(b"leaves, metres".ljust(80))
        file.write(np.array(len(table), "<u4").tobytes())
        file.write(table.tobytes())


def _normals_of(part: Part) -> Floats:
    return find_normals(part.vertices[part.faces]) if part.normals is None else part.normals


def find_normals(corners: AnyArray) -> Floats:
    """Unit normals of triangles, (f, 3); 0 where one has no area."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(across / np.where(size > 0.0, size, 1.0))


def _clean(name: str) -> str:
    return "".join(c if c.isprintable() else " " for c in name)

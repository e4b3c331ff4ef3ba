"""``leafscope mesh``: leaves as triangles."""

from __future__ import annotations

from pathlib import Path

from app.cli.commands import (
    DEFAULT_FOOTPRINT,
    DEFAULT_PLANES,
    DEFAULT_READING,
    Footprint,
    Json,
    Overwrite,
    Planes,
    Reading,
    opening,
    parameters_of,
)
from app.cli.console import watch


def mesh(
    file: Path,
    /,
    *,
    out: Path,
    label_field: str | None = None,
    leaf: tuple[str, ...] = (),
    beam: Footprint = DEFAULT_FOOTPRINT,
    planes: Planes = DEFAULT_PLANES,
    reading: Reading = DEFAULT_READING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Mesh the leaves of a scan on its grid.

    Parameters
    ----------
    file
        A scan with rows and columns.
    out
        File to write: .ply (with leaf and omega of each face), .obj or .stl.
    label_field
        Field whose whole numbers from 0 on name the leaves; without it leaves are found.
    leaf
        Name of a leaf to mesh (may be repeated); all without it.
    """
    from app.cli.printing import count_of, print_json, say
    from app.services.surfaces.files import mesh_file

    rows = mesh_file(
        opening(file, reading), out, label_field, leaf, parameters_of(planes, beam), overwrite,
        watch(),
    )  # fmt: skip
    if json:
        print_json({"leaves": rows})
        return
    meshed = sum(row["area_cm2"] is not None for row in rows)
    say(f"{count_of(meshed, 'leaf', 'leaves')} of {len(rows)} meshed; {out} written.")

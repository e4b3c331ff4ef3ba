"""``leafscope mesh``: leaves as triangles."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

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
from app.core.errors import WrongUse


def mesh(
    file: Path,
    /,
    *,
    out: Path,
    label_field: str | None = None,
    seeds: Path | None = None,
    leaf: tuple[str, ...] = (),
    steep_normals: Literal["ranges", "intensity"] = "ranges",
    curve: Path | None = None,
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
    seeds
        CSV file with columns leaf, x, y, z (metres) that puts leaves right: places of one name
        on several leaves make them one, places of several names on one leaf split it.
    leaf
        Name of a leaf to mesh (may be repeated); all without it.
    steep_normals
        What tells normal and angle of faces steeper than 60°: ranges, or intensity, which needs
        --curve and a channel in its unit. Areas stay those of the ranges.
    curve
        With --steep-normals intensity: goniometer table, CSV with columns angle and value.
    """
    from app.cli.printing import count_of, print_json, say
    from app.services.surfaces.files import mesh_file
    from app.services.surfaces.steep import choose_curve

    if curve is not None and steep_normals == "ranges":
        raise WrongUse("--curve belongs to --steep-normals intensity.")
    steep = choose_curve(curve) if steep_normals == "intensity" else None
    rows = mesh_file(
        opening(file, reading), out, label_field, leaf, parameters_of(planes, beam), overwrite,
        watch(), seeds, steep,
    )  # fmt: skip
    if json:
        print_json({"leaves": rows})
        return
    meshed = sum(row["area_cm2"] is not None for row in rows)
    say(f"{count_of(meshed, 'leaf', 'leaves')} of {len(rows)} meshed; {out} written.")

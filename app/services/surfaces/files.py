"""``leafscope mesh``: the leaves of a file as triangles in a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from app.core.errors import BadInput
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees
from app.formats.atomic import refuse_target
from app.formats.mesh_files import Part, refuse_suffix, write_parts
from app.services.leaf_seeds import make_leaves, read_seeds
from app.services.opening import Opening, open_file, set_parameters
from app.services.surfaces.meshes import LeafSurface, mesh_leaves, tell_area
from app.services.surfaces.steep import turn_surfaces
from app.services.wrinkles.request import Source

Row = dict[str, str | float | int | None]


def mesh_file(
    opening: Opening,
    out: Path,
    label_field: str | None = None,
    chosen: tuple[str, ...] = (),
    parameters: Mapping[str, Any] | None = None,
    overwrite: bool = False,
    progress: Progress = QUIET,
    seeds: Path | None = None,
    steep: Source | None = None,
) -> list[Row]:
    """Mesh the leaves of a file; give a row per leaf with its area.

    Parameters
    ----------
    label_field : str or None
        Field whose whole numbers name the leaves; None finds them.
    chosen : tuple of str
        Names of leaves, or keys; empty: all.
    parameters : mapping
        Attributes of `Parameters` that differ from the defaults.
    seeds : Path or None
        Table of places that split, merge and name leaves, see `app.services.leaf_seeds`.
    steep : Source or None
        Curve by which intensity tells the normals of steep faces; None: ranges tell them.

    Raises
    ------
    BadInput
        No leaf was found, a seed lies on none, or no leaf has a mesh.
    WrongUse
        The name of the result ends in nothing that is known.
    """
    refuse_suffix(out)
    refuse_target(out, overwrite, sources=list(filter(None, [opening.path, seeds])))
    given = None if seeds is None else read_seeds(seeds)
    project, keys = open_file(opening, progress.part(0.0, 0.3))
    surfaces: list[LeafSurface] = []
    for key in keys:
        set_parameters(project, key, **(parameters or {}))
        make_leaves(project, key, label_field, given, progress.part(0.3, 0.6))
        wanted = [
            leaf.key
            for leaf in project.state.leaves_of(key)
            if not chosen or leaf.name in chosen or leaf.key in chosen
        ]
        found = mesh_leaves(project, key, wanted, progress.part(0.6, 0.85))
        if steep is not None:
            found = turn_surfaces(project, key, found, steep, progress.part(0.85, 0.95))
        surfaces += found
    write_surfaces(surfaces, out, overwrite)
    return [_tell(surface) for surface in surfaces]


def _tell(surface: LeafSurface) -> Row:
    faces = 0 if surface.mesh is None else len(surface.mesh.faces)
    return {"leaf": surface.key, "name": surface.name, "faces": faces, **tell_area(surface)}


def write_surfaces(surfaces: list[LeafSurface], out: Path, overwrite: bool = False) -> None:
    """Write meshes to one file; raises `BadInput` where there is none."""
    parts = [
        Part(s.name, s.mesh.vertices, s.mesh.faces, to_degrees(s.mesh.omega), s.mesh.normals)
        for s in surfaces
        if s.mesh is not None
    ]
    if not parts:
        why = surfaces[0].reason if surfaces else "No leaf was found."
        raise BadInput(f"No mesh could be made. {why}")
    write_parts(out, parts, overwrite)

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
from app.services.leaves import find_leaves, leaves_from_labels
from app.services.opening import Opening, open_file, set_parameters
from app.services.surfaces.meshes import LeafSurface, mesh_leaves, tell_area

Row = dict[str, str | float | int | None]


def mesh_file(
    opening: Opening,
    out: Path,
    label_field: str | None = None,
    chosen: tuple[str, ...] = (),
    parameters: Mapping[str, Any] | None = None,
    overwrite: bool = False,
    progress: Progress = QUIET,
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

    Raises
    ------
    BadInput
        No leaf was found, or none of them has a mesh.
    WrongUse
        The name of the result ends in nothing that is known.
    """
    refuse_suffix(out)
    refuse_target(out, overwrite, sources=[opening.path])
    project, keys = open_file(opening, progress.part(0.0, 0.3))
    surfaces: list[LeafSurface] = []
    for key in keys:
        set_parameters(project, key, **(parameters or {}))
        if label_field is None:
            find_leaves(project, key, progress.part(0.3, 0.6))
        else:
            leaves_from_labels(project, key, label_field)
        wanted = [
            leaf.key
            for leaf in project.state.leaves_of(key)
            if not chosen or leaf.name in chosen or leaf.key in chosen
        ]
        surfaces += mesh_leaves(project, key, wanted, progress.part(0.6, 0.95))
    write_surfaces(surfaces, out, overwrite)
    return [_tell(surface) for surface in surfaces]


def _tell(surface: LeafSurface) -> Row:
    faces = 0 if surface.mesh is None else len(surface.mesh.faces)
    return {"leaf": surface.key, "name": surface.name, "faces": faces, **tell_area(surface)}


def write_surfaces(surfaces: list[LeafSurface], out: Path, overwrite: bool = False) -> None:
    """Write meshes to one file; raises `BadInput` where there is none."""
    parts = [
        Part(s.name, s.mesh.vertices, s.mesh.faces, to_degrees(s.mesh.omega))
        for s in surfaces
        if s.mesh is not None
    ]
    if not parts:
        why = surfaces[0].reason if surfaces else "No leaf was found."
        raise BadInput(f"No mesh could be made. {why}")
    write_parts(out, parts, overwrite)

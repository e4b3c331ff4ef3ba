"""The leaves of a series as they are in one scan, ready to be carried to the others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.carry import USUAL, Pattern, Tolerance, make_pattern
from app.core.errors import BadInput, WrongUse
from app.core.footprint import leaf_diameter
from app.core.progress import QUIET, Progress
from app.core.sight import View
from app.formats.session import SUFFIX
from app.model.leaf import Leaf
from app.model.points import PointSet
from app.model.project import Project
from app.model.series import Series
from app.services.leaves import find_leaves, leaves_from_labels
from app.services.opening import Opening, open_file
from app.services.sessions import open_session

FIND = "find"


@dataclass(frozen=True, slots=True, eq=False)
class CarriedLeaf:
    """A leaf of the reference scan.

    Attributes
    ----------
    key, name : str
    rows : (k,) int64
        Its points there.
    pattern : Pattern
    diameter : float
        Of the circle that has its area, metres.
    """

    key: str
    name: str
    rows: Ints
    pattern: Pattern
    diameter: float


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Where the leaves of a series come from; it holds their points, not the scan.

    Attributes
    ----------
    file : Path
    points : int
        Of the scan, so that a file of the same name is known to be the same.
    leaves : tuple of CarriedLeaf
    warnings : tuple of str
        Leaves that cannot be carried.
    series : Series or None
        That of the session, where the leaves come from one.
    files : mapping of str to Path
        Of the scans of that series, by key.
    """

    file: Path
    points: int
    leaves: tuple[CarriedLeaf, ...]
    warnings: tuple[str, ...] = ()
    series: Series | None = None
    files: dict[str, Path] = field(default_factory=dict)

    @property
    def patterns(self) -> list[Pattern]:
        """All leaves as they are carried."""
        return [leaf.pattern for leaf in self.leaves]

    def with_normals(self, normals: Mapping[int, Floats]) -> Reference:
        """The same leaves with other normals, by their place: means of many scans."""
        leaves = tuple(
            replace(leaf, pattern=replace(leaf.pattern, normal=normals[number]))
            if number in normals
            else leaf
            for number, leaf in enumerate(self.leaves)
        )
        return replace(self, leaves=leaves)

    def corrections(self, file: Path) -> dict[str, PointSet]:
        """What the session's user said of leaves in one file, by the leaf's key."""
        if self.series is None:
            return {}
        for entry in self.series.entries:
            if same_file(self.files[entry.scan], file):
                return {one.leaf: one.members for one in entry.corrections}
        return {}


def same_file(one: Path, other: Path) -> bool:
    """Whether two paths mean one file, which may have moved since."""
    return one.name == other.name and (one.resolve() == other.resolve() or not one.exists())


def view_scan(project: Project, scan: str) -> View:
    """A scan of a project as its scanner sees it; raises `MissingScanner` without one."""
    state = project.state.scan(scan)
    return View(state.scan.xyz, state.scan.scanner("carrying leaves"), state.alive)


def read_reference(
    leaves: str,
    opening: Opening,
    label_field: str | None = None,
    tolerance: Tolerance = USUAL,
    progress: Progress = QUIET,
) -> Reference:
    """Read the leaves of a series.

    Parameters
    ----------
    leaves : str
        A session with leaves; a scan file with labels; or ``find``.
    opening : Opening
        How scans are read; for ``find`` the scan in which they are looked for.
    label_field : str or None
        Field of a scan file whose whole numbers from 0 on name the leaves.
    tolerance : Tolerance
    progress : Progress

    Raises
    ------
    BadInput
        There is no leaf, or none that can be carried.
    MissingScanner
        The scan does not know where its scanner stood.
    WrongUse
        Leaves are in several scans of a session, or a scan file comes without a label field.
    """
    if Path(leaves).suffix == SUFFIX:
        return _read_session(Path(leaves), tolerance, progress)
    if leaves == FIND:
        project, (key, *_) = open_file(opening, progress.part(0.0, 0.5))
        find_leaves(project, key, progress.part(0.5, 1.0))
    elif label_field is None:
        raise WrongUse(
            f"{leaves} is a scan: say which field names its leaves, with --label-field.",
            "Or give a session with leaves, or the word find.",
        )
    else:
        project, (key, *_) = open_file(opening, progress)
        leaves_from_labels(project, key, label_field)
    return gather_reference(project, key, opening.path, tolerance)


def gather_reference(
    project: Project, scan: str, file: Path, tolerance: Tolerance = USUAL
) -> Reference:
    """The leaves of a scan of a project; raises as `read_reference` does."""
    view = view_scan(project, scan)
    held, warnings = [], []
    for leaf in project.state.leaves_of(scan):
        try:
            held.append(_prepare(view, leaf, tolerance))
        except BadInput as error:
            warnings.append(f"{leaf.name} is left out. {error.what}")
    if not held:
        reason = warnings[0] if warnings else "It has none."
        raise BadInput(f"No leaf of {project.state.scan(scan).scan.name} can be carried. {reason}")
    return Reference(file, len(view.xyz), tuple(held), tuple(warnings))


def _prepare(view: View, leaf: Leaf, tolerance: Tolerance) -> CarriedLeaf:
    rows = alive_rows(view, leaf.members.indices)
    pattern = make_pattern(view, rows, tolerance)
    diameter = leaf_diameter(view.xyz[rows], pattern.normal)
    return CarriedLeaf(leaf.key, leaf.name, rows, pattern, diameter)


def _read_session(path: Path, tolerance: Tolerance, progress: Progress) -> Reference:
    project, _ = open_session(path, progress)
    state = project.state
    series = next(iter(state.series.values()), None) if len(state.series) == 1 else None
    scan = series.reference if series is not None else _only_scan_with_leaves(path, project)
    files = {key: _file_of(project, key) for key in (state.scans if series else ())}
    found = gather_reference(project, scan, _file_of(project, scan), tolerance)
    return replace(found, series=series, files=files)


def _only_scan_with_leaves(path: Path, project: Project) -> str:
    scans = sorted({leaf.scan for leaf in project.state.leaves.values()})
    if len(scans) == 1:
        return scans[0]
    if not scans:
        raise BadInput(f"The session {path.name} has no leaves.", "Lasso some, and save it.")
    names = ", ".join(project.state.scan(key).scan.name for key in scans)
    raise WrongUse(
        f"{path.name} has leaves in {len(scans)} scans ({names}) and no series that says which "
        "to carry.",
        "Make a series in it, or keep the leaves of one scan.",
    )


def _file_of(project: Project, scan: str) -> Path:
    source = project.state.scan(scan).scan.source
    return Path(source.path if source is not None else project.state.scan(scan).scan.name)


def alive_rows(view: View, rows: Ints) -> Ints:
    """Those of the rows that may be used."""
    inside = rows[rows < len(view.usable)]
    return np.asarray(inside[view.usable[inside]])

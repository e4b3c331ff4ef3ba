"""Areas of leaves before a clean-up and after it: whether it makes leaves smaller."""

from __future__ import annotations

from dataclasses import dataclass

from app.core.arrays import AnyArray
from app.core.progress import QUIET, Progress
from app.model.project import Project
from app.services.cleanup.apply import make_step
from app.services.cleanup.plan import Plan
from app.services.surfaces.meshes import measure_areas


@dataclass(frozen=True, slots=True)
class AreaChange:
    """Area of one leaf, as the table of leaves tells it.

    Attributes
    ----------
    key, name : str
    before, after : float or None
        cm²; None where the leaf has no mesh.
    """

    key: str
    name: str
    before: float | None
    after: float | None


def compare_areas(
    project: Project, plan: Plan, answers: AnyArray, progress: Progress = QUIET
) -> tuple[AreaChange, ...]:
    """Mesh the leaves as they are, and as the answers leave them.

    In both no ghost counts, and the border allows for the width of the beam: deleting ghosts
    does not shrink a leaf. The document is as before when this returns, but for a step that could
    be done again.
    """
    leaves = project.state.leaves_of(plan.scan)
    if not leaves:
        return ()
    before = _measure(project, plan.scan, progress.part(0.0, 0.5))
    project.do(make_step(project.state, plan, answers))
    try:
        after = _measure(project, plan.scan, progress.part(0.5, 1.0))
    finally:
        project.undo()
    return tuple(
        AreaChange(leaf.key, leaf.name, before[leaf.key], after[leaf.key]) for leaf in leaves
    )


def _measure(project: Project, scan: str, progress: Progress) -> dict[str, float | None]:
    found = measure_areas(project, scan, project.state.leaves_of(scan), progress)
    areas = {key: row["area_cm2"] for key, row in found.items()}
    return {key: None if area is None else float(area) for key, area in areas.items()}

"""Ghost points of a whole scan: found by score, then marked, deleted or corrected as one step."""

from __future__ import annotations

from app.core.ghosts import SURE
from app.core.progress import QUIET, Progress
from app.model.operations import MarkGhosts, SetDeleted
from app.model.points import PointSet
from app.model.project import Project
from app.model.selection import FieldRange
from app.services.cleanup.answers import Uncertain
from app.services.cleanup.apply import make_step
from app.services.cleanup.plan import plan_cleanup
from app.services.cleanup.statistics import Statistics, sum_up


def find_ghosts(project: Project, scan: str, progress: Progress = QUIET) -> PointSet:
    """Points that count as ghosts now: by the user's marks, else by score and threshold."""
    ghost = project.field(scan, "ghost", None, progress)
    return PointSet.from_mask((ghost == 1.0) & project.state.scan(scan).alive)


def mark_ghosts(project: Project, scan: str, progress: Progress = QUIET) -> int:
    """Mark the ghosts; give their number. Answers that were given stay."""
    ghosts = find_ghosts(project, scan, progress)
    state = project.state.scan(scan)
    threshold = state.parameters.ghost_threshold
    fresh = PointSet(ghosts.indices[state.marks[ghosts.indices] == 0])
    project.do(MarkGhosts(scan, ghosts=fresh, basis=FieldRange("ghost_score", threshold, 1.0)))
    return len(ghosts)


def delete_ghosts(project: Project, scan: str, progress: Progress = QUIET) -> int:
    """Delete the ghosts (a mask: undo brings them back); give their number."""
    ghosts = find_ghosts(project, scan, progress)
    project.do(SetDeleted(scan, ghosts, True, FieldRange("ghost", 1.0, 1.0)))
    return len(ghosts)


def correct_ghosts(project: Project, scan: str, progress: Progress = QUIET) -> tuple[int, int]:
    """Put ghosts back on the surface that owns most of their beam, where that is sure enough.

    Returns
    -------
    corrected, left : int
        Ghosts that were moved, and the others, which stay marked.
    """
    counts = clean_up(project, scan, uncertain="mark", progress=progress).by_answer
    return counts["corrected"], counts["left marked"]


def clean_up(
    project: Project, scan: str, sure: float = SURE, uncertain: Uncertain = "delete",
    progress: Progress = QUIET,
) -> Statistics:  # fmt: skip
    """Correct ghosts where that is sure, delete the others or leave them marked, as one step.

    What the user has answered by hand is done as he wants it.

    Parameters
    ----------
    sure : float
        Confidence from which a ghost is corrected, 0 to 1.
    uncertain : {'delete', 'mark'}
        What becomes of the others.

    Raises
    ------
    WrongUse, MissingScanner, Cancelled
    """
    plan = plan_cleanup(project, scan, sure, uncertain, progress)
    state = project.state.scan(scan)
    answers = plan.answers(state.marks)
    project.do(make_step(project.state, plan, answers))
    return sum_up(plan, answers, state.alive)

"""What was measured of each leaf of the current scan."""

from __future__ import annotations

from collections.abc import Hashable

from app.core.progress import Progress
from app.model.leaf import Leaf, join_members
from app.model.project import Project
from app.model.state import ScanState
from app.services.leaves import Row, measure_leaves
from widgets.common.leaf_cache import LeafCache, mark_leaf
from widgets.controller import Then

FIELD = "incidence"


class LeafMeasures(LeafCache[Row]):
    """Rows of `measure_leaves`."""

    def title(self) -> str:
        """What is being done."""
        return self.tr("Measuring leaves")

    def mark(self, leaf: Leaf, state: ScanState) -> Hashable:
        """All that the numbers of a leaf depend on, apart from deletions elsewhere."""
        parameters = state.parameters
        return (
            mark_leaf(leaf, state), state.channels, parameters.radiometry, parameters.radius,
            parameters.estimator, parameters.plane_gate,
        )  # fmt: skip

    def prepare(self, scan: str, state: ScanState, leaves: list[Leaf], then: Then) -> None:
        """Angles of living points of these leaves, of no others."""
        points = join_members(leaves, len(state.scan))
        self.controller.want(scan, FIELD, points[state.alive[points]], then)

    def compute(
        self, project: Project, scan: str, keys: list[str], progress: Progress
    ) -> dict[str, Row]:
        """A row for each leaf."""
        return {str(row["leaf"]): row for row in measure_leaves(project, scan, keys, progress)}

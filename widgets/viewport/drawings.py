"""What is drawn over the points of the 3-D view; every change begins a new picture."""

from __future__ import annotations

from app.core.arrays import Floats
from app.render.drawings import Triangles
from app.render.stage import Stage
from widgets.viewport.refinement import Refinement


class ViewDrawings:
    """Passes what is to be drawn on to the stage, and has the picture drawn again."""

    def __init__(self, stage: Stage, refinement: Refinement) -> None:
        self._stage, self._refinement = stage, refinement

    def show_rings(self, corners: Floats | None) -> None:
        """Draw closed lines over the points, (k, n, 3) world metres; None takes them away."""
        self._stage.drawings.show_rings(corners)
        self._draw()

    def show_marks(self, corners: Floats | None) -> None:
        """Point something out by closed lines, (k, n, 3) world metres; None takes them away."""
        self._stage.drawings.show_marks(corners)
        self._draw()

    def show_seeds(self, corners: Floats | None) -> None:
        """Ring the seeds of leaves, (k, n, 3) world metres; None takes the rings away."""
        self._stage.drawings.show_seeds(corners)
        self._draw()

    def show_mesh(self, triangles: Triangles | None) -> None:
        """Draw the mesh of a leaf; None takes it away."""
        self._stage.drawings.show_mesh(triangles)
        self._draw()

    def _draw(self) -> None:
        self._stage.reset_clipping()
        self._refinement.begin()

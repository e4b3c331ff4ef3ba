"""Draw an upright rectangle around points."""

from __future__ import annotations

from typing import ClassVar

from widgets.viewport.tools.lasso import STEP, Lasso
from widgets.viewport.tools.tool import Pointer


class Rectangle(Lasso):
    """A lasso with four corners; the same keys, and the same use."""

    name: ClassVar[str] = "rectangle"

    def move(self, at: Pointer) -> None:
        """Pull the corner opposite to the first."""
        start = self._last
        if start is None:
            return
        if max(abs(shift) for shift in at.pixels_from(start)) < STEP:
            self._corners = [(start.x, start.y)]
        else:
            self._corners = [(start.x, start.y), (at.x, start.y), (at.x, at.y), (start.x, at.y)]
        self._view.refresh_overlay()

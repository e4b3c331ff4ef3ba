"""Views that show everything wanted, beside the colour bar rather than under it."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QWidget

from app.core.arrays import Floats
from app.render.camera import Camera, fit_points, look_at_points, look_from, make_room
from widgets.viewport.canvas import Canvas

EDGE = 12  # pixels between the colour bar and the border
MOST_ROOM = 0.4


class Framing:
    """Works out cameras for a canvas with a bar at its right edge."""

    def __init__(self, canvas: Canvas, bar: QWidget, extent: Callable[[], Floats]) -> None:
        self._canvas, self._bar, self._extent = canvas, bar, extent
        self._make: Callable[[float], Camera] | None = None

    def around(self, camera: Camera, points: Floats) -> Camera:
        """Points, (k, 3) world metres, from the direction of `camera`."""
        flat = camera.parallel_scale is not None
        return self._keep(lambda aspect: fit_points(camera, points, aspect, flat))

    def from_scanner(self, scanner: Floats) -> Camera:
        """What the scanner saw."""
        return self._keep(lambda aspect: look_from(scanner, self._extent(), aspect))

    def standard(self, name: str, orthographic: bool) -> Camera:
        """Everything from one of the standard directions."""
        return self._keep(lambda aspect: look_at_points(self._extent(), name, aspect, orthographic))

    def again(self) -> Camera | None:
        """The last of these for the canvas as it is now; None once the view was turned."""
        return None if self._make is None else self._beside(self._make(self._free_aspect))

    def forget(self) -> None:
        """The view was turned by hand: its size no longer says where to look from."""
        self._make = None

    def _keep(self, make: Callable[[float], Camera]) -> Camera:
        self._make = make
        return self._beside(make(self._free_aspect))

    @property
    def _share(self) -> float:
        covered = self._bar.sizeHint().width() + 2 * EDGE
        return min(covered / max(int(self._canvas.width()), 1), MOST_ROOM)

    @property
    def _free_aspect(self) -> float:
        return self._canvas.aspect() * (1.0 - self._share)

    def _beside(self, camera: Camera) -> Camera:
        return make_room(camera, self._share, self._canvas.aspect())

"""From world coordinates to pixels, given a camera as one matrix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from app.core.arrays import AnyArray, Bools, Floats, read_only
from app.core.errors import BadInput

Row = tuple[float, float, float, float]
Pixels = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class View:
    """A camera and its viewport, in plain numbers that can be stored and replayed.

    Attributes
    ----------
    origin : (x, y, z)
        Local origin in world metres; the matrix acts on world − origin.
    matrix : 4 rows of 4 floats
        World to clip coordinates for column vectors, as OpenGL has them: a drawn point has
        −w ≤ x, y, z ≤ w, with z growing away from the viewer. Near and far planes are part of
        it: what they cut off is neither drawn nor selected.
    size : (width, height)
        Pixels of the viewport.
    """

    origin: tuple[float, float, float]
    matrix: tuple[Row, Row, Row, Row]
    size: tuple[int, int]

    def __post_init__(self) -> None:
        rows, origin = np.asarray(self.matrix), np.asarray(self.origin)
        if rows.shape != (4, 4) or origin.shape != (3,):
            raise BadInput("A view needs a 4 × 4 matrix and an origin of three numbers.")
        if not (np.isfinite(rows).all() and np.isfinite(origin).all()):
            raise BadInput("The matrix or the origin of the view holds NaN or infinity.")
        if np.linalg.det(np.vstack([rows[:2, :3], _depth_row(rows)[:3]])) == 0.0:
            raise BadInput("The matrix of the view flattens space; it shows nothing.")
        if min(self.size) < 1:
            raise BadInput(f"A viewport of {self.size[0]} × {self.size[1]} pixels is empty.")

    @classmethod
    def of(cls, origin: Any, matrix: Any, size: tuple[int, int]) -> View:
        """The same from arrays."""
        rows = tuple(tuple(float(v) for v in row) for row in np.asarray(matrix))
        return cls(tuple(float(v) for v in origin), rows, (int(size[0]), int(size[1])))  # type: ignore[arg-type]

    def pixel_size(self, depth: float) -> float:
        """Height of a pixel in metres, at a view depth in metres."""
        rows = np.asarray(self.matrix)
        up, forward = np.linalg.norm(rows[1, :3]), np.linalg.norm(rows[3, :3])
        distance = depth * forward if _is_perspective(rows) else rows[3, 3]
        return float(2.0 * distance / (up * self.size[1]))


class Projected(NamedTuple):
    """Where points land on the screen.

    Attributes
    ----------
    px : (n, 2) float32
        Pixels from the upper left corner, x to the right, y **down**; pixel 0 covers [0, 1).
        NaN behind the camera and for points that are not finite.
    depth : (n,) float32
        Metres along the viewing direction; from the eye in perspective, from an arbitrary
        zero in an orthographic view. NaN where `px` is.
    inside : (n,) bool
        Inside the frustum.
    """

    px: Pixels
    depth: Pixels
    inside: Bools


def project(xyz: Floats, origin: Any, matrix: Any, size: tuple[int, int]) -> Projected:
    """Project points to the screen; perspective and orthographic follow from the matrix.

    Parameters
    ----------
    xyz : (n, 3) float64 array
        World metres.
    origin, matrix, size
        As in `View`.

    Returns
    -------
    Projected

    Raises
    ------
    BadInput
        What `View` refuses.
    """
    from app.core.kernels import screen

    View.of(origin, matrix, size)  # refuses what is no view
    n = len(xyz)
    px, depth = np.empty((n, 2), np.float32), np.empty(n, np.float32)
    inside = np.empty(n, np.bool_)
    rows = np.ascontiguousarray(matrix, dtype=np.float64)
    depth_row = _depth_row(rows)
    unit_depth = depth_row / np.linalg.norm(depth_row[:3])
    screen.project(
        for_kernel(xyz, np.float64),
        for_kernel(origin, np.float64),
        read_only(rows),
        read_only(unit_depth),
        float(size[0]),
        float(size[1]),
        px,
        depth,
        inside,
    )
    return Projected(px, depth, inside)


def for_kernel(array: Any, dtype: Any) -> AnyArray:
    """Contiguous and read-only: numba compiles a kernel anew for every other flavour."""
    return read_only(np.ascontiguousarray(array, dtype=dtype))


def _is_perspective(rows: Floats) -> bool:
    # Exactly zero in an orthographic matrix, 1 in a perspective one; scaled by the first row.
    return bool(np.linalg.norm(rows[3, :3]) > 1e-9 * np.linalg.norm(rows[0, :3]))


def _depth_row(rows: Floats) -> Floats:
    """Coefficients that grow along the viewing direction: w in perspective, else z."""
    row: Floats = rows[3] if _is_perspective(rows) else rows[2]
    return row

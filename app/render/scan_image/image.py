"""Which point each pixel shows, at every size at which the picture may be drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.screen.lasso import rasterise_polygon
from app.render.scan_image.layout import Layout

SMALLEST = 32
NOBODY = np.uint64(2**64 - 1)
INDEX_BITS = np.uint64(32)


@dataclass(frozen=True, slots=True, eq=False)
class ScanImage:
    """The nearest point in each pixel.

    Attributes
    ----------
    layout : Layout
    alive : (n,) bool
        Points that are shown: finite and not deleted.
    place : (n,) int32
        The pixel of each of these, −1 for the others.
    levels : tuple of (rows, columns) int32
        Number of the nearest point, −1 without one; each level has half the rows and
        columns of the one before, and shows the nearest of four.
    silent : tuple of (rows, columns) bool
        Pixels without a point, in which the file records a beam without an echo.
    depth : (float, float)
        Metres to the nearest and to the farthest point.
    """

    layout: Layout
    alive: Bools
    place: AnyArray
    levels: tuple[AnyArray, ...]
    silent: tuple[Bools, ...]
    depth: tuple[float, float]

    @property
    def shown(self) -> int:
        """Number of points in the picture."""
        return int(np.count_nonzero(self.levels[0] >= 0))

    def point_at(self, row: int, column: int) -> int:
        """Number of the point that a pixel shows, −1 without one or outside the picture."""
        inside = 0 <= row < self.layout.rows and 0 <= column < self.layout.columns
        return int(self.levels[0][row, column]) if inside else -1

    def points_at(self, row: int, column: int) -> Ints:
        """All points of a pixel, deleted ones too."""
        return np.flatnonzero(self.layout.pixel == row * self.layout.columns + column)

    def pixel_of(self, point: int) -> tuple[int, int] | None:
        """Row and column of a point, None for one without a direction."""
        pixel = int(self.layout.pixel[point])
        return None if pixel < 0 else divmod(pixel, self.layout.columns)

    def points_in(self, polygon: Floats) -> Ints:
        """All points that are shown or hidden behind others in the pixels of a region.

        Parameters
        ----------
        polygon : (k, 2) array
            Corners as column and row, (0, 0) the upper left corner of the picture. A pixel
            belongs to the region when its centre does.

        Returns
        -------
        (m,) int64, ascending
        """
        layout = self.layout
        # One place more than pixels: points without a pixel, −1, look there.
        region = np.zeros(layout.rows * layout.columns + 1, bool)
        corners = np.clip(polygon, -1.0, (layout.columns + 1.0, layout.rows + 1.0))
        left, upper = np.floor(corners.min(axis=0)).astype(int).clip(0)
        right, lower = np.ceil(corners.max(axis=0)).astype(int)
        right, lower = min(right, layout.columns), min(lower, layout.rows)
        if right <= left or lower <= upper:
            return np.empty(0, np.int64)
        inside = rasterise_polygon(corners - (left, upper), (right - left, lower - upper))
        picture = region[:-1].reshape(layout.rows, layout.columns)
        picture[upper:lower, left:right] = inside
        return np.flatnonzero(region.take(self.place, mode="wrap"))

    def light(self, points: Ints) -> Bools:
        """Pixels that hold at least one of the points and show one, (rows, columns)."""
        lit = np.zeros(self.layout.rows * self.layout.columns + 1, bool)
        lit[self.place.take(points)] = True
        return lit[:-1].reshape(self.levels[0].shape)


def make_image(layout: Layout, alive: Bools) -> ScanImage:
    """Find the nearest point of each pixel.

    Parameters
    ----------
    layout : Layout
    alive : (n,) bool
        Points that are shown; deleted ones hide nothing.
    """
    place = np.where(alive, layout.pixel, np.int32(-1))
    points = np.flatnonzero(place >= 0)
    # Distances are positive, so that their bits are in the order of their values.
    front = np.full(layout.rows * layout.columns, NOBODY)
    distance = layout.distance.take(points)
    bits = distance.view(np.uint32).astype(np.uint64) << INDEX_BITS
    np.minimum.at(front, place.take(points), bits | points.astype(np.uint64))
    fronts: list[AnyArray] = [front.reshape(layout.rows, layout.columns)]
    beams = [layout.no_return]
    while max(fronts[-1].shape) > SMALLEST:
        fronts.append(_halve(fronts[-1], NOBODY, np.minimum))
        beams.append(halve_marks(beams[-1]))
    silent = tuple(beam & (near == NOBODY) for near, beam in zip(fronts, beams, strict=True))
    depth = (float(distance.min()), float(distance.max())) if len(points) else (0.0, 1.0)
    levels = tuple(_numbers(near) for near in fronts)
    return ScanImage(layout, alive, place, levels, silent, depth)


def halve_marks(marks: Bools) -> Bools:
    """Half the rows and columns; a pixel is marked where one of four is."""
    return _halve(marks, False, np.logical_or)


def _halve(picture: AnyArray, beyond: object, join: np.ufunc) -> AnyArray:
    odd = [(0, side % 2) for side in picture.shape]
    if any(more for _, more in odd):
        picture = np.pad(picture, odd, constant_values=beyond)  # type: ignore[call-overload]
    lines = join(picture[::2], picture[1::2])
    halved: AnyArray = join(lines[:, ::2], lines[:, 1::2])
    return halved


def _numbers(front: AnyArray) -> AnyArray:
    numbers: AnyArray = (front & np.uint64(2**32 - 1)).astype(np.uint32).view(np.int32)
    return numbers  # nobody is 2³² − 1, which is −1 here

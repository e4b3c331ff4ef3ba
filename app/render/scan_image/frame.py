"""Which part of the scan image is seen, and at what size."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from app.render.scan_image.image import ScanImage
from app.render.scan_image.layout import Layout
from app.render.scan_image.paint import Part

LARGEST = 64.0
"""Height of a pixel of the picture on the screen beyond which nothing more can be seen."""
TILE = 64
"""Parts that are drawn begin and end at multiples of it, so that a small move draws nothing."""
Size = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Frame:
    """Where the picture lies in a view.

    Attributes
    ----------
    left, top : float
        Place of its upper left corner in the view.
    wide, high : float
        Size of one of its pixels in the view.
    """

    left: float
    top: float
    wide: float
    high: float

    @classmethod
    def fit(cls, layout: Layout, size: Size) -> Frame:
        """All of the picture, in the middle, in the proportions in which the scanner saw it."""
        high = min(size[0] / (layout.columns * layout.shape), size[1] / layout.rows, LARGEST)
        high = max(high, 1e-6)
        wide = high * layout.shape
        left = (size[0] - wide * layout.columns) / 2
        return cls(left, (size[1] - high * layout.rows) / 2, wide, high)

    def to_image(self, x: float, y: float) -> tuple[float, float]:
        """Column and row at a place of the view, with fractions."""
        return (x - self.left) / self.wide, (y - self.top) / self.high

    def to_view(self, column: float, row: float) -> tuple[float, float]:
        """Place in the view of a column and row."""
        return self.left + column * self.wide, self.top + row * self.high

    def move(self, x: float, y: float) -> Frame:
        """The same picture, moved in the view."""
        return replace(self, left=self.left + x, top=self.top + y)

    def zoom(self, factor: float, x: float, y: float) -> Frame:
        """Larger or smaller; what is at a place of the view stays there."""
        factor = min(factor, LARGEST / self.high)
        left, top = x - (x - self.left) * factor, y - (y - self.top) * factor
        return Frame(left, top, self.wide * factor, self.high * factor)

    def keep(self, layout: Layout, size: Size) -> Frame:
        """The nearest frame that shows something: not too small, and not out of sight."""
        whole = Frame.fit(layout, size)
        if self.high < whole.high:
            return whole
        wide, high = self.wide * layout.columns, self.high * layout.rows
        left = _hold(self.left, wide, size[0])
        return replace(self, left=left, top=_hold(self.top, high, size[1]))

    def choose_level(self, image: ScanImage, scale: float = 1.0) -> int:
        """The level whose pixels come nearest to those of the screen, `scale` per unit."""
        side = math.sqrt(self.wide * self.high) * scale
        level = round(math.log2(1.0 / side)) if side < 1.0 else 0
        return min(max(level, 0), len(image.levels) - 1)

    def find_part(self, image: ScanImage, level: int, size: Size) -> Part:
        """What a view of that size sees of a level, rounded up to whole tiles."""
        rows, columns = image.levels[level].shape
        left, top = self.to_image(0.0, 0.0)
        right, bottom = self.to_image(*size)
        across, down = _cut(left, right, columns, level), _cut(top, bottom, rows, level)
        return slice(*down), slice(*across)

    def place_part(self, level: int, part: Part) -> tuple[float, float, float, float]:
        """Left, top, width and height of a part of a level in the view."""
        side = 2**level
        left, top = self.to_view(part[1].start * side, part[0].start * side)
        right, bottom = self.to_view(part[1].stop * side, part[0].stop * side)
        return left, top, right - left, bottom - top


def _hold(start: float, length: float, room: float) -> float:
    """Keep a side in sight: in the middle when there is room, else without a gap beside it."""
    if length <= room:
        return (room - length) / 2
    return min(max(start, room - length), 0.0)


def _cut(start: float, stop: float, lines: int, level: int) -> tuple[int, int]:
    first = math.floor(start / 2**level / TILE) * TILE
    last = math.ceil(stop / 2**level / TILE) * TILE
    first = min(max(first, 0), lines)
    return first, min(max(last, first), lines)

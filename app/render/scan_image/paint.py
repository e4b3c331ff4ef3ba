"""Colours of a part of the scan image: the same as in the 3-D view."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from app.core.arrays import AnyArray, Bools, Ints
from app.model.scene import ColourBar
from app.render.overlay import SELECTED, Overlay, number_marks
from app.render.palettes import (
    BACKGROUNDS,
    MISSING,
    PLAIN,
    Background,
    Rgb,
    colour_table,
    is_categorical,
    table_rows,
)
from app.render.scan_image.image import ScanImage, halve_marks

NO_VALUE, NO_RETURN, NOTHING = 256, 257, 258
HAZE = 0.72
SILENT: dict[Background, Rgb] = {"light": (198, 209, 224), "dark": (48, 60, 82)}
"""Beams that came back without an echo: between the ground and all colours of points."""
Part = tuple[slice, slice]


@dataclass(slots=True, eq=False)
class Paint:
    """What the points look like; whoever changes one part leaves the others alone.

    Attributes
    ----------
    background : {'light', 'dark'}
    bar : ColourBar or None
        None for plain points, which fade with distance.
    values : (n,) array or None
        The field of the colour bar, NaN where it is unknown.
    codes : (n,) uint8, and marks : (256, 4) uint8
        Leaves and ghosts, see `number_marks`.
    lit : list of (rows, columns) bool
        Pixels with selected points, as far as levels were asked for.
    """

    background: Background = "light"
    bar: ColourBar | None = None
    values: AnyArray | None = None
    codes: AnyArray | None = None
    marks: AnyArray = field(default_factory=lambda: number_marks(Overlay(), 0)[1])
    lit: list[Bools] = field(default_factory=list)
    _table: AnyArray | None = None

    def use_colours(self, bar: ColourBar | None, values: AnyArray | None) -> None:
        """Colour by a field, or (None) by distance alone."""
        self.bar, self.values = (bar, values) if values is not None else (None, None)
        self._table = None

    def use_background(self, background: Background) -> None:
        """Light or dark."""
        self.background = background
        self._table = None

    def use_marks(self, overlay: Overlay, size: int) -> None:
        """Lay leaves and ghosts over the colours; the selection has `select`."""
        plain = Overlay(leaves=overlay.leaves, ghosts=overlay.ghosts, current=overlay.current)
        codes, self.marks = number_marks(plain, size)
        self.codes = codes if codes.any() else None
        self._table = None

    def select(self, image: ScanImage, points: Ints) -> None:
        """Light up the pixels that hold selected points, also those behind others."""
        self.use_lit(image.light(points) if len(points) else None)

    def use_lit(self, lit: Bools | None) -> None:
        """Light up pixels that were found before, see `ScanImage.light`; None: nothing."""
        self.lit = [] if lit is None else [lit]

    def draw(self, image: ScanImage, level: int, part: Part) -> AnyArray:
        """Colours of a part of one level, (h, w) uint32 as 0xffRRGGBB."""
        index = image.levels[level][part]
        row = self._value_rows(image, index)
        empty = index < 0
        row[empty] = NOTHING
        row[image.silent[level][part]] = NO_RETURN
        place = row * 256
        if self.codes is not None:
            place += np.where(empty, 0, self.codes.take(index, mode="clip"))
        if self.lit:
            marked = self._lit_at(level)[part] & ~empty
            place[marked] = row[marked] * 256 + SELECTED
        drawn: AnyArray = self._colours().take(place)
        return drawn

    def _value_rows(self, image: ScanImage, index: AnyArray) -> AnyArray:
        bar = self.bar
        if bar is None or self.values is None:
            values: AnyArray = image.layout.distance.take(index, mode="clip")
            return table_rows(values, *image.depth, False).astype(np.int32)
        values = self.values.take(index, mode="clip").astype(np.float32)
        known = np.isfinite(values)
        values[~known] = bar.low
        row = table_rows(values, bar.low, bar.high, is_categorical(bar.map)).astype(np.int32)
        row[~known] = NO_VALUE
        return row

    def _lit_at(self, level: int) -> Bools:
        while len(self.lit) <= level:
            self.lit.append(halve_marks(self.lit[-1]))
        return self.lit[level]

    def _colours(self) -> AnyArray:
        """Every value row under every mark, flat: 259 · 256 colours."""
        if self._table is None:
            base = np.vstack((self._base(), *([colour] for colour in self._others())))
            strength = self.marks[:, 3:].astype(np.float64) / 255.0
            mixed = base[:, None] * (1.0 - strength) + self.marks[:, :3] * strength
            red, green, blue = np.moveaxis(np.round(mixed).astype(np.uint32), 2, 0)
            opaque = np.uint32(0xFF000000)
            self._table = (opaque | red << 16 | green << 8 | blue).ravel()
        return self._table

    def _base(self) -> AnyArray:
        if self.bar is not None:
            return colour_table(self.bar.map)[:, :3].astype(np.float64)
        near, far = (
            np.array(colour, np.float64)
            for colour in (PLAIN[self.background], BACKGROUNDS[self.background][1])
        )
        share = np.linspace(0.0, HAZE, 256)[:, None]
        return near * (1.0 - share) + far * share

    def _others(self) -> tuple[Rgb, ...]:
        ground = BACKGROUNDS[self.background][1]
        return MISSING[self.background], SILENT[self.background], ground

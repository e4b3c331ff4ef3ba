"""Marks over the colours: selection, leaves and ghosts as one small number per point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from app.core.arrays import AnyArray, Ints
from app.render.palettes import Bytes, Rgb

GHOST, SELECTED, FIRST_LEAF = 1, 2, 8
GHOST_COLOUR = (224, 74, 16, 235)
SELECTED_COLOUR = (236, 0, 140, 215)
LEAF_STRENGTH, CURRENT_STRENGTH = 190, 255


class LeafMark(NamedTuple):
    """A leaf in the picture: its key, its points and its colour."""

    key: str
    members: Ints
    colour: Rgb


@dataclass(frozen=True, slots=True, eq=False)
class Overlay:
    """What lies over the colours of a cloud.

    Attributes
    ----------
    selection : (m,) int64
        Selected points.
    leaves : sequence of LeafMark
    ghosts : (n,) int8 or None
        Above 0 where a point is marked as ghost.
    current : str or None
        Key of the leaf that stands out among the others.
    """

    selection: Ints = field(default_factory=lambda: np.empty(0, np.int64))
    leaves: Sequence[LeafMark] = ()
    ghosts: AnyArray | None = None
    current: str | None = None


def number_marks(overlay: Overlay, size: int) -> tuple[Bytes, Bytes]:
    """Turn an overlay into codes and their colours; later marks hide earlier ones.

    Returns
    -------
    codes : (size,) uint8
        Zero where nothing lies over the colour.
    table : (256, 4) uint8
        Colour of each code; its alpha is the strength of the mark.
    """
    codes = np.zeros(size, np.uint8)
    table = np.zeros((256, 4), np.uint8)
    table[GHOST], table[SELECTED] = GHOST_COLOUR, SELECTED_COLOUR
    by_colour: dict[tuple[int, ...], int] = {}
    for leaf in overlay.leaves:
        strength = CURRENT_STRENGTH if leaf.key == overlay.current else LEAF_STRENGTH
        rgba = (*leaf.colour, strength)
        # Leaves share codes by colour: 247 colours are more than any eye tells apart.
        code = by_colour.setdefault(rgba, FIRST_LEAF + len(by_colour) % (256 - FIRST_LEAF))
        table[code] = rgba
        codes[leaf.members] = code
    if overlay.ghosts is not None:
        codes[overlay.ghosts > 0] = GHOST
    codes[overlay.selection] = SELECTED
    return codes, table

"""Boxes around surfaces, and the hierarchy of boxes that a beam walks through."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from app.core.arrays import Floats
from app.simulate.beam import Bundle
from app.simulate.surfaces import Leaf, Scene

if TYPE_CHECKING:
    from app.core.kernels.boxes import TreeTable

FEW = 3
"""Surfaces that are not split any further."""


def enclose(scene: Scene) -> tuple[Floats, Floats]:
    """Lowest and highest corner of each surface's box, (surfaces, 3) metres each.

    Leaves, then stems, then walls; the room in which a leaf sways is part of its box.
    """
    boxes = [_enclose_leaf(leaf) for leaf in scene.leaves]
    for stem in scene.stems:
        ends = np.array([stem.start, stem.end], float)
        boxes.append((ends.min(axis=0) - stem.radius, ends.max(axis=0) + stem.radius))
    for wall in scene.walls:
        half = np.abs(np.array([wall.across, wall.up], float)).sum(axis=0)
        boxes.append((np.array(wall.centre) - half, np.array(wall.centre) + half))
    corners = np.array(boxes, float).reshape(-1, 2, 3)
    return corners[:, 0], corners[:, 1]


def _enclose_leaf(leaf: Leaf) -> tuple[Floats, Floats]:
    low, high = leaf.slab()
    frame = np.abs(leaf.frame())
    across = leaf.width / 2 * (1 + abs(leaf.taper))
    half = frame[0] * leaf.length / 2 + frame[1] * across + frame[2] * max(-low, high)
    half = half + np.abs(leaf.sway)
    return np.array(leaf.centre) - half, np.array(leaf.centre) + half


def widen(corners: tuple[Floats, Floats], bundle: Bundle, origin: Floats) -> tuple[Floats, Floats]:
    """Boxes with the beam's radius at their far side added all around.

    A sub-ray that meets a surface then has its central ray inside the wider box.
    """
    low, high = corners
    away = np.maximum(np.abs(low - origin), np.abs(high - origin))
    farthest = np.linalg.norm(away, axis=1)
    radius = bundle.exit_diameter / 2 + farthest * np.tan(bundle.half_divergence)
    return low - radius[:, None], high + radius[:, None]


def plant_tree(low: Floats, high: Floats, split: bool = True) -> TreeTable:
    """A binary hierarchy over boxes, halved at the median along the longest side.

    Parameters
    ----------
    low, high : (n, 3) arrays
        Corners of the boxes, already widened.
    split : bool
        False: one node with all surfaces, the plain loop that the tree is measured against.
    """
    from app.core.kernels.boxes import TreeTable

    middle = (low + high) / 2
    order = np.arange(len(low))
    first, count = [0], [len(low)]
    waiting = [0] if split else []
    while waiting:
        node = waiting.pop()
        start, total = first[node], count[node]
        if total <= FEW:
            continue
        mine = order[start : start + total]
        axis = int(np.argmax(np.ptp(middle[mine], axis=0)))
        half = total // 2
        order[start : start + total] = mine[np.argpartition(middle[mine, axis], half)]
        child = len(first)
        first += [start, start + half]
        count += [half, total - half]
        first[node], count[node] = child, 0
        waiting += [child, child + 1]
    corners = _bound_nodes(low[order], high[order], np.array(first), np.array(count))
    return TreeTable(*corners, np.array(first), np.array(count), order, low, high)


def _bound_nodes(low: Floats, high: Floats, first: Floats, count: Floats) -> tuple[Floats, Floats]:
    """Boxes of the nodes; children come after their parent, so they are done first."""
    bottom, top = np.full((len(first), 3), np.inf), np.full((len(first), 3), -np.inf)
    for node in range(len(first) - 1, -1, -1):
        start = int(first[node])
        if count[node]:
            members = slice(start, start + int(count[node]))
            bottom[node], top[node] = low[members].min(axis=0), high[members].max(axis=0)
        elif start:
            pair = slice(start, start + 2)
            bottom[node], top[node] = bottom[pair].min(axis=0), top[pair].max(axis=0)
    return bottom, top

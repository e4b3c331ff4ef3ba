"""Boxes around surfaces, and the hierarchy of boxes that a beam walks through."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from app.core.arrays import Floats
from app.simulate.beam import Bundle
from app.simulate.surfaces import Leaf, Scene, stack_frames

if TYPE_CHECKING:
    from app.core.kernels.boxes import TreeTable

FEW = 3
"""Surfaces that are not split any further."""


def enclose(scene: Scene) -> tuple[Floats, Floats]:
    """Lowest and highest corner of each surface's box, (surfaces, 3) metres each.

    Leaves, then stems, then walls; the room in which a leaf sways is part of its box.
    """
    boxes = []
    for stem in scene.stems:
        ends = np.array([stem.start, stem.end], float)
        boxes.append((ends.min(axis=0) - stem.radius, ends.max(axis=0) + stem.radius))
    for wall in scene.walls:
        half = np.abs(np.array([wall.across, wall.up], float)).sum(axis=0)
        boxes.append((np.array(wall.centre) - half, np.array(wall.centre) + half))
    corners = np.array(boxes, float).reshape(-1, 2, 3)
    low, high = _enclose_leaves(scene.leaves)
    return np.concatenate([low, corners[:, 0]]), np.concatenate([high, corners[:, 1]])


def _enclose_leaves(leaves: tuple[Leaf, ...]) -> tuple[Floats, Floats]:
    sizes = [
        (s.length / 2, s.width / 2 * (1 + abs(s.taper)), max(map(abs, s.slab()))) for s in leaves
    ]
    size = np.array(sizes, float).reshape(-1, 3, 1)
    half = (np.abs(stack_frames(leaves)) * size).sum(axis=1)
    half += np.abs(np.array([s.sway for s in leaves], float).reshape(-1, 3))
    centre = np.array([s.centre for s in leaves], float).reshape(-1, 3)
    return centre - half, centre + half


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

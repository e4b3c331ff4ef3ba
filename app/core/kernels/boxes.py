"""A bounding hierarchy, walked front to back: what lies behind a full hit is never looked at."""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER
from app.core.kernels.surfaces import meet_surface

DEEPEST = 64
BARRED = 1e300
"""Stands for 1 / 0: a product with it is huge or zero, never NaN."""


class TreeTable(NamedTuple):
    """Boxes within boxes. They are widened by the beam's radius at their far side."""

    low: Any  # (nodes, 3) m
    high: Any  # (nodes, 3) m
    first: Any  # (nodes,) the first of two children, or of the surfaces in `order`
    count: Any  # (nodes,) surfaces; 0 for a node with children
    order: Any  # (surfaces,)
    own_low: Any  # (surfaces, 3) m: box of each surface
    own_high: Any


@njit(**INNER)
def invert(d):  # type: ignore[no-untyped-def]
    """One over each component of a direction."""
    return (
        1.0 / d[0] if d[0] != 0.0 else BARRED,
        1.0 / d[1] if d[1] != 0.0 else BARRED,
        1.0 / d[2] if d[2] != 0.0 else BARRED,
    )


@njit(**INNER)
def enter_box(low, high, i, o, inverse):  # type: ignore[no-untyped-def]
    """Distance at which a ray enters box i, 0 from inside; inf when it misses."""
    near, far = 0.0, np.inf
    for axis in range(3):
        a = (low[i, axis] - o[axis]) * inverse[axis]
        b = (high[i, axis] - o[axis]) * inverse[axis]
        near = max(near, min(a, b))
        far = min(far, max(a, b))
    return near if near <= far else np.inf


@njit(**INNER)
def farthest(distance):  # type: ignore[no-untyped-def]
    """Distance beyond which nothing can change the hits; inf while a sub-ray is free."""
    most = 0.0
    for k in range(len(distance)):
        most = max(most, distance[k])
    return most


@njit(**INNER)
def meet_tree(table, tree, column, axes, beam, hits, stack, entry):  # type: ignore[no-untyped-def]
    """Nearest crossing of each sub-ray of a beam, into `hits`."""
    hits.distance[:] = np.inf
    hits.surface[:] = -1
    if len(tree.order) == 0:
        return
    low, high, children, members = tree.low, tree.high, tree.first, tree.count
    o, inverse = axes[0], invert(axes[1])
    far = np.inf
    stack[0], entry[0] = 0, enter_box(low, high, 0, o, inverse)
    depth = 1
    while depth > 0:
        depth -= 1
        node = stack[depth]
        if entry[depth] >= far:
            continue
        first = children[node]
        if members[node] > 0:
            for k in range(first, first + members[node]):
                surface = tree.order[k]
                if enter_box(tree.own_low, tree.own_high, surface, o, inverse) < far:
                    meet_surface(table, surface, column, axes, beam, hits)
                    far = farthest(hits.distance)
            continue
        a = enter_box(low, high, first, o, inverse)
        b = enter_box(low, high, first + 1, o, inverse)
        swap = 1 if a < b else 0
        # The nearer child goes on top of the stack.
        if max(a, b) < far:
            stack[depth], entry[depth] = first + swap, max(a, b)
            depth += 1
        if min(a, b) < far:
            stack[depth], entry[depth] = first + 1 - swap, min(a, b)
            depth += 1

"""Points of several leaves together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.core.arrays import Ints
from app.model.leaf import Leaf


def join_members(leaves: Sequence[Leaf], size: int) -> Ints:
    """Points of leaves in rising order, each once; `size` is the number of points of the scan.

    By a mask: sorting millions of numbers would hold the window up.
    """
    if len(leaves) == 1:
        return leaves[0].members.indices
    mask = np.zeros(size, bool)
    for leaf in leaves:
        mask[leaf.members.indices] = True
    return np.flatnonzero(mask)

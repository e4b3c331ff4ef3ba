"""Between the picture and the splitting of a leaf: clicks go one way, rings around seeds back."""

from __future__ import annotations

from functools import partial

import numpy as np
from PySide6.QtCore import QObject

from app.core.arrays import Floats
from widgets.common.leaf_split import LeafSplit
from widgets.controller import Controller
from widgets.picture import Picture
from widgets.tools import Tools

RING = 0.03
"""Radius of the rings around a seed, as a share of the leaf's size."""
CORNERS = 24
MOST = 200
"""Points of a seed at most that get a ring."""


class SplitSight(QObject):
    """Takes clicks for seeds, and shows where seeds are."""

    def __init__(
        self, controller: Controller, picture: Picture, tools: Tools, split: LeafSplit,
        parent: QObject,
    ) -> None:  # fmt: skip
        super().__init__(parent)
        self._controller, self._picture, self._split = controller, picture, split
        split.pick_asked.connect(partial(tools.arm, "pick"))
        split.changed.connect(self._mark)
        picture.picker.found.connect(split.take_point)
        self._shown = False

    def _mark(self) -> None:
        view, leaf = self._picture.view, self._split.leaf
        there = leaf is not None and bool(self._split.seeds)
        if view is None or not (there or self._shown):
            return
        self._shown = there
        if leaf is None or not there:
            view.drawings.show_seeds(None)
            return
        xyz = self._controller.project.state.scan(leaf.scan).scan.xyz
        size = float(np.linalg.norm(np.ptp(xyz[leaf.members.indices], axis=0)))
        rows = [seed.indices[:: -(-len(seed) // MOST)] for seed in self._split.seeds]
        view.drawings.show_seeds(draw_rings(xyz[np.concatenate(rows)], RING * size))


def draw_rings(points: Floats, radius: float) -> Floats:
    """Three rings around each point, (3 k, CORNERS, 3): one of them is seen from anywhere."""
    turn = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
    ring = radius * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    rings = np.stack([ring, np.roll(ring, 1, axis=1), np.roll(ring, 2, axis=1)])
    return np.asarray((points[:, None, None] + rings).reshape(-1, CORNERS, 3))

"""What a scanner sees of leaves that cross."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.services.bench.area.truth import tell_leaves
from app.simulate.surfaces import Leaf

STEP, SIDE = 5e-4, 161


def look_at(tilts: tuple[float, ...]) -> SimpleNamespace:
    """Square views of flat leaves at 2 m that all cross in their middle, by point beams."""
    leaves = [make_leaf(tilt) for tilt in tilts]
    row, column = (a.ravel() for a in np.mgrid[:SIDE, :SIDE])
    side, up = ((SIDE // 2 - a) * STEP for a in (column, row))
    beams = np.stack([np.cos(up) * np.cos(side), np.cos(up) * np.sin(side), np.sin(up)], axis=1)
    nearest, owner = np.full(len(row), 9.0), np.full(len(row), -1)
    for number, leaf in enumerate(leaves):
        along, across, normal = leaf.frame()
        away = np.array(leaf.centre) @ normal / (beams @ normal)
        off = beams * away[:, None] - leaf.centre
        x, y = off @ along, off @ across
        on = (2 * x / leaf.length) ** 2 + (2 * y / leaf.width) ** 2 < 1.0
        closer = on & (away < nearest)
        nearest[closer], owner[closer] = away[closer], number
    grid = SimpleNamespace(rows=SIDE, columns=SIDE, row=row, column=column)
    scan = SimpleNamespace(
        grid=grid,
        xyz=beams * nearest[:, None],
        attributes={"truth_range": nearest, "truth_leaf": owner},
        scanner=origin,
    )
    return SimpleNamespace(scan=scan, scene=SimpleNamespace(leaves=leaves))


def origin(_: str) -> np.ndarray:
    return np.zeros(3)


def make_leaf(tilt: float) -> Leaf:
    normal = (-float(np.cos(tilt)), float(np.sin(tilt)), 0.0)
    return Leaf((2.0, 0.0, 0.0), (0.0, 0.0, 1.0), normal, 0.05, 0.04, None)


@pytest.mark.parametrize(("tilts", "seen"), [((0.3,), (1.0,)), ((0.25, -0.25), (0.5, 0.5))])
def test_a_leaf_that_another_crosses_is_half_hidden(tilts, seen) -> None:
    told = tell_leaves(look_at(tilts))
    assert [leaf.seen for leaf in told] == pytest.approx(seen, abs=0.08)

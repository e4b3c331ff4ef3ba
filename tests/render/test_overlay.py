from __future__ import annotations

import numpy as np

from app.render.overlay import GHOST_COLOUR, SELECTED_COLOUR, LeafMark, Overlay, number_marks


def test_nothing_marked_is_transparent() -> None:
    codes, table = number_marks(Overlay(), 5)
    assert (table[codes, 3] == 0).all()


def test_selection_lies_over_ghosts_and_ghosts_over_leaves() -> None:
    leaf = LeafMark("leaf-00001", np.array([0, 1, 2]), (1, 2, 3))
    ghosts = np.array([0, 1, 1, 0, -1], np.int8)
    codes, table = number_marks(Overlay(np.array([2, 3]), [leaf], ghosts), 5)
    shown = [tuple(int(v) for v in table[code]) for code in codes]
    assert shown[0][:3] == (1, 2, 3)
    assert shown[1] == GHOST_COLOUR
    assert shown[2] == shown[3] == SELECTED_COLOUR
    assert shown[4][3] == 0


def test_the_current_leaf_stands_out_and_many_leaves_find_room() -> None:
    leaves = [LeafMark(f"leaf-{i}", np.array([i]), (i % 8, 0, 0)) for i in range(1000)]
    codes, table = number_marks(Overlay(leaves=leaves, current="leaf-7"), 1000)
    assert (table[codes, 0] == np.arange(1000) % 8).all()
    assert table[codes[7], 3] > table[codes[15], 3]

"""Plain words in the history for corrections, own indices and the synthetic footprint."""

from __future__ import annotations

import pytest

from app.model.corrections import Correction
from app.model.parameters import Formula, Parameters
from widgets.common.step_titles import title_parameters

WF2 = Correction("near", "wf2", {"b": 1.78})
WF3 = Correction("near", "wf3", {"k_d": 0.6, "m": 0.49})
OF_LEAVES = tuple(
    Correction("near", "wf2", {"b": 1.0}, leaves=(f"leaf-0000{n}",)) for n in (1, 2, 3)
)
ONE, TWO = Formula("one", "near / far"), Formula("two", "near - far")


@pytest.mark.parametrize(
    ("old", "new", "title"),
    [
        ({}, {"corrections": (WF2,)}, "Correct near by WF2 (b = 1.78)"),
        ({"corrections": (WF2,)}, {"corrections": (WF2, WF3)},
         "Correct near by WF3 (k_d = 0.6, m = 0.49)"),
        ({}, {"corrections": OF_LEAVES}, "Correct near by WF2 (3 leaves)"),
        ({"corrections": (WF2, WF3)}, {}, "Remove correction near_wf2, near_wf3"),
        ({"corrections": OF_LEAVES}, {"corrections": OF_LEAVES[:2]}, "Change corrections"),
        ({}, {"formulas": (ONE,)}, "Write index one = near / far"),
        ({"formulas": (ONE,)}, {"formulas": (Formula("one", "far"),)}, "Write index one = far"),
        ({"formulas": (ONE, TWO)}, {"formulas": (ONE, Formula("new", TWO.text))},
         "Rename index two to new"),
        ({"formulas": (ONE, TWO)}, {"formulas": (TWO,)}, "Remove index one"),
        ({"formulas": (ONE, TWO)}, {"formulas": (TWO, ONE)}, "Change own indices"),
        ({}, {"synthetic_footprint": 0.05}, "Smooth channels over 50 mm"),
        ({"synthetic_footprint": 0.05}, {}, "Smooth channels no more"),
    ],
)  # fmt: skip
def test_a_change_is_told_in_words(old: dict, new: dict, title: str) -> None:
    assert title_parameters(Parameters(**old), Parameters(**new)) == title

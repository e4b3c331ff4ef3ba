"""Curves through the table of a series: each leaf's own, from its means."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.fitting import fit
from app.services.series.fitting import ANGLES, fit_series, list_channels, list_pairs

ROWS = [
    {"leaf": f"leaf-0000{k}", "name": f"L{k}", "angle_deg": angle, ANGLES[0]: angle,
     "near_mean": k * (0.2 + 0.8 * float(np.cos(np.deg2rad(angle)))), "near_n": 9}
    for angle in (60.0, 0.0, 30.0, 45.0) for k in (1, 2)
]  # fmt: skip
GONE = {"leaf": "leaf-00001", "name": "L1", "angle_deg": 75.0, ANGLES[0]: 75.0, "near_mean": None}


def test_pairs_go_by_leaf_in_order() -> None:
    pairs = list_pairs([*ROWS, GONE], "angle_deg", "near_mean")
    assert list(pairs) == ["leaf-00001", "leaf-00002"]
    assert pairs["leaf-00002"][0] == [0.0, 30.0, 45.0, 60.0]
    assert pairs["leaf-00002"][1][0] == 2.0
    assert list_channels(ROWS) == ["near"]


def test_each_leaf_gets_the_fit_of_its_own_points() -> None:
    report = fit_series([*ROWS, GONE], "near", "cosine")
    assert [fit.group["name"] for fit in report.fits] == ["L1", "L2"]
    x, y = list_pairs(ROWS, ANGLES[0], "near_mean")["leaf-00002"]
    alone = fit("cosine", np.deg2rad(x), np.array(y))
    fitted = report.fits[1].result
    assert fitted is not None
    assert fitted.values == pytest.approx(alone.values)
    with pytest.raises(BadInput, match="mean of far"):
        fit_series(ROWS, "far", "cosine")

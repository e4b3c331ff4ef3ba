"""Errors by material, and panels that the fit did not see."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.radiometry.calibration import Calibration, calibrate
from app.core.radiometry.models import choose_model
from app.core.radiometry.panels import make_table
from app.core.radiometry.residuals import (
    predict_left_out,
    recover_reflectance,
    score_materials,
)

RHO = np.array([0.1, 0.2, 0.4, 0.8])


def fit() -> Calibration:
    dn = 1000 + 500 * np.log10(RHO) + np.array([3.0, -5.0, 4.0, -1.0])
    return calibrate(
        make_table(np.ones(4), dn, RHO, 785.0, panel=list("abcd")), choose_model("log")
    )


def test_a_panel_left_out_is_predicted_by_the_others_alone() -> None:
    found = fit()
    others = np.array([True, True, False, True])
    line = np.polyfit(np.log10(RHO[others]), found.table.dn[others], 1)
    expected = 10 ** ((found.table.dn[2] - line[1]) / line[0]) - 0.4
    assert predict_left_out(found, "c") == pytest.approx([expected], rel=1e-3)


def test_scores_are_found_less_true() -> None:
    found = fit()
    error = recover_reflectance(found.fit.found, found.table) - RHO
    scores = score_materials(found)
    assert [score.bias for score in scores] == pytest.approx(error)
    assert [score.dn_bias for score in scores] == pytest.approx(found.fit.residual)
    assert all(score.rows == 1 for score in scores)


def test_what_the_others_do_not_determine_is_not_made_up() -> None:
    found = fit()
    two = calibrate(
        make_table(np.ones(4), found.table.dn, np.array([0.1, 0.1, 0.8, 0.8]), 785.0,
                   panel=["a", "a", "b", "b"], scan=["1", "2", "1", "2"]),
        choose_model("log"),
    )  # fmt: skip
    assert predict_left_out(two, "a") is None
    assert score_materials(two)[0].left_out_rmse is None

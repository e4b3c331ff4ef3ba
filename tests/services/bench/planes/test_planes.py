"""Leaves of the bench are what they say, its figures are those of their angles, and it runs."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.services.bench.picture import draw_panels
from app.services.bench.planes import goniometer, methods, table
from app.services.bench.planes.leaves import see_leaf
from app.services.bench.planes.methods import Angle, angle_at, measure_angle


@pytest.fixture(scope="module")
def flat():
    return see_leaf("flat", 60.0, 3)


def test_a_leaf_is_met_at_its_angle(flat):
    middle = flat.xyz[~flat.ghost].mean(axis=0)
    assert angle_at(middle, flat.normal) == pytest.approx(60.0, abs=0.5)
    assert (
        np.abs((flat.xyz[~flat.ghost] - middle) @ flat.normal).max() < 0.003
    )  # not farther than 2 mm off is no ghost
    assert 0.02 < flat.ghost.mean() < 0.4
    assert len(flat.alone) > (~flat.ghost).sum()


def test_a_leaf_is_the_same_again_and_another_by_seed(flat):
    assert (see_leaf("flat", 60.0, 3).xyz == flat.xyz).all()
    assert len(see_leaf("flat", 60.0, 4).xyz) != len(flat.xyz)


@pytest.mark.parametrize("points", ["true points", "with mixed pixels", "nothing behind"])
def test_noise_lies_along_the_beam(flat, points):
    still, noisy = (flat.draw(points, sigma, 5) for sigma in (0.0, 0.0026))
    before, after = (np.linalg.norm(xyz, axis=1) for xyz in (still, noisy))
    assert np.allclose(still / before[:, None], noisy / after[:, None], atol=1e-14)
    assert (after - before).std() == pytest.approx(0.0026, rel=0.1)


def test_bent_and_wrinkled_leaves_lie_about_their_plane():
    for kind, least in (("curved", 0.0005), ("wrinkled", 0.0003)):
        leaf = see_leaf(kind, 20.0, 1)
        xyz = leaf.draw("true points", 0.0, 0)
        across = (xyz - xyz.mean(axis=0)) @ leaf.normal
        assert least < across.std() < 0.003


def test_a_method_that_refuses_says_no_angle():
    angle = measure_angle("TLS", np.ones((5, 3)), np.array([1.0, 0.0, 0.0]))
    assert np.isnan(angle.error)
    assert np.isnan(angle.sigma)


def test_a_fault_of_another_kind_is_not_swallowed(monkeypatch):
    def fail(xyz, scanner):
        raise ValueError("broken")

    monkeypatch.setattr(methods, "METHODS", {"TLS": fail})
    with pytest.raises(ValueError, match="broken"):
        measure_angle("TLS", np.ones((5, 3)), np.array([1.0, 0.0, 0.0]))
    assert not issubclass(ValueError, BadInput)


def test_figures_of_known_angles():
    angles = [Angle(31.0, 30.0, 2.0), Angle(28.0, 30.0, 1.0), Angle(np.nan, np.nan, np.nan)]
    row = table._tell(table.Cell("flat", "true points", 0.0007, 30.0), "TLS", angles)
    assert row["median_deg"] == 2.0
    assert row["p90_deg"] == pytest.approx(2 + 0.8 * 88, rel=1e-3)
    assert row["bias_deg"] == -0.5
    assert row["undefined"] == 1
    assert row["within 1 σ"] == 0.5


def test_the_line_through_known_angles():
    true = np.arange(0.0, 90.0, 10.0)
    line = goniometer.fit_line([Angle(0.98 * a + 0.4, a, 0.1) for a in true])
    assert (line.slope, line.intercept, line.r2) == pytest.approx((0.98, 0.4, 1.0))
    assert line.rmse == pytest.approx(np.sqrt(np.mean((0.4 - 0.02 * true) ** 2)))
    assert not line.passed
    near = [Angle(0.995 * a + 0.2, a, 0.1) for a in true]
    assert goniometer.fit_line(near).passed
    assert not goniometer.fit_line([*near, Angle(np.nan, np.nan, np.nan)]).passed


def test_the_quick_tables(tmp_path):
    found = table.measure_leaves(quick=True)
    assert len(found.rows) == 3 * 3 * 2 * 2 * len(methods.METHODS)
    cells = {tuple(row.values())[:5]: row for row in found.rows}
    assert len(cells) == len(found.rows)
    ours, theirs = (
        cells["flat", "with mixed pixels", 0.7, 60.0, name]["median_deg"]
        for name in ("inverse range", "TLS")
    )
    assert ours < 0.3 < theirs
    draw_panels(table.draw_leaves(found), tmp_path / "planes.png")
    assert (tmp_path / "planes.png").stat().st_size > 5000


def test_the_quick_goniometer():
    found = goniometer.check_goniometer(quick=True)
    rows = {(row["target"], row["method"]): row for row in found.rows}
    assert len(rows) == len(goniometer.TARGETS) * len(methods.METHODS)
    assert rows["stage", "inverse range"]["verdict"] == "reached"
    assert rows["stage", "TLS"]["verdict"] == "NOT REACHED"
    assert all(row["scans"] + row["undefined"] == 6 for row in rows.values())

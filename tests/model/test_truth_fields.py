"""The truth of a simulated scan under titles, in units, as what it is."""

from __future__ import annotations

import numpy as np
import pytest

from app.model.fields import FieldKind
from app.model.operations import AddScan
from app.model.project import Project
from app.model.scan import Scan
from app.model.scene import resolve
from app.model.truth_fields import PREFIX, describe_truth
from app.model.view_state import ViewState
from app.simulate.virtual_scan import simulate


def test_every_field_that_the_simulator_writes_has_a_title(leaves: Scan) -> None:
    scans = [leaves, simulate("leaf", "ls880", step_deg=0.3).scan]
    names = {name for scan in scans for name in scan.attributes if name.startswith(PREFIX)}
    assert "truth_saturated" in names
    assert [name for name in names if describe_truth(name) is None] == []


@pytest.mark.parametrize(
    ("name", "title", "unit", "kind"),
    [
        ("truth_incidence", "True incidence angle", "°", "angle"),
        ("truth_ghost", "True ghost", "", "verdict"),
        ("truth_leaf", "True leaf", "", "class"),
        ("truth_range", "True range", "m", "scalar"),
        ("truth_hit_fraction", "Share of the beam", "", "score"),
        ("truth_saturated", "Saturated", "", "flag"),
        ("truth_rho_785", "True reflectance at 0°, 785 nm", "", "scalar"),
        ("truth_reflectance_785", "True reflectance at its angle, 785 nm", "", "scalar"),
        ("truth_sigma_intensity_785", "σ of intensity_785", "DN", "scalar"),
    ],
)
def test_titles_units_and_kinds(name: str, title: str, unit: str, kind: FieldKind) -> None:
    known = describe_truth(name)
    assert known is not None
    assert (known.title, known.unit, known.kind) == (title, unit, kind)


@pytest.mark.parametrize("name", ["leaf", "truth_beauty", "untruth_leaf", "truth_"])
def test_other_names_are_left_alone(name: str) -> None:
    assert describe_truth(name) is None


def test_the_picture_shows_them_as_what_they_are(leaves: Scan) -> None:
    project = Project()
    key = project.shelve(leaves)
    project.do(AddScan(key, "leaves", None))
    expected = {
        "truth_incidence": ("True incidence angle", "°", "viridis", (0.0, 90.0)),
        "truth_ghost": ("True ghost", "", "verdict", (0.0, 2.0)),
        "truth_hit_fraction": ("Share of the beam", "", "batlow", (0.0, 1.0)),
    }
    for name, (title, unit, palette, limits) in expected.items():
        project.field(key, name)
        (cloud,) = resolve(project, ViewState(key, colour=name)).clouds
        bar = cloud.bar
        assert bar is not None
        assert (bar.title, bar.unit, bar.map) == (title, unit, palette)
        assert (bar.low, bar.high) == limits


def test_what_belongs_to_no_leaf_has_no_leaf(leaves: Scan) -> None:
    project = Project()
    key = project.shelve(leaves)
    project.do(AddScan(key, "leaves", None))
    labels, shown = leaves.attributes["truth_leaf"], project.field(key, "truth_leaf")
    assert (labels < 0).any()
    np.testing.assert_array_equal(np.isnan(shown), labels < 0)
    np.testing.assert_array_equal(shown[labels >= 0], labels[labels >= 0])
    away = project.field(key, "truth_range_shift")
    np.testing.assert_array_equal(away, leaves.attributes["truth_range_shift"].astype(float))

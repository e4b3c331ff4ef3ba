"""What is told about angles agrees with the fields."""

from __future__ import annotations

import numpy as np
import pytest

from app.model.operations import AddScan
from app.model.project import Project
from app.model.scan import Scan
from app.services.angles import describe_angles

KEY = "scan-00001"


@pytest.mark.parametrize("points", [None, np.arange(100, 400)])
def test_facts_are_those_of_the_fields(leaves: Scan, points: np.ndarray | None) -> None:
    project = Project()
    project.do(AddScan(project.shelve(leaves), "leaves", None))
    angle, sigma, width = (
        project.field(KEY, name, points)
        for name in ("incidence", "incidence_sigma", "incidence_width")
    )
    facts = describe_angles(project.known_field(KEY, "incidence"), leaves.valid)
    assert (facts.neighbours, facts.estimator) == ("scan grid", "adaptive")
    assert facts.points == len(angle)
    assert facts.undefined == np.isnan(angle).sum()
    assert facts.sigma_deg == pytest.approx(np.nanmedian(sigma[np.isfinite(angle)]), rel=1e-5)
    assert facts.width_mm == pytest.approx(np.nanmedian(width[np.isfinite(angle)]), rel=1e-5)

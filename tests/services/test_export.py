"""What is gathered for a file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.model.operations import AddScan
from app.model.project import Project
from app.model.scan import Scan
from app.services.export import gather

KEY = "scan-00001"


def test_a_computed_field_hides_an_older_one_that_the_file_holds(leaves: Scan) -> None:
    old = np.full(len(leaves), -7.0)
    scan = replace(leaves, attributes={**leaves.attributes, "range": old, "ghost": old})
    project = Project()
    project.do(AddScan(project.shelve(scan), "old", None))
    columns = gather(project, KEY, ["range", "reflectance_1063", "truth_leaf"]).columns
    np.testing.assert_array_equal(columns["range"], project.field(KEY, "range"))
    assert columns["range"].min() > 0
    assert columns["ghost"] is old  # nobody asked for it: the file's own values travel
    for name in ("reflectance_1063", "truth_leaf"):
        assert columns[name].dtype == leaves.attributes[name].dtype

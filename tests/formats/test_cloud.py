"""Subsets of a cloud keep what belongs to their points."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.formats.cloud import Cloud
from app.formats.column_names import give_file_names
from app.model.scan import Grid, Scan


def make_cloud() -> Cloud:
    grid = Grid(2, 3, np.array([0, 1, 1], np.int32), np.array([0, 1, 2], np.int32), np.array([1]))
    xyz = np.arange(9.0).reshape(3, 3)
    scan = Scan("s", xyz, {"intensity": np.array([5, 6, 7], np.uint16)}, grid=grid)
    return Cloud(scan, {"incidence": np.array([0.1, 0.2, np.nan])}, {"incidence": "deg"})


@pytest.mark.parametrize("indices", [np.array([2, 0]), np.array([True, False, True])])
def test_subset(indices: np.ndarray) -> None:
    cloud = make_cloud()
    part = cloud.subset(indices)
    np.testing.assert_array_equal(part.scan.xyz, cloud.scan.xyz[indices])
    assert set(part.columns) == {"intensity", "incidence", "row", "column"}
    for name, values in part.columns.items():
        np.testing.assert_array_equal(values, cloud.columns[name][indices])
    assert part.scan.grid is not None
    assert part.scan.grid.no_return.tolist() == [1]
    assert part.units == cloud.units


def test_field_of_wrong_length_is_refused() -> None:
    with pytest.raises(BadInput, match="2 values for 3 points"):
        Cloud(make_cloud().scan, {"f": np.zeros(2)})


def test_a_field_hides_the_attribute_of_its_name() -> None:
    cloud = Cloud(make_cloud().scan, {"intensity": np.zeros(3)})
    assert cloud.columns["intensity"].sum() == 0


def test_file_names_are_unique_whatever_their_case() -> None:
    given = give_file_names(["X", "a b", "a_b", ""], ["x"], lambda name: name.replace(" ", "_"))
    assert given == {"X": "X_2", "a b": "a_b", "a_b": "a_b_2", "": "field"}

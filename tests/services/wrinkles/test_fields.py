"""Measured wrinkles as fields: handed over, never computed, gone when the leaves change."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.core.errors import BadInput
from app.model.leaf import Leaf
from app.model.operations import PutLeaf
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Pose, Scan
from app.model.wrinkle_fields import DELTA, SIGNIFICANCE, WRINKLES
from app.services.opening import add_scans
from app.services.preparation import prepare
from app.services.wrinkles.fields import fields_of
from app.services.wrinkles.measure import measure_wrinkles
from app.services.wrinkles.request import WrinkleRequest
from app.simulate.virtual_scan import simulate


@pytest.fixture
def project():
    made = Project()
    scan = Scan("few", np.arange(30.0).reshape(10, 3), {}, (), Pose((0.0, 0.0, 0.0)))
    (key,) = add_scans(made, [scan])
    made.do(PutLeaf("leaf-00001", Leaf("leaf-00001", key, "Leaf 1", PointSet(np.arange(4)), ())))
    return made, key


def test_a_command_measures_them_as_the_window_does() -> None:
    made = Project()
    key = add_scans(made, [simulate("leaf_row", seed=3, step_deg=0.036).scan])[0]
    prepare(made, key, (DELTA,), {})
    values = made.field(key, DELTA)
    assert np.isfinite(values).sum() > 1000
    assert made.state.leaves_of(key)
    again = measure_wrinkles(made, key, WrinkleRequest())
    np.testing.assert_array_equal(values, fields_of(made, key, again)[DELTA].values)
    assert "leaves of this scan" in made.known_field(key, DELTA).notes["curve"]
    twin = Project()
    other = add_scans(twin, [simulate("leaf_row", seed=3, step_deg=0.036).scan])[0]
    prepare(twin, other, (DELTA,), {})
    np.testing.assert_array_equal(values, twin.field(other, DELTA))


def judged(delta, valid):
    """A leaf that was judged, as far as fields look at it."""
    return SimpleNamespace(
        delta=np.deg2rad(delta), significance=np.asarray(delta, float) / 2.0,
        angles=SimpleNamespace(valid=np.array(valid)),
    )  # fmt: skip


def test_values_lie_at_their_points_and_are_nan_elsewhere(project) -> None:
    made, key = project
    leaves = (
        SimpleNamespace(
            calibration=None, points=np.array([1, 3, 5]), judged=judged([4.0, -6.0, 9.0], [1, 1, 0])
        ),
        SimpleNamespace(calibration=None, points=np.array([8]), judged=None),
    )
    leaves[0].judged.angles.valid = np.array([True, True, False])
    made.accept(key, fields_of(made, key, SimpleNamespace(leaves=leaves)))
    found = made.field(key, DELTA)
    np.testing.assert_allclose(found[[1, 3]], [4.0, -6.0])
    assert np.isnan(np.delete(found, [1, 3])).all()
    np.testing.assert_allclose(made.field(key, SIGNIFICANCE)[[1, 3]], [2.0, -3.0])
    made.do(PutLeaf("leaf-00001", None))
    assert made.known_field(key, DELTA) is None


def test_nobody_computes_them(project) -> None:
    made, key = project
    assert all(spec.given for spec in WRINKLES)
    with pytest.raises(BadInput, match="no session keeps them"):
        made.field(key, DELTA)

from __future__ import annotations

import numpy as np

from app.model.operations import Coordinates, MovePoints, SetPose
from app.model.points import PointSet
from app.services.cleanup import Answer, make_step
from app.services.cleanup.moves import AXES, CONFIDENCE, MOVED, UNITS, describe_moves
from app.services.export import gather

KEY = "scan-00001"


def test_where_nothing_was_moved_there_are_no_columns_unless_wanted(project) -> None:
    assert describe_moves(project, KEY) == {}
    columns = describe_moves(project, KEY, always=True)
    assert set(columns) == set(UNITS)
    assert not columns[MOVED].any()
    assert np.isnan(columns[CONFIDENCE]).all()
    assert MOVED not in gather(project, KEY, ()).columns


def test_moves_are_signed_along_the_beam_and_come_with_their_confidence(project, plan) -> None:
    measured = project.state.scan(KEY).scan.xyz
    project.do(make_step(project.state, plan, plan.proposal))
    cloud = gather(project, KEY, ())
    assert {name: cloud.units[name] for name in UNITS} == UNITS
    columns = describe_moves(project, KEY)
    places = plan.proposal == Answer.CORRECT
    rows = plan.ghosts[places]
    np.testing.assert_allclose(columns[MOVED][rows], 1000.0 * plan.shift[places], atol=1e-4)
    np.testing.assert_allclose(columns[CONFIDENCE][rows], plan.confidence[places], atol=1e-6)
    others = np.setdiff1d(np.arange(len(measured)), rows)
    assert not columns[MOVED][others].any()
    vector = np.stack([columns[axis] for axis in AXES], axis=1)
    np.testing.assert_allclose(project.state.scan(KEY).scan.xyz - vector, measured, atol=1e-7)
    project.undo()
    assert describe_moves(project, KEY) == {}


def test_a_move_of_a_scan_from_nowhere_has_no_sign(project) -> None:
    xyz = project.state.scan(KEY).scan.xyz
    project.do(MovePoints(KEY, PointSet([5]), Coordinates(0.9 * xyz[[5]])))
    project.do(SetPose(KEY, None))
    moved = describe_moves(project, KEY)[MOVED]
    assert np.flatnonzero(moved).tolist() == [5]
    assert moved[5] > 0.0

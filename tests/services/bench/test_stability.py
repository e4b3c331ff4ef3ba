"""The bench of stability notices what is wrong, and says where."""

from __future__ import annotations

import numpy as np

from app.services.bench.stability import ways
from app.services.bench.stability.patches import make_leaves, make_plane, make_pole
from app.services.bench.stability.run import bench_stability, list_cases, tell_case
from app.services.bench.stability.ways import WAYS, compare, compare_known, expect_none


def test_comparing():
    nan = np.nan
    assert compare(np.array([1.0, 2.0, nan]), np.array([1.0, 2.5, nan])).worst == 0.5
    assert compare(np.array([1.0, nan]), np.array([1.0, 2.5])).worst == np.inf
    assert compare(np.array([1.0, 2.0]), np.array([1.0, 2.5]), most=0.5).worst == 0.25
    assert compare_known(np.array([1.0, nan]), np.array([1.25, 2.5])).worst == 0.25
    assert expect_none(np.array([nan, nan])).worst == 0.0
    assert expect_none(np.array([nan, 3.0])).worst == 90.0


def test_an_angle_that_changes_with_the_place_is_noticed(monkeypatch):
    real = ways.incidence_angle

    def wrong(xyz, normals, scanner):
        return real(xyz, normals, scanner) + 1e-7 * np.abs(scanner).max()

    monkeypatch.setattr(ways, "incidence_angle", wrong)
    case = next(case for case in list_cases() if case.group == "moved")
    row = tell_case(case, 32)
    assert row["verdict"] == "FAILS: " + ", ".join(way.name for way in WAYS)


def test_a_normal_that_faces_away_is_noticed(monkeypatch):
    real = ways.local_planes

    class Turned:
        def __init__(self, planes):
            self.normals = -planes.normals

    monkeypatch.setattr(ways, "local_planes", lambda *a, **k: Turned(real(*a, **k)))
    assert (WAYS[2].angles(make_plane(30.0, 20)) == 180.0).all()


def test_patches_are_what_they_say():
    plane = make_plane(80.0, 21)
    assert plane.omega[220] == 80.0 or abs(plane.omega[220] - 80.0) < 1e-9
    assert len(make_leaves(30).xyz) < 900
    pole = make_pole(10)
    assert np.isclose(np.arcsin(pole.xyz[0, 2] / np.linalg.norm(pole.xyz[0])), np.pi / 2)


def test_the_table_has_a_row_for_each_case():
    table, *_ = bench_stability(quick=True).tables
    assert len(table.rows) == len(list_cases())
    assert {way.name for way in WAYS} <= set(table.columns)

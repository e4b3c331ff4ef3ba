"""The angle, its standard error and its window come from one computation, where asked."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

import app.core.incidence as core
from app.core.ghosts import THRESHOLD
from app.core.units import to_degrees, to_mm
from app.model.operations import AddScan, SetParameters
from app.model.project import Project
from app.model.scan import Scan

KEY = "scan-00001"
THREE = ("incidence", "incidence_sigma", "incidence_width")


def put(scan: Scan) -> Project:
    project = Project()
    project.do(AddScan(project.shelve(scan), "scan", None))
    return project


@pytest.fixture
def project(leaves: Scan) -> Project:
    return put(leaves)


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Points of each call of `local_planes`."""
    seen: list[int] = []
    real = core.local_planes

    def count(xyz, scanner, points=None, *rest, **options):
        seen.append(len(xyz) if points is None else len(points))
        return real(xyz, scanner, points, *rest, **options)

    monkeypatch.setattr(core, "local_planes", count)
    return seen


def change(project: Project, **values: object) -> None:
    old = project.state.scan(KEY).parameters
    project.do(SetParameters(KEY, msgspec.structs.replace(old, **values)))


@pytest.mark.parametrize("order", [THREE, THREE[::-1]])
def test_planes_are_fitted_once_for_all_three(
    project: Project, leaves: Scan, calls: list[int], order: tuple[str, ...]
) -> None:
    found = {name: project.field(KEY, name) for name in order}
    assert calls == [len(leaves)]
    planes = core.local_planes(leaves.xyz, leaves.scanner("a test"), None, grid=leaves.grid)
    expected = np.where(planes.width > 0, to_mm(planes.width.astype(float)), np.nan)
    np.testing.assert_allclose(found["incidence_sigma"], to_degrees(planes.sigma), rtol=1e-6)
    np.testing.assert_allclose(found["incidence_width"], expected, rtol=1e-6)
    assert np.isfinite(found["incidence_sigma"]).mean() > 0.5


def test_only_the_points_asked_for_are_fitted_and_counted(
    project: Project, calls: list[int]
) -> None:
    project.field(KEY, "incidence_sigma", np.arange(10, 60))
    project.field(KEY, "incidence_width", np.arange(30, 70))
    project.field(KEY, "incidence", np.arange(0, 80))
    assert calls == [50, 10, 20]
    assert project.cache.computed(KEY) == {
        "incidence_sigma": 50, "incidence_width": 40, "incidence": 80
    }  # fmt: skip


@pytest.mark.parametrize("name", THREE)
def test_in_parts_equals_all_at_once(project: Project, leaves: Scan, name: str) -> None:
    project.field(KEY, "incidence", np.arange(0, len(leaves), 7))
    project.field(KEY, name, np.arange(0, len(leaves), 3))
    expected = put(leaves).field(KEY, name)
    np.testing.assert_allclose(project.field(KEY, name), expected, rtol=1e-6)


def test_parts_that_were_computed_side_by_side_are_joined(
    project: Project, leaves: Scan, calls: list[int]
) -> None:
    parts = [np.arange(0, 40), np.arange(30, 60)]
    evaluations = [project.evaluation(KEY) for _ in parts]
    for evaluation, part in zip(evaluations, parts, strict=True):
        evaluation.read("incidence", part)
    for evaluation in evaluations:
        project.accept(KEY, evaluation.results)
    del calls[:]
    found = project.field(KEY, "incidence_sigma", np.arange(60))
    assert calls == []
    expected = put(leaves).field(KEY, "incidence_sigma")[:60]
    np.testing.assert_allclose(found, expected, rtol=1e-6)  # float32 inside


def test_another_estimator_spoils_all_three_and_nothing_else(project: Project) -> None:
    for name in ("range", *THREE):
        project.field(KEY, name)
    change(project, estimator="ball")
    assert all(project.known_field(KEY, name) is None for name in THREE)
    assert project.known_field(KEY, "range") is not None


def test_each_estimator_is_the_one_that_is_used(project: Project) -> None:
    found = []
    for estimator in core.ESTIMATORS:
        change(project, estimator=estimator)
        found.append(project.field(KEY, "incidence"))
        notes = project.known_field(KEY, "incidence").notes
        assert notes["estimator"] == estimator
        assert notes["neighbours"] == "scan grid"
        assert 0.1 < notes["median_sigma_deg"] < 20
        assert 0.0005 < notes["median_width_m"] < 0.02
    for number, angles in enumerate(found):
        others = found[:number] + found[number + 1 :]
        assert all(np.nanmax(np.abs(angles - other)) > 0.01 for other in others)


def test_a_cloud_without_rows_and_columns_gets_them_back(project: Project, leaves: Scan) -> None:
    order = np.random.default_rng(1).permutation(len(leaves))
    bare = put(Scan("bare", leaves.xyz[order], pose=leaves.pose))
    found = bare.field(KEY, "incidence")
    notes = bare.known_field(KEY, "incidence").notes
    assert (notes["neighbours"], notes["estimator"]) == ("recovered grid", "adaptive")
    assert "°" in notes["reason"]
    difference = np.abs(found - project.field(KEY, "incidence")[order])
    assert np.nanpercentile(difference, 99) < 0.01


def test_rows_that_do_not_follow_the_beams_are_not_used(leaves: Scan) -> None:
    chance = np.random.default_rng(1)
    grid = replace(leaves.grid, row=chance.permutation(leaves.grid.row))
    project = put(replace(leaves, grid=grid))
    project.field(KEY, "incidence")
    notes = project.known_field(KEY, "incidence").notes
    assert (notes["neighbours"], notes["estimator"]) == ("voxel hash", "ball")
    assert "follow the beams" in notes["reason"]


def test_ghosts_of_a_cloud_without_rows_and_columns_are_those_of_its_grid(
    project: Project, leaves: Scan
) -> None:
    bare = put(replace(leaves, grid=None))
    score, other = project.field(KEY, "ghost_score"), bare.field(KEY, "ghost_score")
    assert bare.known_field(KEY, "ghost_score").notes["neighbours"] == "recovered grid"
    assert np.mean((score > THRESHOLD) == (other > THRESHOLD)) > 0.999


@pytest.mark.parametrize("threshold", [0.05, 0.5])
def test_corrections_do_not_depend_on_which_ghosts_are_asked_for(
    leaves: Scan, threshold: float
) -> None:
    whole, part = put(leaves), put(leaves)
    for project in (whole, part):
        change(project, ghost_threshold=threshold)
    ghosts = np.flatnonzero(whole.field(KEY, "ghost") == 1.0)
    some = ghosts[::7]
    for name in ("ghost_correction", "ghost_confidence"):
        all_of_them = whole.field(KEY, name)
        assert np.isfinite(all_of_them[ghosts]).any()
        np.testing.assert_allclose(part.field(KEY, name, some), all_of_them[some], atol=1e-6)

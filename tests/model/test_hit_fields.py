"""The share of the beam as a field: what it needs, what it leaves alone, and what it refuses."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from app.core.errors import BadInput, MissingScanner
from app.core.radiometry.partial_hits import FULL_HIT, hit_fraction
from app.model.operations import AddScan, SetParameters
from app.model.parameters import Beam
from app.model.project import Project
from app.model.scan import Scan

KEY = "scan-00001"
BEAM = Beam(0.0015, float(np.deg2rad(0.014)), "instrument two_colour")


def put(scan: Scan, beam: Beam | None = BEAM) -> Project:
    project = Project()
    project.do(AddScan(project.shelve(scan), scan.name, None))
    old = project.state.scan(KEY).parameters
    project.do(SetParameters(KEY, msgspec.structs.replace(old, beam=beam)))
    return project


def share_of(scan: Scan) -> np.ndarray:
    assert scan.pose is not None
    place = np.array(scan.pose.position)
    return hit_fraction(scan.xyz, place, scan.grid, BEAM.radius, BEAM.half_divergence)


def test_it_is_computed_alone_and_for_the_points_asked_for(leaves: Scan) -> None:
    project, some = put(leaves), np.arange(0, len(leaves), 7)
    found = project.field(KEY, "hit_fraction", some)
    assert project.cache.computed(KEY) == {"hit_fraction": len(some)}
    assert np.array_equal(found, share_of(leaves)[some])
    assert 0.5 < (found >= FULL_HIT).mean() < 1.0


def test_another_beam_gives_other_shares(leaves: Scan) -> None:
    project = put(leaves)
    before = project.field(KEY, "hit_fraction")
    old = project.state.scan(KEY).parameters
    wide = Beam(0.004, BEAM.half_divergence, "typed in")
    project.do(SetParameters(KEY, msgspec.structs.replace(old, beam=wide)))
    after = project.field(KEY, "hit_fraction")
    assert (after >= FULL_HIT).sum() < (before >= FULL_HIT).sum()


def test_a_recovered_grid_does_as_well(leaves: Scan) -> None:
    order = np.random.default_rng(4).permutation(len(leaves))
    loose = replace(leaves, xyz=leaves.xyz[order], attributes={}, channels=(), grid=None)
    found = put(loose).field(KEY, "hit_fraction")
    share = share_of(leaves)[order]
    assert ((found >= FULL_HIT) == (share >= FULL_HIT)).mean() > 0.98


def test_what_is_missing_is_said(leaves: Scan) -> None:
    with pytest.raises(BadInput, match="beam of the scanner is unknown"):
        put(leaves, None).field(KEY, "hit_fraction")
    with pytest.raises(MissingScanner):
        put(leaves.with_pose(None)).field(KEY, "hit_fraction")
    chance = np.random.default_rng(1).normal(size=(500, 3))
    loose = Scan("loose", chance, pose=leaves.pose)
    with pytest.raises(BadInput, match="rows and columns"):
        put(loose).field(KEY, "hit_fraction")

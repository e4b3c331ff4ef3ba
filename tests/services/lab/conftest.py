"""A scan with leaves whose curves are known, and a folder for models of one's own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.core.phase import get_model
from app.model.fields import Computed, Values, fingerprint
from app.model.leaf import Leaf
from app.model.operations import AddScan, PutLeaf
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Channel, Pose, Scan

TRUTH = {
    "near": {"f": 0.5, "k_d": 0.8, "m": 0.3},
    "far": {"f": 0.3, "k_d": 0.5, "m": 0.25},
}
Rig = tuple[Project, str, list[str]]


@pytest.fixture(autouse=True)
def own_models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """No test reads or writes what the user has."""
    folder = tmp_path / "own-models"
    monkeypatch.setenv("LEAFSCOPE_MODELS", str(folder))
    return folder


@pytest.fixture
def rig() -> Rig:
    """Three leaves of 400 points at known angles; the angles are given, not computed."""
    return make_rig(400, 0.02)


def make_rig(count: int, noise: float) -> Rig:
    generator = np.random.default_rng(7)
    angle = generator.uniform(1.0, 75.0, 3 * count)
    model = get_model("lambert-beckmann")
    values = {
        name: model.evaluate(np.deg2rad(angle), truth)
        * (1.0 + noise * generator.standard_normal(len(angle)))
        for name, truth in TRUTH.items()
    }
    xyz = generator.uniform(1.0, 2.0, (len(angle), 3))
    channels = tuple(Channel(name, name, kind="reflectance") for name in values)
    scan = Scan("rig", xyz, values, channels, Pose((0.0, 0.0, 0.0)))
    project = Project()
    key = project.shelve(scan)
    project.do(AddScan(key, "rig", None))
    keys = []
    for number in range(3):
        leaf = f"leaf-{number + 1:05d}"
        rows = np.arange(number * count, (number + 1) * count)
        leaf_record = Leaf(leaf, key, f"Leaf {number + 1}", PointSet(rows))
        project.do(PutLeaf(leaf, leaf_record))
        keys.append(leaf)
    give_angles(project, key, angle)
    return project, key, keys


def give_angles(project: Project, key: str, angle: np.ndarray) -> None:
    """Put known angles where computed ones would be."""
    mark = fingerprint(project.catalogue(key), "incidence", project.subject(key))
    held = Values.empty(mark, len(angle))
    zeros = np.zeros(len(angle), np.float32)
    held.fill(None, Computed(angle, beside={"sigma": zeros, "width": zeros}))
    project.accept(key, {"incidence": held})

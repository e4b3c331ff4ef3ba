"""A simulated scan of leaves with its leaves found, ready for a clean-up."""

from __future__ import annotations

import numpy as np
import pytest

from app.model.leaf import Leaf
from app.model.operations import AddScan, PutLeaf
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan
from app.services.cleanup.plan import Plan, plan_cleanup

KEY = "scan-00001"


@pytest.fixture
def project(leaves: Scan) -> Project:
    """The scan with the true members of each leaf that are no ghosts."""
    project = Project()
    project.do(AddScan(project.shelve(leaves), "leaves", None))
    label, ghost = leaves.attributes["truth_leaf"], leaves.attributes["truth_ghost"]
    called = project.field(KEY, "ghost") == 1.0
    for number in range(int(label.max()) + 1):
        members = np.flatnonzero((label == number) & (ghost == 0) & ~called)
        key = f"leaf-{number + 1:05d}"
        leaf = Leaf(key, KEY, f"Leaf {number + 1}", PointSet(members))
        project.do(PutLeaf(key, leaf))
    return project


@pytest.fixture
def plan(project: Project) -> Plan:
    return plan_cleanup(project, KEY)


@pytest.fixture
def make_scattered(leaves: Scan):
    """The same points in another order, of which nobody can tell rows and columns."""

    def make() -> Project:
        chance = np.random.default_rng(3)
        chosen = np.sort(chance.choice(len(leaves), len(leaves) // 3, replace=False))
        chance.shuffle(chosen)
        values = {name: held[chosen] for name, held in leaves.attributes.items()}
        scan = Scan("scattered", leaves.xyz[chosen], values, leaves.channels, leaves.pose)
        project = Project()
        project.do(AddScan(project.shelve(scan), "scattered", None))
        return project

    return make

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from app.model.operations import AddScan
from app.model.project import Project
from app.model.scan import Channel, Pose, Scan

Build = Callable[..., tuple[Project, str]]


@pytest.fixture
def build() -> Build:
    """A project with one scan, one channel per attribute."""

    def build_project(
        xyz: np.ndarray, attributes: Mapping[str, np.ndarray] | None = None
    ) -> tuple[Project, str]:
        attributes = attributes or {}
        channels = tuple(Channel(name, name) for name in attributes)
        scan = Scan("test", xyz, attributes, channels, Pose((0.0, 0.0, 0.0)))
        project = Project()
        key = project.shelve(scan)
        project.do(AddScan(key, "test", None))
        for name in attributes:
            project.field(key, name)
        return project, key

    return build_project

"""Fixtures that every test may use."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from app.model.operations import AddScan
from app.model.project import Project
from app.model.scan import Channel, Pose, Scan

Build = Callable[..., tuple[Project, str]]
SHARED = Path(__file__).parents[2] / "shared" / "data"

# Kernels compile on their first call, which no example should be blamed for.
settings.register_profile("leafscope", deadline=None)
settings.load_profile("leafscope")


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder with the real scans; tests that need it are skipped where it is missing."""
    if not SHARED.is_dir():
        pytest.skip(f"real scans are not here: {SHARED}")
    return SHARED


@pytest.fixture(scope="session")
def leaves() -> Scan:
    """A simulated scan of six leaves before a wall, with truth per point."""
    from app.simulate.scenes import leaves_scan

    return leaves_scan(seed=4, leaves=6, step_deg=0.05)


@pytest.fixture(scope="session")
def leaves_file(leaves: Scan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same scan as a LAZ file with its sidecar."""
    from app.formats.cloud import Cloud
    from app.services.export import export

    path = tmp_path_factory.mktemp("scan") / "leaves.laz"
    export(Cloud(leaves), path)
    return path


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

"""Simulated series as files, made once."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.services.simulation import Targets
from app.services.simulation_order import Order
from app.services.simulation_series import simulate_series


@pytest.fixture(scope="session")
def stage(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pear leaf on a stage at 0 to 75° by 15°."""
    folder = tmp_path_factory.mktemp("series") / "stage"
    simulate_series(Order("goniometer"), "stage.angle_deg=0:75:15", Targets(folder))
    return folder


@pytest.fixture(scope="session")
def frame(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Twelve leaves in a frame at −40 to 40° by 20°, with two channels of raw numbers."""
    folder = tmp_path_factory.mktemp("series") / "frame"
    simulate_series(Order("leaf_frame"), "frame.angle_deg=-40:40:20", Targets(folder))
    return folder

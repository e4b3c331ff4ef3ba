"""Fixtures that every test may use."""

from __future__ import annotations

from pathlib import Path

import pytest

SHARED = Path(__file__).parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder with the real scans; tests that need it are skipped where it is missing."""
    if not SHARED.is_dir():
        pytest.skip(f"real scans are not here: {SHARED}")
    return SHARED

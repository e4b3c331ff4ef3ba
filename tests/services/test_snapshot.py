"""Pictures of a file: in perspective, or as its scanner saw it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from app.core.errors import MissingScanner
from app.render.legend import legend_height
from app.services.opening import Opening
from app.services.snapshot import snapshot_file

SIZE = (320, 200)


@pytest.fixture
def cloud(tmp_path: Path) -> Path:
    y, z = np.meshgrid(np.linspace(-1, 1, 120), np.linspace(-0.5, 0.5, 60))
    rows = np.stack((np.full(y.size, 3.0), y.ravel(), z.ravel(), y.ravel() + 2), axis=1)
    path = tmp_path / "wall.csv"
    np.savetxt(path, rows, delimiter=",", header="x,y,z,intensity", comments="")
    return path


def test_a_scan_image_needs_no_camera(cloud: Path, tmp_path: Path) -> None:
    out = tmp_path / "image.png"
    opening = Opening(cloud, origin=(0.0, 0.0, 0.0))
    snapshot_file(opening, "intensity", out, SIZE, "dark", seen="image")
    picture = imread(out)[:, :, :3]
    assert picture.shape[:2] == SIZE[::-1]
    middle = (SIZE[1] - legend_height(SIZE)) // 2
    # +y, and so the high values, lies to the left of who looks along +x.
    assert picture[middle, 20].sum() > picture[middle, 300].sum() + 0.5


def test_without_a_position_it_is_refused_and_nothing_is_written(
    cloud: Path, tmp_path: Path
) -> None:
    out = tmp_path / "image.png"
    with pytest.raises(MissingScanner, match="scan image"):
        snapshot_file(Opening(cloud), "intensity", out, SIZE, seen="image")
    assert not out.exists()

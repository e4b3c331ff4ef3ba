"""Pictures of a file: in perspective, or as its scanner saw it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from app.core.errors import BadInput, MissingScanner, WrongUse
from app.render.legend import legend_height
from app.services.beams import typed_beam
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


def test_footprints_are_drawn_over_the_points(cloud: Path, tmp_path: Path) -> None:
    opening = Opening(cloud, origin=(0.0, 0.0, 0.0))
    beam = {"beam": typed_beam(60.0, 0.1), "radius": 0.05}
    plain, ringed = tmp_path / "plain.png", tmp_path / "ringed.png"
    snapshot_file(opening, "intensity", plain, SIZE, parameters=beam)
    snapshot_file(opening, "intensity", ringed, SIZE, parameters=beam, footprints=3)
    assert (imread(plain) != imread(ringed)).any(axis=2).sum() > 1000
    for how in ({"footprints": 0}, {"footprints": 3, "seen": "image"}):
        with pytest.raises(WrongUse, match="--footprints"):
            snapshot_file(opening, "intensity", tmp_path / "none.png", SIZE, **how)
    with pytest.raises(BadInput, match="beam of the scanner is unknown"):
        snapshot_file(opening, "intensity", tmp_path / "none.png", SIZE, footprints=3)
    assert not (tmp_path / "none.png").exists()

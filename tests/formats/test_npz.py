"""NPZ: numpy reads it without pickle."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from app.core.progress import QUIET
from app.formats import npz
from app.formats.cloud import Cloud
from app.formats.saving import save
from app.model.scan import Grid, Pose, Scan


def make_cloud() -> Cloud:
    grid = Grid(2, 2, np.array([0, 1], np.int32), np.array([1, 1], np.int32))
    attributes = {
        "intensity": np.array([1, 2], np.uint16),
        "../evil": np.ones(2),
        "xyz": np.ones(2),
    }
    scan = Scan("s", np.array([[0.1, 0.2, 0.3], [np.nan, 1, 2]]), attributes, grid=grid)
    scan = scan.with_pose(Pose((1.0, 2.0, 3.0)))
    return Cloud(scan, {"ghost": np.array([True, False])}, {"incidence": "deg"}, {"seed": 4})


def test_round_trip(tmp_path: Path) -> None:
    cloud = make_cloud()
    target = tmp_path / "a.npz"
    assert save(target, cloud, npz.write, sidecar=False) == (target,)
    with np.load(target, allow_pickle=False) as got:
        assert got["xyz"].tobytes() == cloud.scan.xyz.tobytes()
        assert got["intensity"].dtype == np.uint16
        assert got["ghost"].dtype == np.bool_
        assert got["row"].tolist() == [0, 1]
        assert set(got.files) == {
            "xyz", "intensity", ".._evil", "xyz_2", "ghost", "row", "column", "provenance"
        }  # fmt: skip
        provenance = json.loads(str(got["provenance"]))
    assert provenance["provenance"] == {"seed": 4}
    assert provenance["pose"]["position"] == [1, 2, 3]
    assert provenance["units"] == {"incidence": "deg"}


def test_empty_cloud(tmp_path: Path) -> None:
    npz.write(tmp_path / "a.npz", make_cloud().subset(np.empty(0, np.int64)), QUIET)
    with np.load(tmp_path / "a.npz") as got:
        assert got["xyz"].shape == (0, 3)


def test_same_cloud_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        npz.write(tmp_path / name, make_cloud(), QUIET)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()

"""Scans survive the way from the reading process to ours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.formats.handover import load_scans, save_scans
from app.model.scan import Channel, Grid, Pose, Scan


def make_scan() -> Scan:
    rng = np.random.default_rng(1)
    return Scan(
        name="../ω/scan\n1",
        xyz=rng.normal(size=(5, 3)) * 1e6,
        attributes={
            "../../etc/passwd": np.arange(5, dtype=np.uint16),
            "ghost": np.array([True, False, True, False, True]),
            "Reflectance [dB]": np.array([1, np.nan, -np.inf, 0, 2], np.float32),
        },
        channels=(Channel("c", "ghost", 1545.0, "dB", "file", 0.1),),
        pose=Pose((1.5, 2.5, 3.5), ((0, -1, 0), (1, 0, 0), (0, 0, 1)), "assumed"),
        grid=Grid(3, 4, np.arange(5, dtype=np.int32) % 3, np.zeros(5, np.int32), np.array([7, 8])),
        metadata={"sensorModel": "x"},
        warnings=("one", "two"),
    )


def test_everything_comes_back(tmp_path: Path) -> None:
    scan = make_scan()
    save_scans([scan, Scan("empty", np.empty((0, 3)))], tmp_path)
    back, empty = load_scans(tmp_path)
    assert np.array_equal(back.xyz, scan.xyz)
    assert list(back.attributes) == list(scan.attributes)
    for name, values in scan.attributes.items():
        assert back.attributes[name].dtype == values.dtype
        assert np.array_equal(back.attributes[name], values, equal_nan=values.dtype.kind == "f")
    assert (back.name, back.channels, back.pose) == (scan.name, scan.channels, scan.pose)
    assert (back.metadata, back.warnings) == (scan.metadata, scan.warnings)
    assert back.grid is not None
    assert scan.grid is not None
    assert (back.grid.rows, back.grid.columns) == (3, 4)
    for part in ("row", "column", "no_return"):
        assert np.array_equal(getattr(back.grid, part), getattr(scan.grid, part))
    assert (len(empty), empty.pose, empty.grid) == (0, None, None)


def test_names_never_become_paths(tmp_path: Path) -> None:
    folder = tmp_path / "inner"
    folder.mkdir()
    save_scans([make_scan()], folder)
    assert [p.name for p in tmp_path.iterdir()] == ["inner"]
    assert all(p.suffix in {".npy", ".json"} for p in folder.iterdir())


def test_objects_are_refused(tmp_path: Path) -> None:
    scan = Scan("bad", np.zeros((1, 3)), {"o": np.array([{}], object)})
    with pytest.raises(ValueError, match="allow_pickle"):
        save_scans([scan], tmp_path)

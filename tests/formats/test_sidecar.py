"""What travels beside a file, and when it is not believed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput
from app.core.progress import QUIET
from app.formats import csv_table, text
from app.formats.cloud import Cloud
from app.formats.options import ReadOptions
from app.formats.saving import save
from app.formats.sidecar import find_sidecar, read_sidecar, restore_sidecar, sidecar_path
from app.model.scan import Channel, Grid, Pose, Scan


def make_cloud() -> Cloud:
    cells = np.arange(4, dtype=np.int32)
    scan = Scan(
        "s",
        np.arange(12.0).reshape(4, 3) / 7,
        {"intensity_1545": np.arange(4, dtype=np.float32) / 3},
        channels=(Channel("SWIR", "intensity_1545", 1545.0, "reflectance", "panel", 0.1),),
        pose=Pose((0.1, 0.2, 0.3), known_by="assumed"),
        grid=Grid(2, 5, cells % 2, cells, np.array([9, 4, 5])),
    )
    return Cloud(scan, {"ghost": cells > 1}, {"intensity_1545": "1"}, {"who": "test"})


def write_csv(tmp_path: Path) -> Path:
    target = tmp_path / "a.csv"
    written = save(target, make_cloud(), csv_table.write)
    assert written == (target, tmp_path / "a.csv.leafscope.json")
    return target


def test_csv_round_trip_restores_everything(tmp_path: Path) -> None:
    path = write_csv(tmp_path)
    (scan,) = text.read(path, ReadOptions(), QUIET)
    cloud = make_cloud()
    assert scan.xyz.tobytes() == cloud.scan.xyz.tobytes()
    assert scan.attributes["intensity_1545"].dtype == np.float32
    assert scan.attributes["ghost"].dtype == np.bool_
    for name, values in {**cloud.scan.attributes, **cloud.fields}.items():
        np.testing.assert_array_equal(scan.attributes[name], values)
    assert (scan.channels, scan.pose) == (cloud.scan.channels, cloud.scan.pose)
    assert scan.grid is not None
    assert cloud.scan.grid is not None
    np.testing.assert_array_equal(scan.grid.row, cloud.scan.grid.row)
    np.testing.assert_array_equal(scan.grid.column, cloud.scan.grid.column)
    assert scan.grid.no_return.tolist() == [4, 5, 9]
    assert scan.metadata["unit of intensity_1545"] == "1"


def test_part_of_the_points_keeps_its_cells(tmp_path: Path) -> None:
    (scan,) = text.read(write_csv(tmp_path), ReadOptions(every_nth=2), QUIET)
    assert scan.grid is not None
    assert scan.grid.column.tolist() == [0, 2]


def test_stale_sidecar_is_ignored_with_a_warning(tmp_path: Path) -> None:
    path = write_csv(tmp_path)
    content = path.read_text()
    path.write_text(content[:-2] + ("1" if content[-2] == "0" else "0") + "\n")  # the same size
    with pytest.raises(BadInput, match="has changed"):
        read_sidecar(path)
    (scan,) = text.read(path, ReadOptions(), QUIET)
    assert scan.pose is None
    assert "has changed since" in scan.warnings[0]


def test_no_sidecar(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("x,y,z\n1,2,3\n")
    assert find_sidecar(path) == (None, ())
    scan = Scan("s", np.zeros((1, 3)))
    assert restore_sidecar(path, scan).warnings == ()


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("version", 2),
        ("version", "x"),
        ("size", -1),
        ("pose", {"position": [1, 2]}),
        ("channels", [{"name": 1}]),
        ("grid", []),
    ],
)
def test_damaged_sidecar_is_ignored_with_a_warning(tmp_path: Path, key: str, value: object) -> None:
    path = write_csv(tmp_path)
    change_sidecar(path, key, value)
    (scan,) = text.read(path, ReadOptions(), QUIET)
    assert scan.pose is None
    assert "ignored" in scan.warnings[0]


@pytest.mark.parametrize(
    "grid",
    [
        {"rows": 1, "columns": 5},
        {"rows": 2, "columns": 3},
        {"rows": 0, "columns": 0},
        {"rows": 2**40, "columns": 2**40},
        {"rows": 2, "columns": 5, "no_return": [[0, 10**15]]},
        {"rows": 2, "columns": 5, "no_return": [[4, 2], [5, 1]]},
        {"rows": 2, "columns": 5, "no_return": [[-1, 2]]},
        {"rows": 2, "columns": 5, "no_return": [[9, 2]]},
    ],
)
def test_impossible_grid_is_ignored_with_a_warning(tmp_path: Path, grid: dict[str, object]) -> None:
    path = write_csv(tmp_path)
    change_sidecar(path, "grid", grid)
    (scan,) = text.read(path, ReadOptions(), QUIET)
    assert scan.grid is None
    assert set(scan.attributes) >= {"row", "column"}
    assert "ignored" in scan.warnings[0]


@pytest.mark.parametrize("type_name", ["O", "|O8", "<U4", "<i8x", "", "<M8", "|u1", "<f9"])
def test_strange_types_change_no_value(tmp_path: Path, type_name: str) -> None:
    path = write_csv(tmp_path)
    change_sidecar(path, "types", {"intensity_1545": type_name})
    (scan,) = text.read(path, ReadOptions(), QUIET)
    want = make_cloud().scan.attributes["intensity_1545"]
    np.testing.assert_allclose(scan.attributes["intensity_1545"], want, rtol=1e-6)


@given(st.binary(max_size=40))
def test_noise(tmp_path_factory: pytest.TempPathFactory, noise: bytes) -> None:
    path = tmp_path_factory.mktemp("side") / "a.csv"
    path.write_text("x,y,z\n1,2,3\n")
    sidecar_path(path).write_bytes(noise)
    assert find_sidecar(path)[0] is None


def test_many_lonely_beams_without_echo_stay_small(tmp_path: Path) -> None:
    cells = np.zeros(1, np.int32)
    lonely = np.arange(1, 400_000, 2)
    scan = Scan("s", np.zeros((1, 3)), grid=Grid(1000, 400, cells, cells, lonely))
    save(tmp_path / "a.csv", Cloud(scan), csv_table.write)
    assert sidecar_path(tmp_path / "a.csv").stat().st_size < 12 * len(lonely)
    (back,) = text.read(tmp_path / "a.csv", ReadOptions(), QUIET)
    assert back.grid is not None
    np.testing.assert_array_equal(back.grid.no_return, lonely)


def test_facts_of_the_points_stay_and_those_of_the_old_file_go(tmp_path: Path) -> None:
    facts = {"instrument": "X", "format": "E57 1.0", "las_scale": "1 1 1", "long": "x" * 100_000}
    cloud = make_cloud()
    save(
        tmp_path / "a.csv",
        replace(cloud, scan=replace(cloud.scan, metadata=facts)),
        csv_table.write,
    )
    (back,) = text.read(tmp_path / "a.csv", ReadOptions(), QUIET)
    assert back.metadata["instrument"] == "X"
    assert "las_scale" not in back.metadata
    assert "long" not in back.metadata
    assert back.metadata["format"] == text.NAME


def change_sidecar(path: Path, key: str, value: object) -> None:
    place = sidecar_path(path)
    content = json.loads(place.read_bytes())
    place.write_text(json.dumps({**content, key: value}))

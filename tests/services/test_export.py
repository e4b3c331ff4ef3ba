"""What is gathered for a file, and that all of it comes back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import laspy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.core.errors import BadInput
from app.formats.cloud import Cloud, take_points
from app.model.operations import AddScan
from app.model.project import Project
from app.model.scan import Pose, Scan
from app.model.view_state import ViewState
from app.services.export import export, gather
from app.services.opening import Opening, open_file
from app.services.sessions import open_session, save_session

KEY = "scan-00001"


def test_a_computed_field_hides_an_older_one_that_the_file_holds(leaves: Scan) -> None:
    old = np.full(len(leaves), -7.0)
    scan = replace(leaves, attributes={**leaves.attributes, "range": old, "ghost": old})
    project = Project()
    project.do(AddScan(project.shelve(scan), "old", None))
    columns = gather(project, KEY, ["range", "reflectance_1063", "truth_leaf"]).columns
    np.testing.assert_array_equal(columns["range"], project.field(KEY, "range"))
    assert columns["range"].min() > 0
    assert columns["ghost"] is old  # nobody asked for it: the file's own values travel
    for name in ("reflectance_1063", "truth_leaf"):
        assert columns[name].dtype == leaves.attributes[name].dtype


@pytest.fixture(scope="module")
def several(leaves: Scan) -> Scan:
    """The scan of a turned scanner, with values of every kind."""
    random = np.random.default_rng(3)
    n = len(leaves)
    turn = Rotation.from_euler("zyx", [40.0, -20.0, 170.0], degrees=True).as_matrix()
    x, y, z = (tuple(axis) for axis in turn.tolist())
    pose = Pose((1.5, -2.0, 1.7), (x, y, z))
    local = leaves.xyz - leaves.scanner("the test")
    gaps = np.where(random.random(n) < 0.1, np.nan, random.normal(size=n))
    own = {
        "truth_gaps": gaps,
        "truth_gaps_4": gaps.astype(np.float32),
        "truth_number": random.integers(-(2**31), 2**31, n).astype(np.int32),
        "truth_small": random.integers(0, 256, n).astype(np.uint8),
        "truth_flag": random.random(n) < 0.5,
        "return_number": random.integers(1, 5, n).astype(np.uint8),
        "number_of_returns": random.integers(5, 16, n).astype(np.uint8),
    }
    xyz = local @ turn.T + np.array(pose.position)
    whole = replace(leaves, xyz=xyz, pose=pose, attributes={**leaves.attributes, **own})
    return lose_echoes(whole, random.random(n) < 0.2)


def lose_echoes(scan: Scan, lost: np.ndarray) -> Scan:
    """Without some points; the file knows of every second one that its beam had no echo."""
    grid = scan.grid
    assert grid is not None
    silent = (grid.row * grid.columns + grid.column)[lost].astype(np.int64)
    scan = take_points(scan, ~lost)
    assert scan.grid is not None
    return replace(scan, grid=replace(scan.grid, no_return=np.sort(silent)[::2]))


def bring_back(scan: Scan, path: Path) -> Scan:
    export(Cloud(scan, {}, {"truth_gaps": "m"}), path)
    project, (key,) = open_file(Opening(path))
    return project.state.scan(key).scan


def assert_same(back: Scan, scan: Scan, order: np.ndarray, tolerance: float) -> None:
    np.testing.assert_allclose(back.xyz, scan.xyz[order], rtol=0, atol=tolerance)
    assert set(back.attributes) == set(scan.attributes)
    for name, values in scan.attributes.items():
        assert back.attributes[name].dtype == values.dtype, name
        assert back.attributes[name].tobytes() == values[order].tobytes(), name
    assert back.grid is not None
    assert scan.grid is not None
    assert (back.grid.rows, back.grid.columns) == (scan.grid.rows, scan.grid.columns)
    np.testing.assert_array_equal(back.grid.row, scan.grid.row[order])
    np.testing.assert_array_equal(back.grid.column, scan.grid.column[order])
    np.testing.assert_array_equal(back.grid.no_return, np.sort(scan.grid.no_return))
    assert back.pose is not None
    assert scan.pose is not None
    assert back.pose.position == scan.pose.position
    np.testing.assert_allclose(back.pose.rotation, scan.pose.rotation, rtol=0, atol=1e-15)
    assert back.channels == scan.channels
    assert back.metadata["unit of truth_gaps"] == "m"
    assert scan.metadata.items() <= back.metadata.items()
    assert back.warnings == ()


@pytest.mark.parametrize(
    ("suffix", "tolerance"), [(".e57", 1e-14), (".laz", 5.1e-6), (".las", 5.1e-6), (".ptx", 1e-6)]
)
def test_all_of_a_scan_comes_back(
    several: Scan, tmp_path: Path, suffix: str, tolerance: float
) -> None:
    assert several.grid is not None
    order = np.arange(len(several))
    if suffix == ".ptx":  # column by column
        order = np.lexsort((several.grid.row, several.grid.column))
    assert_same(bring_back(several, tmp_path / f"a{suffix}"), several, order, tolerance)


@pytest.mark.parametrize(("suffix", "tolerance"), [(".e57", 1e-14), (".laz", 5.1e-6)])
def test_several_returns_of_one_beam_come_back(
    several: Scan, tmp_path: Path, suffix: str, tolerance: float
) -> None:
    assert several.grid is not None
    # Pairs of columns become one cell; beams without echo are those of cells without a point.
    first = several.grid.column // 2 * 2
    held = several.grid.row.astype(np.int64) * several.grid.columns + first
    silent = np.setdiff1d(several.grid.no_return, held)
    scan = replace(several, grid=replace(several.grid, column=first, no_return=silent))
    order = np.arange(len(scan))
    assert_same(bring_back(scan, tmp_path / f"a{suffix}"), scan, order, tolerance)
    with pytest.raises(BadInput, match=r"one point per cell.*E57 or LAZ"):
        export(Cloud(scan), tmp_path / "a.ptx")


def test_las_keeps_return_numbers_where_others_look_for_them(several: Scan, tmp_path: Path) -> None:
    export(Cloud(several), tmp_path / "a.laz")
    other = laspy.read(tmp_path / "a.laz")
    for name in ("return_number", "number_of_returns"):
        np.testing.assert_array_equal(np.asarray(other[name]), several.attributes[name])
        assert name not in list(other.point_format.extra_dimension_names)


def test_a_session_notices_that_the_columns_of_a_ptx_are_gone(
    several: Scan, tmp_path: Path
) -> None:
    export(Cloud(several), tmp_path / "a.ptx")
    project, _ = open_file(Opening(tmp_path / "a.ptx"))
    save_session(project, ViewState(), tmp_path / "a.leafscope")
    open_session(tmp_path / "a.leafscope")
    (tmp_path / "a.ptx.fields.npz").unlink()
    with pytest.raises(BadInput, match="has changed or is gone"):
        open_session(tmp_path / "a.leafscope")

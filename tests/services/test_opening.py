from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.scanner import fit_spherical
from app.model.project import Project
from app.model.scan import Scan
from app.services.opening import (
    Opening,
    add_scans,
    given_pose,
    name_channels,
    open_file,
    parse_origin,
    propose_pose,
)


def test_opening_is_one_step_of_the_history(leaves: Scan) -> None:
    project = Project()
    assert add_scans(project, [leaves, leaves], (0.0, 0.0, 1.0)) == ["scan-00001", "scan-00002"]
    assert len(project.history.done) == 1
    assert project.state.scan("scan-00002").scan.pose.known_by == "given"
    project.undo()
    assert not project.state.scans


def test_origin_and_channel_from_the_command(tmp_path: Path) -> None:
    table = tmp_path / "a.csv"
    table.write_text("x,y,z,echo\n0,0,1,-3\n0,1,1,-4\n1,0,1,-5\n")
    opening = Opening(table, origin=(0.0, 0.0, 0.0), channels=("echo=1550:dB",))
    project, (key,) = open_file(opening)
    channel = project.state.scan(key).scan.channel("echo")
    assert (channel.wavelength_nm, channel.kind) == (1550.0, "dB")
    np.testing.assert_array_equal(project.field(key, "echo"), [-3, -4, -5])


@pytest.mark.parametrize("text", ["echo", "echo=green", "echo=1550:bright", "nothing=1:dB"])
def test_a_channel_that_says_nothing_is_refused(text: str) -> None:
    scan = Scan("s", np.zeros((2, 3)), {"echo": np.arange(2)})
    if text == "echo":
        assert name_channels(scan, [text])[0].kind == "DN"
    else:
        with pytest.raises(WrongUse):
            name_channels(scan, [text])


@pytest.mark.parametrize("text", ["", "1,2", "1,2,3,4", "a,b,c", "nan,0,0", "inf,0,0"])
def test_an_origin_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(WrongUse, match="--origin"):
        parse_origin(text)


def test_a_position_is_proposed_only_where_the_grid_speaks_for_it(leaves: Scan) -> None:
    place = np.array(leaves.pose.position)
    centred = replace(leaves, xyz=leaves.xyz - place, pose=None)
    proposed = propose_pose(centred)
    assert proposed.position == (0.0, 0.0, 0.0)
    assert proposed.known_by == "assumed"
    assert given_pose((0.0, 0.0, 0.0), centred) == proposed
    assert given_pose((0.0, 0.0, 0.5), centred).known_by == "given"
    assert propose_pose(replace(leaves, pose=None)) is None
    assert propose_pose(leaves) is None
    assert propose_pose(replace(centred, grid=None)) is None


def test_the_fit_of_a_grid_gives_its_steps(leaves: Scan) -> None:
    fit = fit_spherical(
        leaves.xyz, leaves.grid.row, leaves.grid.column, np.array(leaves.pose.position)
    )
    assert np.degrees(abs(fit.row_step)) == pytest.approx(0.05, rel=0.02)
    assert np.degrees(abs(fit.column_step)) == pytest.approx(0.05, rel=0.02)


@pytest.mark.data
def test_the_pump_speaks_for_its_origin(shared_data: Path) -> None:
    from app.services.reading import read_file

    (scan,) = read_file(shared_data / "pump_e57_gridded" / "pumpAVisualReferenceImage.e57")
    assert scan.pose is None
    assert propose_pose(scan).known_by == "assumed"
    for wrong in ((0.1, 0, 0), (0, -0.1, 0), (0, 0, 0.1)):
        moved = replace(scan, xyz=scan.xyz + np.array(wrong))
        assert propose_pose(moved) is None

"""The mesh of the leaf in the picture follows leaf and wish; areas stand in the table."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace
from PySide6.QtCore import QObject, Qt

from app.model.operations import SetDeleted, SetParameters
from app.model.points import PointSet
from app.services.beams import typed_beam
from app.services.leaves import leaves_from_labels
from app.services.opening import add_scans
from app.services.surfaces.files import write_surfaces
from app.services.surfaces.meshes import tell_area
from app.simulate.scenes import leaves_scan
from widgets.common.leaf_areas import LeafAreas
from widgets.common.leaf_table import LeafTable
from widgets.controller import Controller
from widgets.mesh_overlay import MeshOverlay


class View:
    """Remembers what it is to draw."""

    def __init__(self) -> None:
        self.shown: list[object] = []
        self.drawings = self

    def show_mesh(self, triangles: object) -> None:
        self.shown.append(triangles)


class Picture:
    def __init__(self) -> None:
        self.view = View()


@pytest.fixture
def overlay(qtbot) -> Iterator[MeshOverlay]:
    parent, controller = QObject(), Controller()
    areas = LeafAreas(controller, parent)
    overlay = MeshOverlay(controller, Picture(), areas, parent)
    (key,) = add_scans(controller.project, [leaves_scan(seed=4, leaves=2, step_deg=0.06)])
    leaves_from_labels(controller.project, key, "truth_leaf")
    controller.look(current=key)
    overlay.said = []
    controller.said.connect(overlay.said.append)
    yield overlay
    overlay.stop()
    controller.close()
    controller.deleteLater()
    parent.deleteLater()


def settle(overlay: MeshOverlay, qtbot) -> None:
    bridge = overlay._controller.bridge
    qtbot.waitUntil(lambda: not overlay._later.isActive() and not bridge.jobs, timeout=60_000)
    qtbot.waitUntil(lambda: not overlay._later.isActive(), timeout=60_000)


def leaves_of(controller: Controller):
    return controller.project.state.leaves_of(controller.current)


def give_beam(controller: Controller, diameter: float) -> None:
    state, key = controller.scan, controller.current
    beam = typed_beam(diameter, 0.014)
    controller.do(SetParameters(key, replace(state.parameters, beam=beam)))


def test_it_follows_leaf_beam_and_wish(overlay, qtbot) -> None:
    controller, view = overlay._controller, overlay._picture.view
    give_beam(controller, 3.0)
    first, second = leaves_of(controller)[:2]
    controller.look(show_mesh=True)
    settle(overlay, qtbot)
    assert overlay.shown is None
    assert "Choose a leaf" in overlay.said[-1]
    controller.look(leaf=first.key)
    settle(overlay, qtbot)
    vertices, faces, omega = view.shown[-1]
    assert len(faces) == len(omega) > 50
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    xyz = controller.scan.scan.xyz[first.members.indices]
    assert (low > xyz.min(axis=0) - 0.01).all()
    assert (high < xyz.max(axis=0) + 0.01).all()
    assert "cm²" in overlay.said[-1]
    before = overlay.shown.mesh.area.value
    give_beam(controller, 8.0)
    settle(overlay, qtbot)
    assert overlay.shown.mesh.area.value != before
    controller.look(leaf=second.key)
    settle(overlay, qtbot)
    assert overlay.shown.key == second.key
    controller.look(show_mesh=False)
    settle(overlay, qtbot)
    assert overlay.shown is None
    assert view.shown[-1] is None


def test_a_leaf_without_a_mesh_says_why(overlay, qtbot) -> None:
    controller = overlay._controller
    leaf = leaves_of(controller)[0]
    rows = leaf.members.indices[5:]
    controller.do(SetDeleted(controller.current, PointSet(rows), True))
    controller.look(show_mesh=True, leaf=leaf.key)
    settle(overlay, qtbot)
    assert overlay.shown.mesh is None
    assert "no surface" in overlay.said[-1]


def test_areas_stand_in_the_table_and_meshes_in_files(overlay, qtbot, tmp_path: Path) -> None:
    controller, areas = overlay._controller, overlay._areas
    leaves = leaves_of(controller)
    areas.measure(leaves)
    settle(overlay, qtbot)
    surfaces = areas.results(leaves)
    assert set(surfaces) == {leaf.key for leaf in leaves}
    table = LeafTable()
    rows = {key: {"points": 1, **row} for key, row in areas.rows(leaves).items()}
    table.show_leaves(leaves, rows, ())
    titles = [table.headerData(k, Qt.Orientation.Horizontal) for k in range(table.columnCount())]
    place = titles.index("Area (cm²)")
    for row, leaf in enumerate(leaves):
        area = surfaces[leaf.key].mesh.area
        text = table.data(table.index(row, place))
        expected = f"{area.value * 1e4:.1f}"
        assert text.startswith(expected if area.sure else f"≥ {expected}")
        tip = table.data(table.index(row, place), 3)
        assert tip == tell_area(surfaces[leaf.key])["area_of"]
        assert (tip == "leaf") == area.sure
    write_surfaces(list(surfaces.values()), tmp_path / "leaves.stl")
    assert (tmp_path / "leaves.stl").stat().st_size > 1000
    again = dict(surfaces)
    areas.measure(leaves)
    settle(overlay, qtbot)
    assert all(areas.results(leaves)[key] is again[key] for key in again)


def test_an_unmeasured_leaf_has_dots(overlay) -> None:
    leaves = leaves_of(overlay._controller)
    table = LeafTable()
    table.show_leaves(leaves, {leaves[0].key: {"points": np.int64(3)}}, ())
    assert table.data(table.index(0, 2)) == "…"
    assert table.data(table.index(1, 2)) == "…"

"""The index panel: numbers of the commands, a spread, a slider that smooths the view."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage, QPainter
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from app.cli import run
from app.formats.cloud import Cloud
from app.services.export import export
from app.services.leaves import leaves_from_labels
from app.services.synthetic_footprints import find_reached
from app.simulate.scenes import leaf_row_scan
from widgets.common.index.angle_plot import ExtremesSample
from widgets.common.index.size_slider import LARGEST_MM, STEPS, to_size, to_step
from widgets.common.plots import GREEN
from widgets.common.step_titles import title_steps
from widgets.fields_at_hand import list_fields
from widgets.panels.index import IndexPanel

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def panel(opened, qtbot):
    panel = opened.show(IndexPanel)
    qtbot.waitUntil(lambda: panel.angles.found is not None, timeout=60_000)
    rest(panel, qtbot)
    return panel


def rest(panel, qtbot) -> None:
    qtbot.waitUntil(
        lambda: not panel._later.isActive() and not panel.controller.bridge.jobs, timeout=60_000
    )


def choose(panel, box, data, qtbot) -> None:
    row = next(i for i in range(box.count()) if box.itemData(i) == data)
    box.setFocus()
    while box.currentIndex() != row:
        QTest.keyClick(box, Qt.Key.Key_Down if box.currentIndex() < row else Qt.Key.Key_Up)
    rest(panel, qtbot)


def open_row(desk, qtbot, tmp_path: Path) -> Path:
    path = tmp_path / "row.laz"
    export(Cloud(leaf_row_scan(step_deg=0.06, noise_m=0.0004, seed=2)), path)
    desk.documents.open([path])
    qtbot.waitUntil(lambda: desk.controller.current is not None, timeout=30_000)
    leaves_from_labels(desk.controller.project, desk.controller.current, "truth_leaf")
    return path


def save_as(panel, page, kind: str, path: Path, qtbot) -> None:
    """Choose a kind in the menu of the export button, and a name."""
    action = next(a for a in page.export.menu().actions() if a.objectName() == kind)
    action.trigger()
    dialog = next(d for d in panel.findChildren(QFileDialog) if d.isVisible())
    dialog.fileSelected.emit(str(path))
    dialog.reject()
    qtbot.waitUntil(path.is_file, timeout=30_000)
    rest(panel, qtbot)


def read(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_the_numbers_are_those_of_the_command(desk, qtbot, tmp_path: Path) -> None:
    path = open_row(desk, qtbot, tmp_path)
    out, curve = tmp_path / "o.csv", tmp_path / "c.csv"
    words = ["--index", "ndi", "--label-field", "truth_leaf", "--out", str(out)]
    assert run(["index-angle", str(path), *words, "--curve", str(curve)]) == 0
    panel = desk.show(IndexPanel)
    qtbot.waitUntil(lambda: panel.angles.found is not None, timeout=60_000)
    rows, curves = tmp_path / "rows.csv", tmp_path / "curves.csv"
    save_as(panel, panel.angles, "rows.csv", rows, qtbot)
    save_as(panel, panel.angles, "curves.csv", curves, qtbot)
    assert read(rows) == read(out)
    assert read(curves) == read(curve)
    for kind in ("table.tex", "picture.png"):
        save_as(panel, panel.angles, kind, tmp_path / kind, qtbot)
    choose(panel, panel.form.leaves_box, "together", qtbot)
    assert run(["index-angle", str(path), *words, "--together", "--overwrite"]) == 0
    save_as(panel, panel.angles, "rows.csv", rows, qtbot)
    assert read(rows) == read(out)


def test_the_spread_is_that_of_the_command(desk, qtbot, tmp_path: Path) -> None:
    path, out = open_row(desk, qtbot, tmp_path), tmp_path / "s.csv"
    words = ["--index", "ndi", "--label-field", "truth_leaf", "--out", str(out)]
    assert run(["synthetic-footprint", str(path), *words]) == 0
    panel = desk.show(IndexPanel)
    qtbot.mouseClick(panel.tabs, LEFT, pos=panel.tabs.tabRect(1).center())
    rest(panel, qtbot)
    page = panel.footprint
    qtbot.mouseClick(page.measure_button, LEFT)
    qtbot.waitUntil(lambda: page.found is not None, timeout=60_000)
    save_as(panel, page, "spread.csv", tmp_path / "window.csv", qtbot)
    assert read(tmp_path / "window.csv") == read(out)
    save_as(panel, page, "spread.svg", tmp_path / "s.svg", qtbot)
    first = page.found
    page.error.setFocus()
    page.error.selectAll()
    QTest.keyClicks(page.error, "0.035")
    QTest.keyClick(page.error, Qt.Key.Key_Return)
    assert page.found is first  # another error needs no other spread
    reached = find_reached(first.rows, 0.035)
    assert page.reached_mm == reached
    assert f"{reached:.1f} mm" in page.words.text()
    choose(panel, panel.form.leaves_box, "leaf", qtbot)
    desk.controller.look(leaf="leaf-00001")
    qtbot.waitUntil(lambda: page.found is None)


def test_a_row_draws_its_leaf_and_says_it_in_words(panel, qtbot) -> None:
    table, found = panel.angles.table, panel.angles.found
    assert [table.item(i, 0).text() for i in range(table.rowCount())] == ["Leaf 1", "Leaf 2"]
    first, _ = panel.angles.plot.curve.getData()
    qtbot.mouseClick(table.viewport(), LEFT, pos=table.visualItemRect(table.item(1, 0)).center())
    assert panel.angles.leaf == "Leaf 2"
    assert panel.angles.words.text().startswith("Leaf 2: ndi on the curve runs from")
    _, y = panel.angles.plot.curve.getData()
    mine = [r for r in found.curves if (r["leaf"], r["curve"]) == ("Leaf 2", "fitted")]
    assert list(y) == [r["index"] for r in mine]
    assert len(first) == len([r for r in found.curves if r["leaf"] == "Leaf 1"
                              and r["curve"] == "fitted"])  # fmt: skip
    beyond = "exceeds the noise" if found.rows[1]["A_exceeds_noise"] else "does not exceed"
    assert beyond in panel.angles.words.text()


def test_another_model_and_the_whole_scan(panel, qtbot) -> None:
    before = panel.angles.found
    choose(panel, panel.angles.model_box, "lambert-beckmann", qtbot)
    assert panel.angles.found is not before
    choose(panel, panel.form.leaves_box, "scan", qtbot)
    assert panel.angles.leaf == "whole scan"


def test_the_slider_smooths_the_view_in_one_step(panel, opened, qtbot) -> None:
    opened.controller.look(colour="ndi")
    qtbot.mouseClick(panel.tabs, LEFT, pos=panel.tabs.tabRect(1).center())
    rest(panel, qtbot)
    page, history = panel.footprint, opened.controller.project.history
    steps, slider = len(history.done), page.smoothing.slider
    assert "Off" in page.note.text()
    slider.setFocus()
    slider.setSliderDown(True)
    for step in (20, 30, 40):
        slider.setSliderPosition(step)
        qtbot.wait(150)
    slider.setSliderDown(False)
    rest(panel, qtbot)
    size = opened.controller.scan.parameters.synthetic_footprint
    assert size == pytest.approx(to_size(40) / 1000)
    assert len(history.done) == steps + 1
    assert opened.controller.view.colour == "ndi_smoothed"
    assert "near" in page.note.text()
    assert f"{to_size(40):g} mm" in page.note.text()
    project, key = opened.controller.project, opened.controller.current
    told = [e.operation for e in history.log if e.operation is not None]
    assert title_steps(told)[-1] == f"Smooth channels over {to_size(40):g} mm"
    groups = {f.name: f.group for f in list_fields(project, key)}
    assert groups["ndi_smoothed"] == groups["near_smoothed"] == "Smoothed"
    opened.controller.undo()
    rest(panel, qtbot)
    assert opened.controller.view.colour == "ndi"
    assert slider.value() == 0


def test_typed_sizes_and_zero(panel, opened, qtbot) -> None:
    qtbot.mouseClick(panel.tabs, LEFT, pos=panel.tabs.tabRect(1).center())
    rest(panel, qtbot)
    field = panel.footprint.smoothing.field
    for text, metres in (("25", 0.025), ("0", None)):
        field.setFocus()
        field.selectAll()
        QTest.keyClicks(field, text)
        QTest.keyClick(field, Qt.Key.Key_Return)
        rest(panel, qtbot)
        assert opened.controller.scan.parameters.synthetic_footprint == metres


def test_steps_of_the_slider_cover_the_sizes() -> None:
    assert [to_size(0), to_size(1), to_size(STEPS)] == [0.0, 1.0, LARGEST_MM]
    assert all(to_step(to_size(step)) == step for step in range(STEPS + 1) if to_size(step) > 2)


def test_missing_things_are_said(desk, qtbot, make_scan) -> None:
    panel = desk.show(IndexPanel)
    assert "Open a scan" in panel.notice.text
    key = desk.open(make_scan(pose=False))
    qtbot.waitUntil(lambda: "where the scanner stood" in panel.notice.text)
    desk.documents.set_origin(key, (0.0, 0.0, 0.0))
    qtbot.waitUntil(lambda: "no leaf yet" in panel.notice.text)
    with qtbot.waitSignal(panel.own_asked):
        qtbot.mouseClick(panel.form.own_button, LEFT)


def test_the_legend_lies_above_the_data(panel, qtbot) -> None:
    plot = panel.angles.plot
    qtbot.wait(50)
    legend, data = plot._legend, plot.getViewBox()
    assert legend.sceneBoundingRect().bottom() <= data.sceneBoundingRect().top()
    samples = [sample for sample, _ in legend.items]
    assert isinstance(samples[-1], ExtremesSample)
    picture = QImage(30, 20, QImage.Format.Format_ARGB32)
    picture.fill(Qt.GlobalColor.white)
    painter = QPainter(picture)
    samples[-1].paint(painter)
    painter.end()
    green = [[picture.pixelColor(x, y).name() == GREEN for x in range(30)] for y in range(20)]
    # One stands on its tip, the other on its base: the wider rows are above and below.
    left = [sum(row[:10]) for row in green]
    right = [sum(row[11:22]) for row in green]
    assert sum(left[:10]) > sum(left[11:])
    assert sum(right[:10]) < sum(right[11:])
    assert not any(any(row[23:]) for row in green)

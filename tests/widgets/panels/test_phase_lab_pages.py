"""The pages of the lab: models side by side, certainty, table; and what leaves the window."""

from __future__ import annotations

import csv

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFileDialog, QLineEdit

from app.core.phase import MODELS
from app.services.lab.compare import compare
from app.services.lab.fit_table import each_leaf, tabulate_fits
from app.services.lab.method import Method
from app.services.lab.table_files import fits_as_text
from app.services.lab.uncertainty import profile
from widgets.panels.phase_lab import PhaseLabPanel

LEFT = Qt.MouseButton.LeftButton
CURVE, MODELS_PAGE, CERTAINTY, TABLE = range(4)


@pytest.fixture
def lab(opened, qtbot):
    panel = opened.show(PhaseLabPanel)
    qtbot.waitUntil(lambda: panel.editor.points.count > 0, timeout=60_000)
    return panel


def turn_to(lab, qtbot, page: int) -> None:
    bar = lab.pages.tabs
    qtbot.mouseClick(bar, LEFT, pos=bar.tabRect(page).center())
    assert bar.currentIndex() == page


def pool(lab, opened, qtbot) -> None:
    lab.choose_leaves(tuple(opened.state.leaves))
    lab.choice.points_box.setFocus()
    qtbot.keyClick(lab.choice.points_box, Qt.Key.Key_Down)
    qtbot.waitUntil(lambda: lab.editor.points.count > 4500, timeout=30_000)


def fit(lab, qtbot) -> None:
    qtbot.mouseClick(lab.fit_button, LEFT)
    qtbot.waitUntil(lambda: lab.editor.result is not None, timeout=30_000)


def save_as(lab, qtbot, path) -> None:
    dialog = lab.findChild(QFileDialog)
    dialog.setDirectory(str(path.parent))
    line = dialog.findChild(QLineEdit)
    line.setText(path.name)
    dialog.accept()
    qtbot.waitUntil(path.is_file, timeout=60_000)


def test_models_are_compared_and_a_click_takes_one(lab, opened, qtbot) -> None:
    turn_to(lab, qtbot, MODELS_PAGE)
    page = lab.pages.models
    qtbot.waitUntil(lambda: page.table_shown is not None, timeout=60_000)
    measured = lab.editor.points.measured
    expected = compare(measured.angle, measured.value, list(MODELS), Method())
    assert [row.model for row in page.table_shown.rows][: len(MODELS)] == list(MODELS)
    for mine, other in zip(page.table_shown.rows, expected.rows, strict=False):
        assert mine.aicc == other.aicc
    assert page.table_shown.best.title in page.words.text()
    row = list(MODELS).index("incidence-b")
    rect = page.table.visualItemRect(page.table.item(row, 0))
    qtbot.mouseClick(page.table.viewport(), LEFT, pos=rect.center())
    qtbot.waitUntil(lambda: set(lab.editor.values) == {"a", "b"})
    assert lab.choice.model.name == "incidence-b"
    qtbot.mouseClick(page.copy_button, LEFT)
    lines = QGuiApplication.clipboard().text().splitlines()
    assert lines[0].split("\t")[0] == "Model"
    assert len(lines) == len(page.table_shown.rows) + 1


def test_intervals_are_those_of_the_service(lab, opened, qtbot) -> None:
    pool(lab, opened, qtbot)
    turn_to(lab, qtbot, CERTAINTY)
    page = lab.pages.certainty
    assert "Press Fit" in page.words.text()
    fit(lab, qtbot)
    qtbot.waitUntil(page.profile_button.isEnabled)
    qtbot.mouseClick(page.profile_button, LEFT)
    qtbot.waitUntil(lambda: "profile" in page.found, timeout=60_000)
    measured = lab.editor.points.measured
    assert page.found["profile"] == profile(
        Method(), "lambert-beckmann", measured.angle, measured.value
    )
    page.trials.setValue(200)
    qtbot.mouseClick(page.bootstrap_button, LEFT)
    qtbot.waitUntil(lambda: "bootstrap" in page.found, timeout=60_000)
    assert {row.name for row in page.found["bootstrap"]} == {"f", "k_d", "m"}
    assert "2 leaves" in page.note.text()
    shown = [page.table.item(row, 1).text() for row in range(page.table.rowCount())]
    assert shown == ["plain", "profile", "by leaf"] * 3


def test_a_bootstrap_of_one_leaf_is_refused_in_words(lab, qtbot) -> None:
    fit(lab, qtbot)
    turn_to(lab, qtbot, CERTAINTY)
    page = lab.pages.certainty
    qtbot.waitUntil(page.bootstrap_button.isEnabled)
    qtbot.mouseClick(page.bootstrap_button, LEFT)
    qtbot.waitUntil(lambda: "at least two leaves" in page.note.text(), timeout=30_000)
    assert page.bootstrap_button.isEnabled()


def test_a_bootstrap_can_be_cancelled(lab, opened, qtbot) -> None:
    pool(lab, opened, qtbot)
    fit(lab, qtbot)
    turn_to(lab, qtbot, CERTAINTY)
    page = lab.pages.certainty
    qtbot.waitUntil(page.bootstrap_button.isEnabled)
    page.trials.setValue(20_000)
    qtbot.mouseClick(page.bootstrap_button, LEFT)
    qtbot.waitUntil(page.cancel_button.isEnabled)
    qtbot.mouseClick(page.cancel_button, LEFT)
    assert page.bootstrap_button.isEnabled()
    qtbot.waitUntil(lambda: not opened.controller.bridge.jobs, timeout=30_000)
    assert "bootstrap" not in page.found


def test_the_table_is_that_of_the_service_and_can_be_kept(lab, opened, qtbot, tmp_path) -> None:
    turn_to(lab, qtbot, TABLE)
    page = lab.pages.table
    page.which.setFocus()
    qtbot.keyClick(page.which, Qt.Key.Key_Down)
    qtbot.mouseClick(page.make_button, LEFT)
    qtbot.waitUntil(lambda: page.found is not None, timeout=60_000)
    project, key = opened.controller.project, opened.controller.current
    samples = each_leaf(project, key)
    expected = tabulate_fits(project, key, samples, ["near"], "lambert-beckmann")
    assert page.found.report == expected.report
    assert page.table.rowCount() == 2
    assert not opened.state.fits
    qtbot.mouseClick(page.copy_button, LEFT)
    assert QGuiApplication.clipboard().text() == fits_as_text(expected.report, "tsv")
    lab.dialogs.folder = tmp_path
    qtbot.mouseClick(page.csv_button, LEFT)
    path = tmp_path / "out.csv"
    save_as(lab, qtbot, path)
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["sample"] for row in rows} == {"Leaf 1", "Leaf 2"}
    steps = len(opened.controller.project.history.done)
    qtbot.mouseClick(page.keep_button, LEFT)
    assert len(opened.state.fits) == 2
    assert len(opened.controller.project.history.done) == steps + 1


def test_a_table_says_when_leaves_have_changed(lab, opened, qtbot) -> None:
    turn_to(lab, qtbot, TABLE)
    page = lab.pages.table
    qtbot.mouseClick(page.make_button, LEFT)
    qtbot.waitUntil(lambda: page.found is not None, timeout=60_000)
    assert "⚠" not in page.words.text()
    opened.work.remove([next(iter(opened.state.leaves))])
    qtbot.waitUntil(lambda: "make it anew" in page.words.text())


@pytest.mark.parametrize(
    ("number", "suffix", "start"),
    [(0, ".png", b"\x89PNG"), (1, ".svg", b"<?xml"), (2, ".pdf", b"%PDF")],
)
def test_the_figure_is_written(lab, qtbot, tmp_path, number, suffix, start) -> None:
    lab.dialogs.folder = tmp_path
    lab.export.figure_actions[number].trigger()
    path = tmp_path / f"figure{suffix}"
    save_as(lab, qtbot, path)
    assert path.read_bytes().startswith(start)


def test_fits_and_figure_are_copied_and_written(lab, opened, qtbot, tmp_path) -> None:
    assert not lab.export.csv.isEnabled()
    fit(lab, qtbot)
    qtbot.waitUntil(lab.export.csv.isEnabled)
    lab.export.copy_fits.trigger()
    assert "lambert-beckmann" in QGuiApplication.clipboard().text()
    lab.dialogs.folder = tmp_path
    lab.export.tex.trigger()
    path = tmp_path / "fits.tex"
    save_as(lab, qtbot, path)
    assert "\\toprule" in path.read_text(encoding="utf-8")
    lab.export.copy_figure.trigger()
    clipboard = QGuiApplication.clipboard()
    qtbot.waitUntil(lambda: clipboard.mimeData().hasImage(), timeout=60_000)
    assert not clipboard.image().isNull()
    assert "image/svg+xml" in clipboard.mimeData().formats()


def test_the_figure_has_the_curve_of_the_sliders(lab, qtbot) -> None:
    slider = lab.editor.rows.rows["f"].slider
    qtbot.keyClick(slider, Qt.Key.Key_PageUp)
    (panel,) = lab.export._order.panels
    assert dict(panel.series[0].curve.values) == lab.editor.values

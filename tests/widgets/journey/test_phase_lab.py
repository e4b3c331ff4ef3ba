"""Two leaves in the lab: compare models, fit two channels, brush, export a table; all by hand."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest

from app.core.fitting import FitResult
from app.services.lab.fit_table import each_leaf, tabulate_fits
from app.services.lab.table_files import fits_as_text

pytestmark = [pytest.mark.window, pytest.mark.timeout(600)]
LEFT = Qt.MouseButton.LeftButton
MODELS, TABLE = 1, 3


def choose_leaves(user: Any, names: tuple[str, str]) -> None:
    """Click two rows in the table of leaves, holding Ctrl."""
    table = user.window.docks.panels["leaves"].table
    modifier = Qt.KeyboardModifier.NoModifier
    for row in range(table.model().rowCount()):
        index = table.model().index(row, 0)
        if index.data() in names:
            table.scrollTo(index)
            place = table.visualRect(index).center()
            QTest.mouseClick(table.viewport(), LEFT, modifier, place)
            modifier = Qt.KeyboardModifier.ControlModifier
    user.rest()


def choose_points(user: Any, lab: Any, title: str) -> None:
    box = lab.choice.points_box
    box.setFocus()
    for _ in range(box.currentIndex()):
        QTest.keyClick(box, Qt.Key.Key_Up)
    for _ in range(box.findText(title)):
        QTest.keyClick(box, Qt.Key.Key_Down)
    user.rest()


def turn_to(user: Any, lab: Any, page: int) -> None:
    user.click(lab.pages.tabs, lab.pages.tabs.tabRect(page).center())
    user.rest()


def brush(user: Any, lab: Any, low: float, high: float) -> None:
    """Drag over a range of angles."""
    plot = lab.plots.plot
    middle = float(np.mean(plot.box.viewRange()[1]))
    spots = [
        plot.mapFromScene(plot.box.mapViewToScene(QPointF(float(angle), middle)))
        for angle in np.linspace(low, high, 12)
    ]
    QTest.mousePress(plot.viewport(), LEFT, pos=spots[0])
    for spot in spots[1:]:
        QTest.mouseMove(plot.viewport(), spot)
        QTest.qWait(30)
    QTest.mouseRelease(plot.viewport(), LEFT, pos=spots[-1])
    user.rest()


def test_two_leaves_in_the_lab(user: Any, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setenv("LEAFSCOPE_MODELS", str(tmp_path / "models"))
    window, controller = user.window, user.window.controller
    user.click(window.welcome.demo)
    user.wait_for(lambda: controller.current is not None)
    user.press("Find leaves", user.panel("leaves"))
    user.wait_for(lambda: len(controller.project.state.leaves) > 15)
    user.rest()
    choose_leaves(user, ("Leaf 2", "Leaf 6"))
    lab = user.panel("phase_lab")
    choose_points(user, lab, "Selected leaves")
    user.wait_for(lambda: lab.editor.points.count > 6000)

    turn_to(user, lab, MODELS)
    page = lab.pages.models
    user.wait_for(lambda: page.table_shown is not None)
    user.look("lab-models")
    row = next(n for n, r in enumerate(page.table_shown.rows) if r.model == "incidence-b")
    user.click(page.table.viewport(), page.table.visualItemRect(page.table.item(row, 0)).center())
    user.wait_for(lambda: lab.choice.model.name == "incidence-b")

    choose_points(user, lab, "Each selected leaf")
    channels = lab.choice.channel_list
    rect = channels.visualItemRect(channels.item(1))
    user.click(channels.viewport(), QPoint(rect.left() + rect.height() // 2, rect.center().y()))
    user.wait_for(lambda: len(lab.choice.channels) == 2)
    steps = len(controller.project.history.done)
    user.press("Fit", lab)
    user.wait_for(lambda: len(controller.project.state.fits) == 4)
    user.rest()
    assert len(controller.project.history.done) == steps + 1
    turn_to(user, lab, 0)
    user.look("lab-fits")

    user.click(lab.plots.tools.angles)
    brush(user, lab, 5.0, 20.0)
    state = controller.scan
    assert len(state.selection) > 50
    angle = controller.project.known_field(controller.current, "incidence").values
    brushed = angle[state.selection.indices]
    assert (brushed > 4.0).all()
    assert (brushed < 21.0).all()
    first = controller.project.state.leaves[lab.target.leaves[0]]
    assert set(state.selection.indices) <= set(first.members.indices)
    user.look("lab-brush")
    user.keys("Ctrl+Z")
    user.rest()
    assert len(controller.scan.selection) == 0

    user.click(lab.plots.tools.map)
    user.wait_for(lambda: controller.view.colour == "residual")
    user.look("lab-residuals")

    turn_to(user, lab, TABLE)
    user.press("Make table", lab)
    user.wait_for(lambda: lab.pages.table.found is not None)
    path = tmp_path / "fits.csv"
    window.desk.files.dialogs.folder = tmp_path
    user.press("CSV…", lab)
    user.name_file(path)
    user.wait_for(path.is_file)
    user.look("lab-table")
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["sample"] for row in rows} == {"Leaf 2", "Leaf 6"}
    project, key = controller.project, controller.current
    keys = tuple(target.leaves[0] for target in lab.targets)
    samples = sorted(each_leaf(project, key, keys), key=lambda s: keys.index(s.leaves[0]))
    table = tabulate_fits(project, key, samples, lab.choice.channels, "incidence-b")
    assert path.read_text(encoding="utf-8").splitlines() == (
        fits_as_text(table.report, "csv").splitlines()
    )
    for record in project.state.fits.values():
        values = FitResult.from_dict(record.result).values
        (written,) = (
            row
            for row in rows
            if row["sample"] == project.state.leaves[record.leaves[0]].name
            and row["channel"] == record.channel
            and row["parameter"] == "b"
        )
        assert float(written["value"]) == pytest.approx(values["b"])

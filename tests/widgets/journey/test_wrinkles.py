"""Wrinkled leaves are found among flat ones by their intensity, looked at and written down."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from app.services.beams import beam_of_instrument
from app.services.leaves import leaves_from_labels
from app.services.opening import set_parameters

pytestmark = [pytest.mark.window, pytest.mark.timeout(600)]
LEFT = Qt.MouseButton.LeftButton
FLAT_LEAF, WRINKLED_LEAF = 2, 23


def cell_of(table: Any, name: str) -> Any:
    model = table.model()
    return next(
        model.index(row, 0) for row in range(model.rowCount()) if model.index(row, 0).data() == name
    )


def test_wrinkles(user: Any, tmp_path: Path) -> None:
    window, controller = user.window, user.window.controller
    panel = user.panel("wrinkles")
    assert "Open a scan" in panel.notice.text
    user.click(window.welcome.demo)
    user.wait_for(lambda: controller.current is not None)
    user.rest()
    assert "There is no leaf yet" in panel.notice.text
    key = controller.current
    leaves_from_labels(controller.project, key, "truth_leaf")
    set_parameters(controller.project, key, beam=beam_of_instrument("two_colour"))
    user.rest()

    # With nothing chosen one curve goes through all leaves, and nearly every leaf has an answer.
    user.press("Measure wrinkles", panel)
    user.wait_for(lambda: panel.measuring.find(key) is not None)
    user.rest()
    judged = [leaf.judged is not None for leaf in panel.measuring.find(key).found.leaves]
    assert np.mean(judged) > 0.6
    assert "only differences Δω inside the leaf are claimed" in panel.claim.text()

    # Leaves that are flat have no curve of their own; each says so, and the others do not stop.
    user.choose(panel.form.source.box, "Each leaf")
    user.press("Measure wrinkles", panel)
    user.wait_for(lambda: panel.busy.words.text() == "" and not panel.measuring.busy)
    user.rest()
    flat = cell_of(panel.table, f"truth_leaf {FLAT_LEAF}")
    panel.table.scrollTo(flat)
    user.click(panel.table.viewport(), panel.table.visualRect(flat).center())
    user.rest()
    assert "no curve of its own" in panel.leaf_notice.text

    # A species' curve at 1545 nm, level with each leaf: only differences are claimed.
    user.scroll_to(panel, panel.form.channel)
    user.choose(panel.form.channel, "reflectance_1545")
    user.choose(panel.form.source.box, "Species")
    user.choose(panel.form.source.species, "maple")
    user.choose(panel.form.offset.box, "Fitted")
    assert "measure again" in panel.busy.words.text()
    user.press("Measure wrinkles", panel)
    user.wait_for(lambda: panel.busy.words.text() == "" and not panel.measuring.busy)
    user.rest()
    assert "only differences Δω inside the leaf are claimed" in panel.claim.text()
    rows = {row["name"]: row for row in panel.measuring.find(key).rows.values()}
    index = {name: row.get("wrinkle_index_deg") for name, row in rows.items()}
    assert index[f"truth_leaf {WRINKLED_LEAF}"] > 5 * index[f"truth_leaf {FLAT_LEAF}"]

    # Sorted by the index the wrinkled leaf is near the top; a click shows its map.
    header = panel.table.horizontalHeader()
    column = next(
        c for c in range(panel.table.model().columnCount())
        if panel.table.model().headerData(c, Qt.Orientation.Horizontal) == "Index (°)"
    )  # fmt: skip
    user.scroll_to(panel, panel.table)
    spot = QPoint(
        header.sectionViewportPosition(column) + header.sectionSize(column) // 2,
        header.height() // 2,
    )
    for _ in range(2):
        QTest.mouseClick(header.viewport(), LEFT, pos=spot)
        user.rest()
    QTest.qWait(100)
    first = float(panel.table.model().index(0, column).data().split(" ")[0])
    assert first == pytest.approx(max(v for v in index.values() if v is not None), abs=0.051)
    wrinkled = cell_of(panel.table, f"truth_leaf {WRINKLED_LEAF}")
    panel.table.scrollTo(wrinkled)
    user.click(panel.table.viewport(), panel.table.visualRect(wrinkled).center())
    user.rest()
    assert controller.project.state.leaves[controller.view.leaf].name == wrinkled.data()
    assert f"truth_leaf {WRINKLED_LEAF}" in panel.page.title.text()
    user.scroll_to(panel, panel.page)
    user.look("wrinkles-map")

    # Distribution and numbers.
    for tab, name in ((1, "wrinkles-distribution"), (2, "wrinkles-numbers"), (0, "")):
        user.scroll_to(panel, panel.page.tabs)
        user.click(panel.page.tabs, panel.page.tabs.tabRect(tab).center())
        user.rest()
        if name:
            user.look(name)

    # The cloud takes the colours of the map, and of the other map.
    user.scroll_to(panel, panel.colour_button)
    user.click(panel.colour_button)
    user.rest()
    assert controller.view.colour == "wrinkle_delta"
    views = panel.page.views
    user.scroll_to(panel, views.tabs)
    user.click(views.tabs, views.tabs.tabRect(1).center())
    user.rest()
    assert controller.view.colour == "wrinkle_significance"
    user.look("wrinkles-cloud")

    # The table and a figure of the leaf are written where the user says.
    panel.export.tables[0].trigger()
    user.name_file(tmp_path / "w.csv")
    with (tmp_path / "w.csv").open(newline="") as file:
        written = {row["name"]: row for row in csv.DictReader(file)}
    assert written.keys() == rows.keys()
    number = float(written[wrinkled.data()]["wrinkle_index_deg"])
    assert number == rows[wrinkled.data()]["wrinkle_index_deg"]
    panel.export.figures[0].trigger()
    user.name_file(tmp_path / "leaf.png")
    user.wait_for((tmp_path / "leaf.png").exists)

    # Undo of the leaves takes numbers and colours with them.
    while controller.project.state.leaves:
        user.keys("Ctrl+Z")
        user.rest()
    assert "There is no leaf yet" in panel.notice.text
    assert controller.project.known_field(key, "wrinkle_delta") is None
    assert not np.any([part.isVisible() for part in (panel.table, panel.claim_box, panel.page)])

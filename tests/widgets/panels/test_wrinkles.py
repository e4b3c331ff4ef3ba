"""The wrinkles panel shows by how much a bent leaf leaves its plane, and what may be claimed."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication

from app.core.wrinkles import SIGN_OF_DELTA
from app.core.wrinkling.claim import OWN_SENTENCE, SENTENCES
from app.model.points import PointSet
from app.model.scan import Channel
from app.model.selection import Explicit
from app.model.wrinkle_fields import DELTA, SIGNIFICANCE
from app.services.wrinkles.request import CurveInUse, ScanCurve, SpeciesSource, TableCurve
from widgets.common.numbers import show_count
from widgets.common.wrinkles.offset_form import FITTED, NONE, TYPED
from widgets.common.wrinkles.source_form import IN_USE, OWN, SCAN, SPECIES, TABLE
from widgets.fields_at_hand import NOT_MEASURED, why_not
from widgets.panels.wrinkles import WrinklesPanel

LEFT = Qt.MouseButton.LeftButton


def settle(panel, qtbot) -> None:
    bridge = panel.controller.bridge
    qtbot.waitUntil(lambda: not bridge.jobs and not panel._later.isActive(), timeout=120_000)


def measure(panel, qtbot):
    """Press the button; give what is known then."""
    qtbot.mouseClick(panel.busy.button, LEFT)
    settle(panel, qtbot)
    return panel.measuring.find(panel.controller.current)


def choose(box, data) -> None:
    """Choose an entry as the user does."""
    row = box.findData(data)
    box.setCurrentIndex(row)
    box.activated.emit(row)


@pytest.fixture
def panel(opened, qtbot):
    panel = opened.show(WrinklesPanel)
    settle(panel, qtbot)
    return panel


@pytest.fixture
def table(tmp_path):
    """A goniometer table of the leaf that the scan is made of."""
    path = tmp_path / "gonio.csv"
    omega = np.deg2rad(np.arange(0, 81, 5))
    light = 0.6 * (0.7 * np.cos(omega) + 0.3 * np.exp(-(np.tan(omega) ** 2) / 0.35**2)
                   / np.cos(omega) ** 5)  # fmt: skip
    lines = [f"{a},{v}" for a, v in zip(np.rad2deg(omega), light, strict=True)]
    path.write_text("\n".join(["angle,value", *lines]))
    return path


def test_a_leaf_measured_by_itself_claims_differences_only(panel, opened, qtbot) -> None:
    choose(panel.form.source.box, OWN)
    assert not panel.form.offset.isEnabled(), "a leaf has no offset to its own curve"
    assert panel.form.offset.box.currentData() == NONE
    assert not panel.claim_box.isVisible()
    measured = measure(panel, qtbot)
    assert set(measured.leaves) == {"leaf-00001", "leaf-00002"}
    assert OWN_SENTENCE in panel.claim.text()
    found = measured.leaves[panel.leaf.key]
    truth = opened.controller.scan.scan.attributes["true_deg"][found.points]
    plane = np.rad2deg(found.judged.plane.incidence)
    valid = found.judged.angles.valid
    assert np.rad2deg(found.judged.delta[valid]) == pytest.approx(truth[valid] - plane, abs=6.0)
    facts = panel.page.facts.texts
    assert facts["ω of the leaf's plane"].startswith(f"{plane:.1f}°")
    assert "shift" in facts["ω of the mean intensity"]
    assert facts["Curve"].startswith("fit of Leaf")
    assert "95 %" in facts["Wrinkle index"]


def test_with_nothing_known_all_leaves_give_the_curve(panel, qtbot) -> None:
    assert panel.form.source.kind == SCAN
    assert not panel.form.offset.isEnabled()
    assert panel.form.offset.box.currentData() == FITTED, "each leaf is levelled, and it is shown"
    assert panel.form.request().source == ScanCurve()
    measured = measure(panel, qtbot)
    assert "leaves of this scan" in measured.rows[panel.leaf.key]["curve"]
    assert SENTENCES["levelled"] in panel.claim.text()
    choose(panel.form.source.box, SPECIES)
    assert panel.form.offset.isEnabled()
    assert panel.form.request().offset is None, "what was settled was not the user's choice"


def test_what_is_not_valid_is_grey_and_counted(panel, qtbot) -> None:
    choose(panel.form.source.box, OWN)
    panel.form.steepest.setValue(30.0)
    measured = measure(panel, qtbot)
    found = measured.leaves[panel.leaf.key]
    beyond = int((~found.judged.angles.valid).sum())
    assert beyond > 100
    said = panel.page.views.reasons.text()
    total = show_count(len(found.points))
    assert said.startswith(f"Grey: {show_count(beyond)} of {total} points")
    assert "steeper than the limit" in said


def test_the_map_shows_the_sign_that_the_legend_states(panel, qtbot) -> None:
    measured = measure(panel, qtbot)
    views = panel.page.views
    assert views.legend.text() == SIGN_OF_DELTA
    # Leaf 2 bulges: steep at one side, face-on at the other.
    image = views.scanner.image.image.astype(int)
    filled = np.flatnonzero((image[..., 3] > 0).any(axis=0))
    left, right = image[:, filled[:4]], image[:, filled[-4:]]
    found = measured.leaves[panel.leaf.key]
    side = found.measured.xyz[:, 1]
    delta = np.where(found.judged.angles.valid, found.judged.delta, np.nan)
    outer = np.nanmean(delta[side > np.quantile(side, 0.9)])
    inner = np.nanmean(delta[side < np.quantile(side, 0.1)])
    # y grows to the left of a scanner that looks along x.
    steep, facing = (left, right) if outer > inner else (right, left)
    shown = steep[(steep[..., 3] > 0) & (np.ptp(steep[..., :3], axis=-1) > 40)]
    assert (shown[:, 2] > shown[:, 0]).mean() > 0.9, "towards edge-on is blue or purple"
    shown = facing[(facing[..., 3] > 0) & (np.ptp(facing[..., :3], axis=-1) > 40)]
    assert (shown[:, 0] > shown[:, 2]).mean() > 0.9, "towards the beam is red or yellow"


def test_the_significance_is_another_map(panel, qtbot) -> None:
    measure(panel, qtbot)
    views = panel.page.views
    before = views.scanner.image.image.copy()
    views.tabs.setCurrentIndex(1)
    assert views.shown == "significance"
    assert 3.0 <= views.limit <= 12.0
    assert " σ" in views.strip.accessibleName()
    assert (views.scanner.image.image != before).any()


def test_the_table_and_the_leaf_are_linked_both_ways(panel, opened, qtbot) -> None:
    measure(panel, qtbot)
    assert panel.leaf.key == "leaf-00002"
    rows = panel.table.selectionModel().selectedRows()
    assert [index.data() for index in rows] == ["Leaf 2"]
    model = panel.table.model()
    first = next(model.index(r, 0) for r in range(2) if model.index(r, 0).data() == "Leaf 1")
    panel.table.scrollTo(first)
    qtbot.mouseClick(panel.table.viewport(), LEFT, pos=panel.table.visualRect(first).center())
    settle(panel, qtbot)
    assert opened.controller.view.leaf == "leaf-00001"
    assert "Leaf 1" in panel.page.title.text()
    opened.controller.look(leaf="leaf-00002")
    settle(panel, qtbot)
    rows = panel.table.selectionModel().selectedRows()
    assert [index.data() for index in rows] == ["Leaf 2"]
    assert "Leaf 2" in panel.page.title.text()


def test_the_table_can_be_sorted_by_its_numbers(panel, qtbot) -> None:
    measured = measure(panel, qtbot)
    model = panel.table.model()
    titles = [model.headerData(c, Qt.Orientation.Horizontal) for c in range(model.columnCount())]
    column = titles.index("Index (°)")
    for order in (Qt.SortOrder.AscendingOrder, Qt.SortOrder.DescendingOrder):
        panel.table.sortByColumn(column, order)
        names = [model.index(r, 0).data() for r in range(2)]
        value = {row["name"]: row["wrinkle_index_deg"] for row in measured.rows.values()}
        assert names == sorted(value, key=value.get, reverse=order.value == 1)
        text = model.index(0, column).data()
        assert text.startswith(f"{value[names[0]]:.1f} (")


def test_a_goniometer_table_claims_the_angle_itself(panel, table, qtbot) -> None:
    choose(panel.form.source.box, TABLE)
    settle(panel, qtbot)
    assert not panel.busy.button.isEnabled()
    assert "Choose a goniometer table" in panel.busy.words.text()
    panel.form.source.take_file(table)
    settle(panel, qtbot)
    assert panel.form.request().source == TableCurve(table)
    measured = measure(panel, qtbot)
    assert SENTENCES["known"] in panel.claim.text()
    found = measured.leaves[panel.leaf.key]
    truth = panel.controller.scan.scan.attributes["true_deg"][found.points]
    valid = found.judged.angles.valid
    apart = np.abs(np.rad2deg(found.judged.angles.omega[valid]) - truth[valid])
    assert np.mean(apart <= 5.0) > 0.9


def test_a_bad_table_is_refused_in_words(panel, tmp_path, qtbot) -> None:
    bad = tmp_path / "bad.csv"
    bad.write_text("angle,value\n120,0.3\n")
    choose(panel.form.source.box, TABLE)
    panel.form.source.take_file(bad)
    settle(panel, qtbot)
    assert measure(panel, qtbot) is None
    assert "within 0° to 90°" in panel.busy.words.text()
    assert panel.busy.button.isEnabled()
    assert not panel.page.isVisible()


def test_a_species_is_offered_near_its_wavelength(panel, qtbot) -> None:
    form = panel.form
    choose(form.source.box, SPECIES)
    settle(panel, qtbot)
    model = form.source.species.model()
    assert not any(model.item(r).isEnabled() for r in range(model.rowCount())), "none at 1063 nm"
    choose(form.channel, "far")
    settle(panel, qtbot)
    named = {model.item(r).text() for r in range(model.rowCount()) if model.item(r).isEnabled()}
    assert {"lime", "birch", "maple"} <= named
    choose(form.source.species, "maple")
    choose(form.offset.box, FITTED)
    assert form.request().source == SpeciesSource("maple")
    assert form.request().offset == "fit"
    measured = measure(panel, qtbot)
    assert measured.found.channel.name == "far"
    assert SENTENCES["levelled"] in panel.claim.text()
    choose(form.offset.box, "none")
    form.source.reflectance.setValue(0.3)
    form.source.scatter.setValue(12.0)
    settle(panel, qtbot)
    assert form.request().source == SpeciesSource("maple", 0.3, 0.12)
    measure(panel, qtbot)
    assert "brighter or darker by 12 %" in panel.claim.text()


def test_the_curve_of_the_lab_is_taken_where_there_is_one(panel, opened, qtbot) -> None:
    scan = opened.controller.current
    assert (
        not panel.form.source.box.model().item(panel.form.source.box.findData(IN_USE)).isEnabled()
    )
    with qtbot.waitSignal(opened.work.fitted, timeout=60_000) as made:
        opened.work.fit(["leaf-00001", "leaf-00002"], "lambert-beckmann", "far")
    opened.work.use_fit(made.args[0])
    settle(panel, qtbot)
    source = panel.form.source
    assert source.kind == IN_USE
    assert not panel.form.channel.isEnabled()
    assert "far" in source.told.text()
    assert panel.form.request().source == CurveInUse(False, 0.08)
    assert measure(panel, qtbot).found.channel.name == "far"
    assert "brighter or darker by 8 %" in panel.claim.text()
    qtbot.mouseClick(source.of_leaf, LEFT, pos=source.of_leaf.rect().center() * 0)
    source.of_leaf.setChecked(True)
    settle(panel, qtbot)
    assert "changed since" in panel.busy.words.text()
    measure(panel, qtbot)
    assert SENTENCES["known"] in panel.claim.text()
    opened.controller.undo()
    settle(panel, qtbot)
    assert opened.state.scan(scan).parameters.curve is None
    assert source.kind == SCAN
    assert panel.form.request().source == ScanCurve()


def test_an_offset_is_a_factor_or_dn_as_the_channel_demands(desk, make_scan, qtbot) -> None:
    scan = make_scan()
    raw = replace(
        scan,
        attributes={**scan.attributes, "dn": 1000.0 + 400.0 * np.log10(scan.attributes["near"])},
        channels=(*scan.channels, Channel("dn", "dn", 785.0, "DN")),
    )
    desk.make_halves(desk.open(raw))
    panel = desk.show(WrinklesPanel)
    settle(panel, qtbot)
    form = panel.form
    choose(form.source.box, SPECIES)
    choose(form.offset.box, TYPED)
    assert form.offset.factor.isVisible()
    assert not form.offset.added.isVisible()
    form.offset.factor.setValue(1.25)
    assert form.request().offset == 1.25
    assert not form.instrument.isVisible()
    choose(form.channel, "dn")
    settle(panel, qtbot)
    assert form.instrument.isVisible()
    typed = form.offset.box.model().item(form.offset.box.findData(TYPED))
    assert not typed.isEnabled(), "nobody knows what these DN are"
    assert form.request().offset is None
    choose(form.instrument, "ls880")
    settle(panel, qtbot)
    assert typed.isEnabled()
    choose(form.offset.box, TYPED)
    assert form.offset.added.isVisible()
    form.offset.added.setValue(50.0)
    assert form.request().offset == 50.0
    assert form.request().instrument == "ls880"


def test_a_change_makes_it_stale_and_measuring_again_does_not(panel, opened, qtbot) -> None:
    measure(panel, qtbot)
    assert panel.busy.words.text() == ""
    panel.form.largest_sigma.setValue(5.0)
    settle(panel, qtbot)
    assert "measure again" in panel.busy.words.text()
    measure(panel, qtbot)
    assert panel.busy.words.text() == ""
    points = PointSet(opened.state.leaves["leaf-00002"].members.indices[:50])
    opened.work.make_leaf(opened.controller.current, points, Explicit(points))
    settle(panel, qtbot)
    assert "measure again" in panel.busy.words.text()
    assert "newer than the measurement" in panel.leaf_notice.text
    assert panel.table.model().rowCount() == 3


def test_cancel_leaves_nothing_half_done(panel, qtbot) -> None:
    panel.measure()
    qtbot.waitUntil(lambda: panel.busy.stop.isVisible())
    assert not panel.busy.button.isEnabled()
    qtbot.mouseClick(panel.busy.stop, LEFT)
    settle(panel, qtbot)
    assert panel.busy.button.isEnabled()
    assert not panel.busy.stop.isVisible()
    assert panel.measuring.find(panel.controller.current) is None
    assert measure(panel, qtbot) is not None


def test_a_leaf_of_which_nothing_can_be_said_says_why(panel, opened, qtbot) -> None:
    points = PointSet(opened.state.leaves["leaf-00001"].members.indices[:2])
    opened.work.make_leaf(opened.controller.current, points, Explicit(points))
    settle(panel, qtbot)
    measured = measure(panel, qtbot)
    assert measured.leaves["leaf-00003"].judged is None
    assert panel.leaf_notice.text == f"Leaf 3: {measured.leaves['leaf-00003'].refusal}"
    assert not panel.page.isVisible()
    assert measured.leaves["leaf-00001"].judged is not None


def test_the_cloud_shows_what_the_map_shows(panel, opened, qtbot) -> None:
    project, scan = opened.controller.project, opened.controller.current
    assert "press Measure" in why_not(project, scan, DELTA)
    measured = measure(panel, qtbot)
    assert why_not(project, scan, DELTA) == ""
    qtbot.mouseClick(panel.colour_button, LEFT)
    assert opened.controller.view.colour == DELTA
    values = project.known_field(scan, DELTA).values
    found = measured.leaves["leaf-00001"]
    valid = found.judged.angles.valid
    np.testing.assert_allclose(values[found.points[valid]], np.rad2deg(found.judged.delta[valid]))
    assert np.isnan(values[found.points[~valid]]).all()
    assert np.isnan(np.delete(values, np.concatenate([f.points for f in measured.leaves.values()]))
                    ).all()  # fmt: skip
    panel.page.views.tabs.setCurrentIndex(1)
    assert opened.controller.view.colour == SIGNIFICANCE
    settle(panel, qtbot)
    qtbot.mouseClick(panel.colour_button, LEFT)
    assert opened.controller.view.colour == "near"
    opened.work.remove(["leaf-00001"])
    assert project.known_field(scan, DELTA) is None, "it rests on the leaves"
    settle(panel, qtbot)


def test_tables_and_figures_are_written(panel, tmp_path, qtbot) -> None:
    assert not panel.export.tables[0].isEnabled()
    measured = measure(panel, qtbot)
    asked = []
    panel.export.file_asked.disconnect(panel._ask_file)
    panel.export.file_asked.connect(lambda word, suffix: asked.append((word, suffix)))
    for action, name in zip(
        (*panel.export.tables, *panel.export.figures, panel.export.six),
        ("t.csv", "t.json", "f.png", "f.svg", "f.pdf", "six.pdf"),
        strict=True,
    ):
        action.trigger()
        panel.export.write(tmp_path / name)
        settle(panel, qtbot)
        assert (tmp_path / name).stat().st_size > 200
    assert asked[0] == ("wrinkles", ".csv")
    assert asked[-1] == ("leaves", ".pdf")
    with (tmp_path / "t.csv").open(newline="") as file:
        rows = {row["leaf"]: row for row in csv.DictReader(file)}
    for row in json.loads((tmp_path / "t.json").read_text())["leaves"]:
        assert row == {"scan": panel.controller.current} | measured.rows[row["leaf"]]
        assert float(rows[row["leaf"]]["wrinkle_index_deg"]) == row["wrinkle_index_deg"]
    panel.export.copy.trigger()
    lines = QGuiApplication.clipboard().text().splitlines()
    assert len(lines) == 3
    assert lines[0].split("\t")[:2] == ["scan", "leaf"]


def test_pages_show_map_distribution_and_numbers(panel, qtbot) -> None:
    measured = measure(panel, qtbot)
    page = panel.page
    assert page.views.isVisible()
    page.tabs.setCurrentIndex(1)
    assert page.spread.isVisible()
    assert not page.views.isVisible()
    judged = measured.leaves[panel.leaf.key].judged
    assert judged.shape in page.shape.text()
    assert "skewness beyond" in page.rule.text()
    x, _ = page.plot.peaks.getData()
    np.testing.assert_allclose(np.sort(x), np.sort(np.rad2deg(judged.spread.modes)))
    page.tabs.setCurrentIndex(2)
    assert page.facts.isVisible()


def test_the_theme_changes_the_grey_of_the_map(panel, qtbot) -> None:
    choose(panel.form.source.box, OWN)
    panel.form.steepest.setValue(30.0)
    measure(panel, qtbot)
    before = panel.page.views.scanner.image.image.copy()
    palette = panel.palette()
    palette.setColor(palette.ColorRole.Base, Qt.GlobalColor.black)
    panel.setPalette(palette)
    assert (panel.page.views.scanner.image.image != before).any()


def test_what_is_missing_is_said(desk, qtbot, make_scan) -> None:
    panel = desk.show(WrinklesPanel)
    assert "Open a scan" in panel.notice.text
    key = desk.open(make_scan(pose=False))
    qtbot.waitUntil(lambda: "where the scanner stood" in panel.notice.text)
    with qtbot.waitSignal(panel.origin_asked) as asked:
        qtbot.mouseClick(panel.notice.button, LEFT)
    assert asked.args == [key]
    desk.documents.set_origin(key, (0.0, 0.0, 0.0))
    qtbot.waitUntil(lambda: "There is no leaf yet" in panel.notice.text)
    assert not panel.form.isVisible()
    heard: list[str] = []
    desk.controller.said.connect(heard.append)
    qtbot.mouseClick(panel.notice.button, LEFT)
    settle(panel, qtbot)
    assert any("leaves found" in text for text in heard)
    desk.make_halves(key)
    settle(panel, qtbot)
    assert panel.form.isVisible()
    assert panel.notice.text == ""


def test_a_field_that_nobody_measured_is_asked_for_in_a_sentence(panel, opened, qtbot) -> None:
    said = []
    opened.controller.said.connect(said.append)
    opened.controller.look(colour=DELTA)
    settle(panel, qtbot)
    assert said == [NOT_MEASURED]
    assert "session does not keep it" in said[0]
    measure(panel, qtbot)
    opened.controller.look(colour=SIGNIFICANCE)
    settle(panel, qtbot)
    assert said == [NOT_MEASURED], "what is known needs no word"

"""The calibration panel: panels with known reflectance become a profile, and that reflectance."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QDialogButtonBox, QFileDialog, QLineEdit, QPushButton

from app.core.radiometry.marks import WORDS
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Channel, Grid, Pose, Scan
from app.model.selection import Explicit
from app.model.view_state import ViewState
from app.services.beams import beam_of_instrument
from app.services.profiles import find_profile, read_profile
from widgets.common.calibration.panel_list import DN, RHO
from widgets.common.calibration.panel_list import SIGMA as PANEL_SIGMA
from widgets.common.step_titles import title_steps
from widgets.fields_at_hand import group_of, list_fields, why_not
from widgets.panels.calibration import BUDGET, MAKE, POWER, CalibrationPanel

A0, A1, NOISE, SATURATED = 1200.0, 2200.0, 20.0, 2033.0
RHOS = (0.99, 0.5, 0.25, 0.12)
SIDE, DISTANCE, PITCH = 36, 4.0, 0.004
NAME = "reflectance_1550"
LEFT = Qt.MouseButton.LeftButton


def build_board(power: float = 1.0, nm: float | None = 1550.0, tool: str = "FARO X330") -> Scan:
    """Four panels side by side on a board at 4 m, through a logarithmic amplifier."""
    row, column = (a.ravel() for a in np.meshgrid(range(SIDE), range(4 * SIDE), indexing="ij"))
    y, z = (column - 2 * SIDE) * PITCH, (SIDE / 2 - row) * PITCH
    chance = np.random.default_rng(5)
    light = power * np.array(RHOS)[column // SIDE]
    dn = A1 + A0 * np.log10(light) + chance.normal(0.0, NOISE, len(row))
    return Scan(
        "board.ply",
        np.column_stack((np.full(len(row), DISTANCE), y, z)),
        {"intensity": np.minimum(dn, SATURATED), "place": (column // SIDE).astype(float)},
        (Channel("intensity", "intensity", nm, "DN"),),
        Pose((0.0, 0.0, 0.0), known_by="given"),
        Grid(SIDE, 4 * SIDE, row.astype(np.int32), column.astype(np.int32)),
        metadata={"instrument": f"simulated: {tool}"} if tool else {},
    )


def draw_panels(desk, key: str, names=("99 %", "50 %", "25 %", "12 %")) -> list[str]:
    place = desk.state.scan(key).scan.attributes["place"]
    for number, name in enumerate(names):
        points = PointSet.from_mask(place == number)
        desk.work.make_leaf(key, points, Explicit(points))
        desk.work.rename(desk.controller.view.leaf, name)
    return list(desk.state.leaves)


@pytest.fixture
def board(desk):
    draw_panels(desk, desk.open(build_board()))
    return desk


@pytest.fixture
def panel(board, qtbot) -> CalibrationPanel:
    panel = board.show(CalibrationPanel)
    qtbot.waitUntil(lambda: panel.making.panels.rowCount() == 4)
    return panel


def click(widget, qtbot) -> None:
    assert widget.isVisible()
    assert widget.isEnabled()
    qtbot.mouseClick(widget, LEFT)


def press(panel, text: str, qtbot) -> None:
    buttons = panel.findChildren(QPushButton)
    click(next(b for b in buttons if b.isVisible() and b.text().replace("&", "") == text), qtbot)


def type_cell(table, row: int, column: int, text: str, qtbot) -> None:
    """Type into a cell as a user does: click, write, Enter."""
    place = table.visualItemRect(table.item(row, column)).center()
    qtbot.mouseClick(table.viewport(), LEFT, pos=place)
    table.editItem(table.item(row, column))
    editor = table.findChild(QLineEdit)
    editor.selectAll()
    qtbot.keyClick(editor, Qt.Key.Key_Delete)
    qtbot.keyClicks(editor, text)
    qtbot.keyClick(editor, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: table.findChild(QLineEdit) is None)


def choose(combo, data: str) -> None:
    combo.setCurrentIndex(combo.findData(data))
    combo.activated.emit(combo.currentIndex())


def calibrate(panel, qtbot):
    before = panel.making.fit.report
    press(panel, "Calibrate", qtbot)
    qtbot.waitUntil(lambda: panel.making.fit.report not in (None, before), timeout=30_000)
    return panel.making.fit.report


def open_tab(panel, tab: int, qtbot) -> None:
    qtbot.mouseClick(panel.tabs, LEFT, pos=panel.tabs.tabRect(tab).center())
    qtbot.waitUntil(panel._pages[tab].isVisible)


def use_own(panel, desk, qtbot) -> None:
    calibrate(panel, qtbot)
    press(panel, "Use this profile", qtbot)
    qtbot.waitUntil(lambda: desk.controller.scan.parameters.profile is not None)


def name_file(panel, path: Path, qtbot) -> None:
    """Type a name into the file dialog that is open, and agree."""
    (dialog,) = [d for d in panel.findChildren(QFileDialog) if d.isVisible()]
    dialog.setDirectory(str(path.parent))
    line = dialog.findChild(QLineEdit)
    line.setText(path.name)
    saving = dialog.acceptMode() == QFileDialog.AcceptMode.AcceptSave
    standard = QDialogButtonBox.StandardButton
    box = dialog.findChild(QDialogButtonBox)
    qtbot.mouseClick(box.button(standard.Save if saving else standard.Open), LEFT)
    qtbot.waitUntil(lambda: not dialog.isVisible())


def last_title(desk) -> str:
    return title_steps(desk.controller.project.history.done)[-1]


def test_panels_are_listed_with_what_their_names_tell(panel, qtbot) -> None:
    table = panel.making.panels
    assert [table.item(row, RHO).text() for row in range(4)] == ["0.99", "0.5", "0.25", "0.12"]
    assert "become reflectance by a profile" in panel.notice.text
    assert panel.making.form.saturated.value() == SATURATED  # of the X330, which the scan names
    type_cell(table, 1, RHO, "51 %", qtbot)
    type_cell(table, 1, PANEL_SIGMA, "0.01", qtbot)
    type_cell(table, 2, RHO, "no number", qtbot)
    type_cell(table, 3, RHO, "", qtbot)
    entries = list(panel.making.panels.entries.values())
    assert [(e.rho, e.sigma) for e in entries] == [(0.99, 0.0), (0.51, 0.01), (0.25, 0.0)]
    assert table.item(2, RHO).text() == "0.25"


def test_a_calibration_shows_curve_numbers_and_errors(panel, board, qtbot) -> None:
    steps = len(board.controller.project.history.done)
    report = calibrate(panel, qtbot)
    (found,) = report.channels
    assert found.channel.steps[-1].a0 == pytest.approx(A0, rel=0.02)
    fit = panel.making.fit
    assert fit.parameters.item(0, 0).text() == "a0"
    low, high = (float(x) for x in fit.parameters.item(0, 2).text().split(" … "))
    assert low < A0 < high
    assert [fit.panels.item(row, 0).text() for row in range(3)] == ["50 %", "25 %", "12 %"]
    assert "left out: 1" in fit.aside.text()
    assert panel.making.panels.item(0, DN).text() == "saturated"
    assert float(panel.making.panels.item(2, DN).text()) == pytest.approx(
        A1 + A0 * np.log10(0.25), abs=4.0
    )
    for row in range(fit.what.count()):
        choose(fit.what, fit.what.itemData(row))
        assert len(fit.plot.plotItem.listDataItems()) >= 3
    assert len(board.controller.project.history.done) == steps  # nothing was changed by it


def test_another_document_finds_nothing_of_this_one(panel, board, qtbot) -> None:
    type_cell(panel.making.panels, 1, RHO, "0.51", qtbot)
    panel.show_point(board.controller.current, 3)
    calibrate(panel, qtbot)
    board.controller.adopt(Project(), ViewState())
    qtbot.waitUntil(lambda: "Open a scan" in panel.notice.text)
    draw_panels(board, board.open(build_board()), ("a", "b", "50 %", "d"))
    qtbot.waitUntil(lambda: panel.making.panels.rowCount() == 4)
    assert [e.rho for e in panel.making.panels.entries.values()] == [0.5]
    assert not panel.making.fit.isVisible()
    assert panel.budget._points() is None


def test_using_it_is_one_step_that_can_be_undone(panel, board, qtbot) -> None:
    use_own(panel, board, qtbot)
    # Which points the beam hits in part can then be told.
    assert last_title(board).startswith("Set beam")
    assert last_title(board).endswith("Use profile FARO X330, board")
    qtbot.waitUntil(panel.profile.facts.isVisible)
    assert "12 to 50 %" in panel.profile.facts.texts["1550 nm"]
    assert not panel.profile.whose.isVisible()
    press(panel, "Compute reflectance", qtbot)
    qtbot.waitUntil(lambda: panel.counts is not None, timeout=30_000)
    size = SIDE * SIDE
    assert panel.counts[WORDS[0]] == pytest.approx(3 * size, abs=2)
    assert panel.counts["saturated"] == pytest.approx(size, abs=40)
    assert "Saturated" in panel.profile.reasons.texts
    known = board.controller.project.known_field(board.controller.current, NAME).values
    place = board.controller.scan.scan.attributes["place"]
    for number in (1, 2, 3):
        assert np.nanmean(known[place == number]) == pytest.approx(RHOS[number], rel=0.01)
    board.controller.undo()
    qtbot.waitUntil(lambda: not panel.profile.facts.isVisible())
    assert board.controller.scan.parameters.profile is None
    board.controller.redo()
    qtbot.waitUntil(panel.profile.share.isVisible)
    press(panel, "Remove", qtbot)
    assert board.controller.scan.parameters.profile is None
    assert last_title(board) == "Use no profile"


def test_partial_hits_are_told_and_taken_along(panel, board, qtbot) -> None:
    use_own(panel, board, qtbot)
    board.work.set_parameters(beam=None)
    board.controller.want(board.controller.current, NAME)
    qtbot.waitUntil(lambda: "beam is unknown" in panel.profile.partial_words.text(), timeout=60_000)
    board.work.set_parameters(beam=beam_of_instrument("x330"))
    board.controller.want(board.controller.current, NAME)
    qtbot.waitUntil(lambda: "count as partial hits" in panel.profile.partial_words.text())
    box = panel.profile.partial
    qtbot.mouseClick(box, LEFT, pos=QPoint(8, box.height() // 2))  # only its words can be clicked
    assert board.controller.scan.parameters.partial_hits
    assert last_title(board) == "Use partial hits too"
    board.controller.undo()
    qtbot.waitUntil(lambda: not panel.profile.partial.isChecked())


def test_percent_is_asked(panel, qtbot) -> None:
    for row, text in enumerate(("99", "50", "25", "12")):
        type_cell(panel.making.panels, row, RHO, text, qtbot)
    qtbot.waitUntil(lambda: "looks like percent" in panel.making.notice.text)
    assert not panel.making.button.isEnabled()
    press(panel, "They are percent", qtbot)
    entries = panel.making.panels.entries.values()
    assert [each.rho for each in entries] == pytest.approx(RHOS)
    assert panel.making.button.isEnabled()


def test_an_unknown_wavelength_is_asked(desk, qtbot) -> None:
    draw_panels(desk, desk.open(build_board(nm=None, tool="")))
    panel = desk.show(CalibrationPanel)
    qtbot.waitUntil(lambda: "At which wavelength" in panel.making.notice.text)
    field = panel.making.form.wavelength
    field.setFocus()
    field.selectAll()
    qtbot.keyClicks(field, "1550\r")
    qtbot.waitUntil(panel.making.button.isEnabled)
    panel.making.form.saturated.setValue(SATURATED)
    report = calibrate(panel, qtbot)
    assert report.profile.channels[0].name == NAME
    assert report.profile.name == "board"


def test_what_is_missing_is_said(desk, qtbot, make_scan) -> None:
    panel = desk.show(CalibrationPanel)
    assert "Open a scan" in panel.notice.text
    desk.open(make_scan())
    qtbot.waitUntil(lambda: "reflectance already" in panel.making.notice.text)
    open_tab(panel, POWER, qtbot)
    assert "open or make one first" in panel.power.notice.text
    open_tab(panel, BUDGET, qtbot)
    assert "open or make a profile first" in panel.budget.notice.text
    desk.open(build_board())
    open_tab(panel, MAKE, qtbot)
    qtbot.waitUntil(lambda: "Draw around each panel" in panel.making.notice.text)


def test_the_budget_of_a_leaf_and_of_a_point(panel, board, qtbot) -> None:
    type_cell(panel.making.panels, 2, PANEL_SIGMA, "0.01", qtbot)
    use_own(panel, board, qtbot)
    open_tab(panel, BUDGET, qtbot)
    assert "Click a point" in panel.budget.notice.text
    place = board.controller.scan.scan.attributes["place"]
    with qtbot.waitSignal(panel.budget.explained, timeout=30_000):
        panel.show_point(board.controller.current, int(np.flatnonzero(place == 2)[7]))
    shares = panel.budget.channels[NAME].bars.shares
    assert list(shares) == ["noise", "fit", "panels", "power", "range", "all together"]
    alone = 100 * 0.25 * np.log(10) * NOISE / A0
    assert shares["noise"] == pytest.approx(alone, rel=0.15)
    assert shares["all together"] == pytest.approx(
        np.sqrt(np.nansum([v**2 for name, v in shares.items() if name != "all together"]))
    )
    assert np.isnan(shares["power"])  # nobody measured it: unknown, and not zero
    board.controller.look(leaf=list(board.state.leaves)[2])
    with qtbot.waitSignal(panel.budget.explained, timeout=30_000):
        choose(panel.budget.of, "leaf")
    of_leaf = panel.budget.channels[NAME].bars.shares
    assert of_leaf["noise"] == pytest.approx(alone / SIDE, rel=0.15)
    assert of_leaf["panels"] > 0.0
    assert f"{NAME} = 0.2" in panel.budget.channels[NAME].text.text()
    board.controller.look(leaf=next(iter(board.state.leaves)))
    text = panel.budget.channels[NAME].text
    qtbot.waitUntil(lambda: "saturated" in text.text(), timeout=30_000)
    assert not panel.budget.channels[NAME].bars.isVisible()


def test_the_power_of_another_scan_comes_from_a_panel(panel, board, qtbot) -> None:
    use_own(panel, board, qtbot)
    profile = board.controller.scan.parameters.profile
    key = board.open(build_board(power=0.8))
    draw_panels(board, key)
    panel.use(profile)
    open_tab(panel, POWER, qtbot)
    choose(panel.power.leaf, [leaf.key for leaf in board.state.leaves_of(key)][1])
    assert panel.power.rho.value() == 0.5
    assert panel.power.in_use.texts[NAME].startswith("1, as")
    press(panel, "Measure power", qtbot)
    qtbot.waitUntil(panel.power.use_button.isEnabled, timeout=30_000)
    assert "0.8" in panel.power.found.texts[NAME]
    press(panel, "Use this power", qtbot)
    (power,) = board.controller.scan.parameters.powers
    assert power.value == pytest.approx(0.8, rel=0.01)
    assert "50 %" in power.origin
    assert last_title(board).startswith("Set laser power to 0.")
    board.controller.undo()
    assert board.controller.scan.parameters.powers == ()
    board.controller.redo()
    qtbot.waitUntil(panel.power.reset_button.isEnabled)
    press(panel, "Back to 1", qtbot)
    assert board.controller.scan.parameters.powers == ()


def test_a_published_profile_is_clearly_not_yours(panel, board, qtbot) -> None:
    panel.profile.menu.aboutToShow.emit()
    names = {action.text() for action in panel.profile.menu.actions()}
    assert find_profile("salca").name in names
    said: list[object] = []
    board.controller.failed.disconnect()
    board.controller.failed.connect(said.append)
    salca = next(a for a in panel.profile.menu.actions() if "SALCA" in a.text())
    salca.trigger()
    assert len(said) == 1
    assert "FARO X330" in str(said[0])
    assert board.controller.scan.parameters.profile is None
    board.open(build_board(nm=1545.0, tool=""))
    salca.trigger()
    qtbot.waitUntil(panel.profile.whose.isVisible)
    assert "Published, not yours" in panel.profile.whose.text


def test_a_profile_without_errors_gives_no_bars(panel, board, qtbot) -> None:
    profile = calibrate(panel, qtbot).profile
    silent = msgspec.structs.replace(
        profile.channels[0], noise=None, fit_covariance=(), panel_covariance=()
    )
    panel.use(msgspec.structs.replace(profile, channels=(silent,)))
    qtbot.waitUntil(lambda: "its σ is not known" in panel.profile.facts.texts.get("1550 nm", ""))
    open_tab(panel, BUDGET, qtbot)
    with qtbot.waitSignal(panel.budget.explained, timeout=30_000):
        panel.show_point(board.controller.current, SIDE + 5)
    widget = panel.budget.channels[NAME]
    assert "How sure it is, the profile does not tell" in widget.text.text()
    assert not widget.bars.isVisible()


def test_what_a_profile_leaves_untold_is_said_in_the_bars(panel, board, qtbot) -> None:
    profile = calibrate(panel, qtbot).profile
    half = msgspec.structs.replace(profile.channels[0], panel_covariance=())
    panel.use(msgspec.structs.replace(profile, channels=(half,)))
    open_tab(panel, BUDGET, qtbot)
    with qtbot.waitSignal(panel.budget.explained, timeout=30_000):
        panel.show_point(board.controller.current, SIDE + 5)
    widget = panel.budget.channels[NAME]
    assert widget.bars.isVisible()
    assert widget.bars.shares["noise"] > 0.0
    assert np.isnan(widget.bars.shares["panels"])
    assert np.isnan(widget.bars.shares["all together"])
    assert "±" not in widget.text.text()


def test_limits_of_another_instrument_do_not_stay(panel, board, qtbot) -> None:
    form = panel.making.form
    assert form.saturated.value() == SATURATED
    board.open(build_board(tool=""))
    qtbot.waitUntil(lambda: form.saturated.text() == "no limit")
    form.saturated.setValue(1500.0)
    board.open(build_board())
    qtbot.waitUntil(lambda: form.dark.value() == -2048)
    assert form.saturated.value() == 1500.0  # what was typed stays


def test_profile_and_report_are_saved_and_opened(panel, board, qtbot, tmp_path) -> None:
    panel.dialogs.folder = tmp_path
    report = calibrate(panel, qtbot)
    press(panel, "Save profile…", qtbot)
    name_file(panel, tmp_path / "mine.toml", qtbot)
    assert read_profile(tmp_path / "mine.toml") == report.profile
    press(panel, "Save report…", qtbot)
    name_file(panel, tmp_path / "mine.md", qtbot)
    qtbot.waitUntil((tmp_path / "mine.png").is_file, timeout=30_000)
    assert "reflectance_1550" in (tmp_path / "mine.md").read_text(encoding="utf-8")
    qtbot.waitUntil(lambda: not board.controller.bridge.jobs)
    press(panel, "Open profile…", qtbot)
    name_file(panel, tmp_path / "mine.toml", qtbot)
    assert board.controller.scan.parameters.profile == report.profile
    qtbot.waitUntil(panel.profile.save_button.isVisible)
    press(panel, "Save as…", qtbot)
    name_file(panel, tmp_path / "again.toml", qtbot)
    assert read_profile(tmp_path / "again.toml") == report.profile


def test_a_table_becomes_a_profile_of_all_its_channels(panel, board, qtbot, tmp_path) -> None:
    path, chance = tmp_path / "panels.csv", np.random.default_rng(4)
    rows = ["range,dn,reflectance,channel,wavelength_nm"]
    for name, nm in (("near", 1063), ("intensity", 1550)):
        for rho in RHOS[1:]:
            dn = A1 + A0 * np.log10(rho) + chance.normal(0, 3)
            rows.append(f"{DISTANCE},{dn:.2f},{100 * rho:g},{name},{nm}")
    path.write_text("\n".join(rows), encoding="utf-8")
    choose(panel.making.form.source, "table")
    qtbot.waitUntil(lambda: "Choose a table" in panel.making.notice.text)
    press(panel, "Choose a table…", qtbot)
    name_file(panel, path, qtbot)
    qtbot.waitUntil(lambda: "looks like percent" in panel.making.notice.text, timeout=20_000)
    assert "6 rows" in panel.making.form.table_words.text()
    press(panel, "They are percent", qtbot)
    panel.making.form.margin.setValue(0.2)
    report = calibrate(panel, qtbot)
    assert [c.name for c in report.profile.channels] == ["reflectance_1063", NAME]
    fit = panel.making.fit
    assert fit.channel.isVisible()
    fit.channel.setCurrentIndex(1)
    fit.channel.activated.emit(1)
    assert NAME in fit.sentence.text()
    press(panel, "Use this profile", qtbot)
    assert [c.name for c in board.controller.scan.channels] == [NAME, "intensity"]


def test_bad_panels_are_one_sentence_and_keep_the_last_fit(panel, board, qtbot) -> None:
    said: list[object] = []
    board.controller.failed.disconnect()
    board.controller.failed.connect(said.append)
    report = calibrate(panel, qtbot)
    for row in (1, 2):
        type_cell(panel.making.panels, row, RHO, "", qtbot)
    press(panel, "Calibrate", qtbot)
    qtbot.waitUntil(lambda: len(said) == 1, timeout=20_000)
    assert "needs panels of 2 reflectances" in str(said[0])
    assert panel.making.fit.report is report
    assert panel.making.button.isEnabled()


def test_reflectance_its_error_and_its_mark_can_be_chosen(panel, board, qtbot) -> None:
    use_own(panel, board, qtbot)
    key, project = board.controller.current, board.controller.project
    groups = {field.name: field for field in list_fields(project, key)}
    names = (NAME, f"{NAME}_sigma", f"{NAME}_mark")
    order = list(groups)
    assert order.index(names[0]) + 2 == order.index(names[1]) + 1 == order.index(names[2])
    for name in names:
        assert (groups[name].group, groups[name].missing) == ("Channels", "")
    assert groups[f"{NAME}_mark"].title == f"Mark of {NAME}"
    assert group_of(project.catalogue(key)["hit_fraction"], project.state.scan(key)) == "Geometry"
    bare = board.open(build_board(nm=900.0, tool=""))
    profile = project.state.scan(key).parameters.profile
    board.work.set_parameters(profile=profile)
    for name in names:
        assert "has no raw channel" in why_not(project, bare, name)

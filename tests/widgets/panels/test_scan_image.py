"""The scan image under real hands: what is selected, picked, shown, moved and undone."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.model.operations import Coordinates, MarkGhosts, MovePoints, Select, SetDeleted, SetPose
from app.model.points import PointSet
from app.model.scan import Pose
from app.render.overlay import GHOST_COLOUR, SELECTED_COLOUR
from app.render.scan_image.frame import Frame
from app.services.jobs import Job
from widgets.panels.scan_image import ScanImagePanel
from widgets.tools import Tools

LEFT, MIDDLE = Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton
PLAIN = Qt.KeyboardModifier.NoModifier
SHIFT, CTRL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier
ROWS, COLUMNS = 61, 121


class Hands:
    """A panel, its tools, and a mouse over it."""

    def __init__(self, desk, qtbot) -> None:
        self.desk, self.qtbot = desk, qtbot
        self.panel = desk.show(ScanImagePanel)
        self.tools = Tools(self.panel)
        self.panel.use_tools(self.tools)
        self.view = self.panel.view
        self.rest()

    @property
    def scan(self):
        return self.desk.controller.scan

    def rest(self) -> None:
        controller = self.desk.controller
        self.qtbot.waitUntil(
            lambda: not controller.bridge.jobs and not controller._later.isActive(), timeout=60_000
        )
        QTest.qWait(30)

    def place(self, row: float, column: float) -> QPoint:
        return self.view.place_of(row, column).toPoint()

    def drag(self, *places: tuple[float, float], keys=PLAIN, button=LEFT) -> None:
        spots = [self.place(*place) for place in places]
        QTest.mousePress(self.view, button, keys, spots[0])
        for spot in spots[1:]:
            QTest.mouseMove(self.view, spot)
        QTest.mouseRelease(self.view, button, keys, spots[-1])
        self.rest()

    def click(self, row: int, column: int) -> None:
        QTest.mouseClick(self.view, LEFT, PLAIN, self.place(row, column))
        self.rest()

    def turn_wheel(self, notches: int, at: QPoint) -> None:
        event = QWheelEvent(
            QPointF(at), QPointF(self.view.mapToGlobal(at)), QPoint(), QPoint(0, 120 * notches),
            Qt.MouseButton.NoButton, PLAIN, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(self.view, event)

    def colour(self, row: int, column: int) -> tuple[int, int, int]:
        colour = self.view.grab().toImage().pixelColor(self.place(row, column))
        return colour.red(), colour.green(), colour.blue()

    def block(self, top: int, left: int, bottom: int, right: int) -> set[int]:
        """Points of those rows and columns of the picture, one by one.

        The rows of the scan count upwards, and its columns to the left.
        """
        grid = self.scan.scan.grid
        row, column = ROWS - 1 - grid.row, COLUMNS - 1 - grid.column
        alive = self.scan.alive
        return {
            point
            for point in range(len(row))
            if alive[point] and top <= row[point] <= bottom and left <= column[point] <= right
        }


@pytest.fixture
def hands(opened, qtbot) -> Hands:
    opened.controller.look(colour="near", show_leaves=False)
    hands = Hands(opened, qtbot)
    hands.panel.resize(1000, 560)
    hands.rest()
    return hands


def test_the_picture_stands_upright_and_fits(hands) -> None:
    layout = hands.view.image.layout
    assert (layout.rows, layout.columns, layout.kind) == (ROWS, COLUMNS, "scan grid")
    point = hands.view.image.point_at(0, 0)
    _, y, z = hands.scan.scan.xyz[point]
    assert z == pytest.approx(hands.scan.scan.xyz[:, 2].max(), abs=0.001)
    assert y == pytest.approx(hands.scan.scan.xyz[:, 1].max(), abs=0.001)
    assert hands.view.frame == Frame.fit(layout, (hands.view.width(), hands.view.height()))


def test_a_rectangle_selects_and_undo_takes_it_back(hands) -> None:
    hands.tools.arm("rectangle")
    hands.drag((10, 30), (12, 40), (20, 60))
    # The pixel in whose middle the hand began belongs to it, as its centre lies on the line.
    inner, outer = hands.block(11, 31, 19, 59), hands.block(10, 30, 20, 60)
    found = set(hands.scan.selection.indices.tolist())
    assert inner <= found <= outer
    assert hands.desk.controller.project.history.done[-1].title.startswith("Select")
    assert hands.colour(15, 45) != hands.colour(15, 70)
    hands.desk.controller.undo()
    hands.rest()
    assert len(hands.scan.selection) == 0


def test_shift_adds_and_ctrl_takes_away(hands) -> None:
    hands.tools.arm("rectangle")
    hands.drag((5, 10), (25, 40))
    first = len(hands.scan.selection)
    hands.drag((30, 10), (50, 40), keys=SHIFT)
    both = set(hands.scan.selection.indices.tolist())
    assert len(both) > first
    assert hands.block(31, 11, 49, 39) <= both
    hands.drag((0, 0), (60, 20), keys=CTRL)
    assert not hands.block(6, 11, 24, 19) & set(hands.scan.selection.indices.tolist())
    assert hands.block(6, 22, 24, 39) <= set(hands.scan.selection.indices.tolist())
    assert len(hands.desk.controller.project.history.done) == 6  # open, two leaves, three


def test_a_freehand_contour_selects_what_it_holds(hands) -> None:
    hands.tools.arm("lasso")
    around = np.linspace(0, 2 * np.pi, 40)
    hands.drag(*[(30 + 12 * np.sin(a), 60 + 20 * np.cos(a)) for a in around])
    found = set(hands.scan.selection.indices.tolist())
    for row, column in ((30, 60), (24, 50), (36, 70)):
        assert hands.block(row, column, row, column) <= found
    assert not hands.block(30, 85, 30, 85) & found


@pytest.mark.parametrize("purpose", ["leaf", "ghost", "delete"])
def test_a_contour_does_what_the_tools_are_set_to(hands, purpose: str) -> None:
    hands.tools.arm("rectangle")
    hands.tools.use_lasso_to(purpose)
    assert hands.tools.tool == "rectangle"
    before = len(hands.desk.state.leaves)
    hands.drag((10, 30), (20, 60))
    inner = sorted(hands.block(11, 31, 19, 59))
    if purpose == "leaf":
        assert len(hands.desk.state.leaves) == before + 1
    elif purpose == "ghost":
        assert (hands.scan.marks[inner] == 1).all()
        assert hands.colour(15, 45) == pytest.approx(GHOST_COLOUR[:3], abs=60)
    else:
        assert inner == []
        assert hands.view.image.point_at(15, 45) == -1
        hands.desk.controller.undo()
        hands.rest()
        assert hands.view.image.point_at(15, 45) >= 0


def test_a_selection_from_elsewhere_lights_up(hands) -> None:
    point = hands.view.image.point_at(30, 60)
    rows, columns = np.indices((9, 9)).reshape(2, -1) + 26
    near = PointSet(hands.view.image.levels[0][rows, columns + 30])
    before = hands.colour(30, 60)
    hands.desk.controller.do(Select(hands.desk.controller.current, near))
    hands.rest()
    assert point in near.indices
    expected = 0.157 * np.array(before) + 0.843 * np.array(SELECTED_COLOUR[:3])
    assert np.abs(np.array(hands.colour(30, 60)) - expected).max() < 4


def test_a_huge_selection_lights_up_from_the_worker(hands, monkeypatch) -> None:
    monkeypatch.setattr("widgets.panels.scan_image.MANY", 100)
    key, controller = hands.desk.controller.current, hands.desk.controller
    before = hands.colour(30, 60)
    controller.do(Select(key, PointSet(range(len(hands.scan.scan)))))
    hands.rest()
    assert hands.view.paint.lit[0].all()
    assert hands.colour(30, 60) != before
    controller.do(Select(key, PointSet(range(3000))))
    controller.undo()
    controller.undo()
    hands.rest()
    assert hands.view.paint.lit == []
    assert hands.colour(30, 60) == before


def test_a_click_picks_what_is_shown(hands, qtbot) -> None:
    expected = hands.view.image.point_at(30, 60)
    with qtbot.waitSignal(hands.panel.point_picked) as found:
        hands.click(30, 60)
    assert found.args == [hands.desk.controller.current, expected]
    hands.panel.show_point(*found.args)
    hands.rest()
    assert hands.view.marked == (30, 60)


def test_the_line_tells_row_column_angles_and_value(hands) -> None:
    QTest.mouseMove(hands.view, hands.place(20, 60) + QPoint(1, 1))
    QTest.mouseMove(hands.view, hands.place(20, 60))
    hands.rest()
    point = hands.view.image.point_at(20, 60)
    grid, xyz = hands.scan.scan.grid, hands.scan.scan.xyz[point]
    elevation = np.rad2deg(np.arctan2(xyz[2], np.hypot(xyz[0], xyz[1])))
    line = hands.panel.foot.line.text()
    assert f"Row {grid.row[point]}, column {grid.column[point]}" in line
    assert f"elevation {elevation:.3f}°" in line
    assert f"{np.linalg.norm(xyz):.3f} m" in line
    value = hands.scan.scan.attributes["near"][point]
    assert f"near (1063 nm) {value:.4f}" in line


def test_beside_the_picture_the_line_tells_what_it_is(hands) -> None:
    hands.view.hovered.emit(-1, -1)
    assert hands.panel.foot.line.text() == "Rows and columns of the file, 61 × 121 pixels"


def test_the_wheel_zooms_at_the_cursor_and_the_middle_button_moves(hands) -> None:
    at = hands.place(20, 90)
    before = hands.view.frame.to_image(at.x(), at.y())
    hands.turn_wheel(5, at)
    assert hands.view.frame.to_image(at.x(), at.y()) == pytest.approx(before, abs=1e-6)
    assert hands.view.frame.high > 2 * Frame.fit(hands.view.image.layout, (1000, 560)).high
    left = hands.view.frame.left
    QTest.mousePress(hands.view, MIDDLE, PLAIN, at)
    QTest.mouseMove(hands.view, at + QPoint(25, 0))
    QTest.mouseRelease(hands.view, MIDDLE, PLAIN, at + QPoint(25, 0))
    assert hands.view.frame.left == pytest.approx(left + 25)
    QTest.mouseDClick(hands.view, LEFT, PLAIN, at)
    assert hands.view.frame == Frame.fit(
        hands.view.image.layout, (hands.view.width(), hands.view.height())
    )


def test_keys_move_and_zoom(hands) -> None:
    whole = hands.view.frame
    for _ in range(6):
        QTest.keyClick(hands.view, Qt.Key.Key_Plus)
    assert hands.view.frame.high > 3 * whole.high
    left = hands.view.frame.left
    QTest.keyClick(hands.view, Qt.Key.Key_Right)
    assert hands.view.frame.left < left
    QTest.keyClick(hands.view, Qt.Key.Key_0)
    assert hands.view.frame == whole


def test_escape_puts_the_tool_away_for_all(hands) -> None:
    hands.tools.arm("lasso")
    QTest.keyClick(hands.view, Qt.Key.Key_Escape)
    assert hands.tools.tool == "navigate"


def test_other_colours_do_not_lay_the_picture_out_again(hands) -> None:
    made: list[Job] = []
    hands.desk.controller.bridge.job_changed.connect(made.append)
    image, before = hands.view.image, hands.colour(30, 60)
    hands.desk.controller.look(colour="far", maps={"far": "batlow"})
    hands.rest()
    hands.desk.controller.do(MarkGhosts(hands.desk.controller.current, PointSet([3, 4])))
    hands.rest()
    assert hands.view.image is image
    assert hands.colour(30, 60) != before
    assert not [job for job in made if "scan image" in job.title]


def test_deleting_makes_only_the_index_anew(hands) -> None:
    image = hands.view.image
    hands.desk.controller.do(SetDeleted(hands.desk.controller.current, PointSet([0, 1])))
    hands.rest()
    assert hands.view.image is not image
    assert hands.view.image.layout is image.layout


def test_moved_points_lie_elsewhere(hands) -> None:
    layout, key = hands.view.image.layout, hands.desk.controller.current
    to = Coordinates(0.5 * hands.scan.scan.xyz[:3])
    hands.desk.controller.do(MovePoints(key, PointSet([0, 1, 2]), to))
    hands.rest()
    assert hands.view.image.layout is not layout
    assert hands.view.image.layout.distance[0] == pytest.approx(0.5 * layout.distance[0])


def test_a_hidden_panel_makes_no_picture(desk, make_scan, qtbot) -> None:
    made: list[Job] = []
    desk.controller.bridge.job_changed.connect(made.append)
    panel = ScanImagePanel(desk.controller, desk.work, desk.documents)
    qtbot.addWidget(panel)
    desk.open(make_scan())
    qtbot.wait(100)
    assert panel.view.image is None
    assert not [job for job in made if "scan image" in job.title]


def test_without_a_position_it_says_so_and_asks(desk, make_scan, qtbot) -> None:
    key = desk.open(make_scan(pose=False))
    hands = Hands(desk, qtbot)
    assert "position of bent leaf is unknown" in hands.panel.notice.text
    assert hands.view.isHidden()
    with qtbot.waitSignal(hands.panel.origin_asked) as asked:
        qtbot.mouseClick(hands.panel.notice.button, LEFT)
    assert asked.args == [key]
    desk.controller.do(SetPose(key, Pose((0.0, 0.0, 0.0), known_by="given")))
    hands.rest()
    assert hands.panel.notice.isHidden()
    assert hands.view.isVisible()
    assert hands.view.image is not None


def test_without_a_scan_it_says_what_it_is_for(desk, qtbot) -> None:
    hands = Hands(desk, qtbot)
    assert "Open a scan" in hands.panel.notice.text
    assert hands.panel.notice.button.isHidden()


def test_a_cancelled_picture_can_be_made_again(desk, make_scan, qtbot) -> None:
    hands, free = Hands(desk, qtbot), threading.Event()
    desk.controller.run("Something else", lambda _: free.wait(30), lambda _: None)
    desk.open(make_scan())
    jobs = desk.controller.bridge
    qtbot.waitUntil(lambda: any("scan image" in job.title for job in jobs.jobs))
    jobs.jobs[-1].cancel()
    free.set()
    qtbot.waitUntil(lambda: "not made" in hands.panel.notice.text, timeout=10_000)
    qtbot.mouseClick(hands.panel.notice.button, LEFT)
    qtbot.waitUntil(lambda: hands.view.image is not None, timeout=10_000)


def test_each_scan_keeps_its_picture(hands, make_scan) -> None:
    first, image = hands.desk.controller.current, hands.view.image
    hands.desk.open(make_scan("another"))
    hands.rest()
    assert hands.view.image is not image
    hands.desk.controller.look(current=first)
    hands.rest()
    assert hands.view.image is image


def test_a_narrow_foot_leaves_room_for_its_line(hands) -> None:
    foot = hands.panel.foot
    foot.explain_silence(True)
    assert not foot.legend.isHidden()
    hands.panel.resize(20 * foot.fontMetrics().height(), 400)
    hands.rest()
    assert foot.legend.isHidden()
    assert not foot.swatch.isHidden()
    assert foot.swatch.toolTip()
    assert foot.line.toolTip() == foot.line.text() != ""

"""The 3-D view: shows scenes, moves the camera, and gives the mouse to the tools."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPoint, Qt, Signal
from PySide6.QtGui import QCloseEvent, QResizeEvent
from PySide6.QtWidgets import QWidget

from app.core.arrays import Floats
from app.core.screen import View
from app.model.scene import ColourBar, Scene
from app.render.camera import Camera, centre_on, look_at_points, make_orthographic
from app.render.legend import count_points
from app.render.palettes import Background
from app.render.picture import PictureSource, known_values
from app.render.stage import Stage
from widgets.viewport.canvas import Canvas
from widgets.viewport.colour_bar import ColourBarWidget
from widgets.viewport.drawings import ViewDrawings
from widgets.viewport.framing import EDGE, Framing
from widgets.viewport.mouse import Mouse
from widgets.viewport.overlay import OverlayWidget
from widgets.viewport.refinement import Refinement
from widgets.viewport.tools.lasso import Lasso
from widgets.viewport.tools.navigate import Navigate
from widgets.viewport.tools.pick import Pick
from widgets.viewport.tools.rectangle import Rectangle
from widgets.viewport.tools.tool import Tool

CLICK_REACH = 4  # pixels
NARROW_VIEW = 30
"""Width in heights of the font below which the colour bar has no room for its histogram."""


class View3D(QWidget):
    """Shows a scene and nothing else: it owns no facts. Call `close` before the window closes.

    Signals
    -------
    camera_moved()
    hovered(x, y)
        The mouse moved with no button held; shares of the view, y down, as everywhere here.
    picked(x, y)
    lasso_finished(corners, combine)
        A list of (x, y) and ``replace``, ``add`` or ``subtract``.
    context_requested(position)
        A right click that was no drag; global position.
    limits_changed(low, high, finished)
        A handle of the colour bar moved.
    tool_changed(name)
    progressed()
        `drawn` is another number.
    """

    camera_moved = Signal()
    hovered = Signal(float, float)
    picked = Signal(float, float)
    lasso_finished = Signal(object, str)
    context_requested = Signal(QPoint)
    limits_changed = Signal(float, float, bool)
    tool_changed = Signal(str)
    progressed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._stage = Stage(scale=self.devicePixelRatioF())
        self._camera = look_at_points(self._stage.extent())
        self._bar: ColourBar | None = None
        self._canvas = Canvas(self._stage.renderer, self)
        self._overlay = OverlayWidget(self)
        self.colour_bar = ColourBarWidget(self)
        self._framing = Framing(self._canvas, self.colour_bar, self._stage.extent)
        self._refinement = Refinement(self._stage, self._canvas, self)
        self.drawings = ViewDrawings(self._stage, self._refinement)
        navigate = Navigate(self)
        self._tools: dict[str, Tool] = {
            "navigate": navigate,
            "lasso": Lasso(self, self.lasso_finished.emit),
            "rectangle": Rectangle(self, self.lasso_finished.emit),
            "pick": Pick(self, self.picked.emit),
        }
        self._mouse = Mouse(self, navigate)
        self._mouse.armed.connect(self._note_tool)
        self._mouse.hovered.connect(self.hovered)
        self._mouse.context_requested.connect(self.context_requested)
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName(self.tr("3-D view"))
        self._refinement.progressed.connect(self._note_progress)
        self.colour_bar.limits_changed.connect(self._note_limits)
        self.set_background("light")
        self.set_tool("navigate")

    # What is shown

    def show_scene(self, scene: Scene, source: PictureSource) -> None:
        """Bring a scene to the screen; only what differs is touched."""
        before = self._stage.scene
        changed = self._stage.show(scene, source)
        if not before.clouds and scene.clouds:
            self.fit_all()
        self._show_bar(scene, source, bool(changed & {"colour", "points"}))
        if changed:
            self._refinement.begin()
        self._note_progress()

    def set_background(self, background: Background) -> None:
        """Light or dark."""
        self._stage.set_background(background)
        self.colour_bar.set_background(background)
        self._overlay.set_background(background)
        self._refinement.begin()

    @property
    def drawn(self) -> int:
        """Points in the picture at this moment."""
        return self._refinement.drawn

    @property
    def at_rest(self) -> bool:
        """Whether every point that is shown has been drawn."""
        return self._refinement.complete

    @property
    def counts(self) -> str:
        """``shown / total points``, and how many of them are drawn while it is not all."""
        return self._overlay.text

    # Camera

    def current_view(self) -> View:
        """The camera as a matrix, for `app.core.screen`; sized in device pixels."""
        return self._stage.view(self._canvas.device_size())

    def camera(self) -> Camera:
        """Where the viewer stands, in world metres."""
        return self._camera

    def set_camera(self, camera: Camera, framed: bool = False) -> None:
        """Look from there and stay; `framed` views follow the size of the window."""
        if not framed:
            self._framing.forget()
        self._place(camera)
        self._refinement.begin()

    def move_camera(self, camera: Camera) -> None:
        """Look from there; more movement is likely to follow."""
        self._framing.forget()
        self._place(camera)
        self._refinement.begin(hold=True)

    def fit_all(self) -> None:
        """Show everything from the present direction."""
        self.fit(self._stage.extent())

    def fit(self, points: Floats) -> None:
        """Show some points, (k, 3) world metres, from the present direction."""
        self.set_camera(self._framing.around(self._camera, points), framed=True)

    def view_from(self, scanner: Floats) -> None:
        """Show what the scanner saw."""
        self.set_camera(self._framing.from_scanner(scanner), framed=True)

    def view_standard(self, name: str) -> None:
        """One of the standard views: top, bottom, front, back, left, right, iso, iso back."""
        orthographic = self._camera.parallel_scale is not None
        self.set_camera(self._framing.standard(name, orthographic), framed=True)

    def set_orthographic(self, on: bool) -> None:
        """Switch between orthographic and perspective."""
        self.set_camera(make_orthographic(self._camera, on))

    def centre_at(self, x: float, y: float) -> bool:
        """Turn around what is drawn at a place; tells whether there is something."""
        width, height = self._canvas.device_size()
        reach = round(CLICK_REACH * self.devicePixelRatioF())
        found = self._canvas.read_depth(round(x * width), round((1 - y) * height), reach)
        if found is None:
            return False
        column, row, depth = found
        clip = (2 * (column + 0.5) / width - 1, 2 * (row + 0.5) / height - 1, 2 * depth - 1, 1.0)
        view = self.current_view()
        point = np.linalg.solve(np.array(view.matrix), clip)
        self.set_camera(centre_on(self._camera, point[:3] / point[3] + view.origin))
        return True

    # Tools

    def set_tool(self, name: str) -> None:
        """Arm a tool: ``navigate``, ``lasso``, ``rectangle`` or ``pick``."""
        self._mouse.arm(self._tools[name])

    def refresh_overlay(self) -> None:
        """Paint what lies over the picture again."""
        self._overlay.update()

    def _note_tool(self, tool: Tool) -> None:
        self._overlay.tool = tool
        self.setCursor(tool.cursor)
        self.tool_changed.emit(tool.name)

    # Qt

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        """Keep everything in its place."""
        self._stage.set_scale(self.devicePixelRatioF())
        self._canvas.setGeometry(self.rect())
        self._overlay.setGeometry(self.rect())
        self.colour_bar.set_narrow(self.width() < NARROW_VIEW * self.fontMetrics().height())
        hint, edge = self.colour_bar.sizeHint(), EDGE
        height = min(hint.height(), self.height() - 2 * edge)
        left = self.width() - hint.width() - edge
        self.colour_bar.setGeometry(left, edge, hint.width(), max(height, 0))
        again = self._framing.again()
        if again is not None:
            self.set_camera(again, framed=True)

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        """Give back the graphics card before the window goes."""
        self._refinement.stop()
        self._stage.clear()
        self._canvas.release()
        super().closeEvent(event)

    def _place(self, camera: Camera) -> None:
        self._camera = camera
        self._stage.set_camera(camera)
        self._overlay.set_camera(camera)
        self.camera_moved.emit()

    def _show_bar(self, scene: Scene, source: PictureSource, recount: bool) -> None:
        cloud = next((cloud for cloud in scene.clouds if cloud.bar is not None), None)
        self._bar = None if cloud is None else cloud.bar
        values = None
        if cloud is not None and cloud.bar is not None and recount:
            values = known_values(source.values(cloud.scan, cloud.bar.field))
        self.colour_bar.show_bar(self._bar, values)

    def _note_limits(self, low: float, high: float, finished: bool) -> None:
        if self._bar is not None:
            self._stage.set_range(self._bar.field, low, high)
            self._refinement.begin(hold=not finished)
        self.limits_changed.emit(low, high, finished)

    def _note_progress(self) -> None:
        scene = self._stage.scene
        text = count_points(scene.shown, scene.total) if scene.clouds else ""
        if text and not self.at_rest:
            text += f" · {100 * self.drawn // max(scene.shown, 1)} %"
        missing = sorted({cloud.missing for cloud in scene.clouds if cloud.missing})
        if missing:
            text += " · " + self.tr("no values: {}").format(", ".join(missing))
        self._overlay.set_text(text)
        self.progressed.emit()

"""What the scanner saw, as a picture: the same colours, selection and tools as in 3-D."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QVBoxLayout

from app.core.arrays import Bools, Floats, Ints
from app.core.progress import Progress
from app.model.events import EVERYTHING, Change
from app.model.fields import Same
from app.model.points import PointSet
from app.model.selection import Explicit
from app.model.state import ScanState
from app.render.palettes import Background
from app.render.picture import ProjectSource, known_values
from app.render.scan_image.image import ScanImage
from widgets.common.notice import Notice
from widgets.common.numbers import show_count
from widgets.common.panel import Panel
from widgets.common.scan_image.foot import Foot
from widgets.common.scan_image.rasters import Rasters
from widgets.common.scan_image.view import ScanImageView
from widgets.common.scan_image.words import describe_image, describe_place
from widgets.leaf_work import Combine
from widgets.tools import Tools

MANY = 2_500_000
"""Selected points beyond which the worker finds their pixels: a window must not wait."""
DARK = 128  # lightness of the window below which the theme is dark


class ScanImagePanel(Panel):
    """The scan image of the current scan.

    Signals
    -------
    point_picked(scan, point)
    """

    point_picked = Signal(str, int)

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("scan-image")
        self.setWindowTitle(self.tr("Scan image"))
        self.tools = Tools(self)
        self.rasters = Rasters(self.controller, self)
        self.picked: tuple[str, int] | None = None
        self._shown: dict[str, object] = {}
        self._place = (-1, -1)
        self.notice = Notice(self)
        self.view = ScanImageView(self)
        self.foot = Foot(self)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.notice)
        layout.addWidget(self.view, 1)
        layout.addWidget(self.foot)
        layout.addStretch(0)  # where there is only a notice, it stays at the top
        self._connect()
        self.restyle()

    def _connect(self) -> None:
        self.notice.clicked.connect(self._on_notice)
        self.rasters.made.connect(self.refresh_soon)
        self.controller.scene_changed.connect(self._on_view)
        self.view.hovered.connect(self._on_hover)
        self.view.clicked.connect(self._on_click)
        self.view.outlined.connect(self._on_outline)
        self.view.tool_changed.connect(self._on_tool)
        self.foot.zoomed.connect(self.view.zoom_steps)
        self.foot.fitted.connect(self.view.fit)
        self.tools.changed.connect(self._follow_tools)

    def use_tools(self, tools: Tools) -> None:
        """Follow the tools of the window, which serve the 3-D view too."""
        self.tools.changed.disconnect(self._follow_tools)
        self.tools = tools
        tools.changed.connect(self._follow_tools)
        self._follow_tools()

    def show_point(self, scan: str, point: int) -> None:
        """Put a ring around the point that was picked, here or in 3-D."""
        self.picked = scan, point
        self.refresh_soon()

    def on_document(self, change: Change) -> None:
        """Note that the document changed."""
        if change is EVERYTHING:
            self.rasters.forget()
            self.picked = None
            self._shown.clear()
        super().on_document(change)

    # What is shown

    def refresh(self) -> None:
        """Show the scan as it is now."""
        scans = self.controller.project.state.scans
        self.rasters.keep_only({key for key, state in scans.items() if not state.closed})
        key, state = self.controller.current, self.controller.scan
        image = self._find(key, state)
        self.foot.setEnabled(image is not None)
        for part in (self.view, self.foot):
            part.setVisible(image is not None or not self.notice.text)
        if image is not self.view.image:
            self._shown.clear()
            self.view.show_image(image)
            self.foot.explain_silence(image is not None and bool(image.silent[0].any()))
        if image is not None and key is not None and state is not None:
            self._dress(key, state, image)
        self._tell()

    def _find(self, key: str | None, state: ScanState | None) -> ScanImage | None:
        self.notice.say("")
        if key is None or state is None:
            self.notice.say(self.tr("Open a scan to see what the scanner saw."))
            return None
        if state.scan.pose is None:
            text = self.tr("The picture shows what the scanner saw from its position, and the ")
            text += self.tr("position of {0} is unknown.").format(state.scan.name)
            self.notice.say(text, self.tr("Set &scanner position…"))
            return None
        image = self.rasters.find(key, state)
        if image is None and self.rasters.stopped(key):
            self.notice.say(self.tr("The scan image was not made."), self.tr("&Make it"))
        return image

    def _dress(self, key: str, state: ScanState, image: ScanImage) -> None:
        """Bring colours, marks and selection up to date; each only when it is another."""
        view, paint = self.controller.view, self.view.paint
        cloud = next((c for c in self.controller.scene.clouds if c.scan == key), None)
        if self._differs("colour", None if cloud is None else (cloud.colour, cloud.bar)):
            bar = None if cloud is None else cloud.bar
            known = self.controller.project.known_field(key, bar.field) if bar else None
            paint.use_colours(bar, known_values(known))
        if self._differs("marks", None if cloud is None else cloud.overlay[1:]):
            paint.use_marks(
                ProjectSource(self.controller.project, view).overlay(key), len(state.scan)
            )
        if self._differs("selection", Same(state.selection)):
            self._light_up(image, state.selection)
        picked = self.picked is not None and self.picked[0] == key
        self.view.mark(image.pixel_of(self.picked[1]) if self.picked and picked else None)

    def _light_up(self, image: ScanImage, selection: PointSet) -> None:
        if len(selection) <= MANY:
            self.view.paint.select(image, selection.indices)
            return

        def done(lit: Bools) -> None:
            if self.view.image is image and self._shown.get("selection") == Same(selection):
                self.view.paint.use_lit(lit)
                self.view.repaint_all()

        title = self.tr("Showing the selection")
        self.controller.run(title, lambda _: image.light(selection.indices), done)

    def _differs(self, part: str, now: object) -> bool:
        if part in self._shown and self._shown[part] == now:
            return False
        self._shown[part] = now
        self.view.repaint_all()
        return True

    def restyle(self) -> None:
        """Take over the theme."""
        dark = self.palette().color(QPalette.ColorRole.Window).lightness() < DARK
        background: Background = "dark" if dark else "light"
        self.view.paint.use_background(background)
        self.view.repaint_all()
        self.foot.recolour(background)

    # Hands

    def _on_notice(self) -> None:
        key, state = self.controller.current, self.controller.scan
        if key is not None and state is not None and state.scan.pose is None:
            self.origin_asked.emit(key)
        elif key is not None:
            self.rasters.forget(key)
            self.refresh_soon()

    def _on_hover(self, row: int, column: int) -> None:
        if self._place != (row, column):
            self._place = row, column
            self._tell()

    def _tell(self) -> None:
        image, key = self.view.image, self.controller.current
        row, column = self._place
        if image is None or key is None:
            said = not self.notice.isHidden()
            self.foot.line.say("" if said else self.tr("The scan image is being made…"))
        elif 0 <= row < image.layout.rows and 0 <= column < image.layout.columns:
            project, colour = self.controller.project, self.controller.view.colour
            self.foot.line.say(describe_place(project, key, image, row, column, colour))
        else:
            self.foot.line.say(describe_image(image))

    def _on_click(self, row: int, column: int) -> None:
        image, key = self.view.image, self.controller.current
        point = -1 if image is None else image.point_at(row, column)
        if key is None or point < 0:
            self.controller.said.emit(self.tr("There is no point here."))
        else:
            self.point_picked.emit(key, point)

    def _on_outline(self, corners: list[tuple[float, float]], combine: Combine) -> None:
        image, key, purpose = self.view.image, self.controller.current, self.tools.purpose
        if image is None or key is None:
            return
        polygon: Floats = np.array(corners, np.float64)

        def work(progress: Progress) -> Ints:
            progress.report(0.1)
            return image.points_in(polygon)

        def done(found: Ints) -> None:
            points = PointSet(found)
            text = self.tr("{0} selected, with those behind others in a pixel")
            self.controller.said.emit(text.format(show_count(len(points))))
            self.work.apply(key, points, Explicit(points), purpose, combine)

        self.controller.run(self.tr("Selecting"), work, done)

    def _follow_tools(self) -> None:
        self.view.set_tool(self.tools.tool)

    def _on_tool(self, name: str) -> None:
        # The view puts a tool away by itself when Escape is pressed in it.
        if name != self.tools.tool and name == "navigate":
            self.tools.arm("navigate")

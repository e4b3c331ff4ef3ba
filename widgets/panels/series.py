"""Series: leaves carried through scans at many angles or times, and their table."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QPushButton, QTabBar, QVBoxLayout, QWidget

from app.model.events import EVERYTHING, Change
from app.model.operations import PutSeries
from app.model.series import Series
from widgets.common.notice import Notice
from widgets.common.panel import Panel, make_scrolling
from widgets.common.series.about_page import AboutPage
from widgets.common.series.carry_page import CarryPage
from widgets.common.series.finder import Finder
from widgets.common.series.table_page import TablePage
from widgets.dialogs.open_scan import FileDialogs

SCANS, CARRY, TABLE = range(3)


class SeriesPanel(Panel):
    """Choose a series, carry its leaves, correct them, measure, fit.

    Signals
    -------
    make_asked()
        A series is to be made.
    change_asked(str)
        The scans of that series are to be changed.
    pick_asked()
        The next clicks in the picture are to pick points.
    """

    make_asked = Signal()
    change_asked = Signal(str)
    pick_asked = Signal()

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("series")
        self.setWindowTitle(self.tr("Series"))
        self.dialogs = FileDialogs(self)
        self.finder = Finder(self.controller, self)
        self.notice = Notice(self)
        self.choice = QComboBox(self)
        self.make_button = QPushButton(self.tr("Ma&ke series…"), self)
        self.tabs = QTabBar(self)
        self.about = AboutPage(self.controller, self)
        self.carrying = CarryPage(self.controller, self.finder, self)
        self.table = TablePage(self.controller, self)
        self._explain()
        self._lay_out()
        self._connect()

    @property
    def series(self) -> Series | None:
        """The series that is shown."""
        return self.controller.project.state.series.get(str(self.choice.currentData()))

    def refresh(self) -> None:
        """Show the series, and the page that is open."""
        self._list()
        series = self.series
        self.notice.say(self._find_missing(series))
        for widget in (self.choice, self.tabs):
            widget.setVisible(series is not None)
        state, open_page = self.controller.project.state, self.tabs.currentIndex()
        ready = series is not None and bool(state.leaves_of(series.reference))
        for place, page in enumerate(self._pages):
            page.setVisible(series is not None and place == open_page and (ready or place == SCANS))
        if not ready:
            self._clear_picture()
        if series is not None and (ready or open_page == SCANS):
            self._pages[open_page].refresh(series)

    @property
    def _pages(self) -> tuple[AboutPage, CarryPage, TablePage]:
        return self.about, self.carrying, self.table

    def on_document(self, change: Change) -> None:
        """Let go of what is out of date, also while nobody looks."""
        if change is EVERYTHING:
            self.finder.forget()
            self.about.forget()
            self.carrying.forget()
            self.table.forget()
        elif not self.isVisible() and change.aspects - {"fields", "selection"}:
            self._clear_picture()
        super().on_document(change)

    def restyle(self) -> None:
        """Draw in the new colours, also what is hidden."""
        self.table.plot.restyle()

    def show_series(self, key: str) -> None:
        """Show a series that was made."""
        self._list()
        self.choice.setCurrentIndex(self.choice.findData(key))
        series = self.series
        if series is not None:
            self.tabs.setCurrentIndex(SCANS)
            self.carrying.go_to(series, series.reference)
        self.refresh_soon()

    def take_point(self, scan: str, row: int) -> None:
        """Take over which point was picked."""
        self.about.take_point(scan, row)

    def _list(self) -> None:
        known = self.controller.project.state.series
        offered = {key: one.name for key, one in known.items()}
        box = self.choice
        if {box.itemData(k): box.itemText(k) for k in range(box.count())} == offered:
            return
        kept = box.currentData()
        box.clear()
        for key, name in offered.items():
            box.addItem(name, key)
        box.setCurrentIndex(max(box.findData(kept), 0))

    def _find_missing(self, series: Series | None) -> str:
        if series is None:
            return self.tr(
                "A series is scans of the same leaves at other angles of their holder, or at "
                "other times. Make one of open scans or of a folder."
            )
        state = self.controller.project.state
        if not state.leaves_of(series.reference):
            return self.tr(
                "{scan} is the reference and has no leaf yet: draw around leaves with the lasso, "
                "or press Find leaves in the Leaves panel."
            ).format(scan=state.scan(series.reference).scan.name)
        return ""

    def _clear_picture(self) -> None:
        if self.controller.view.previewed:
            self.controller.look(previewed=())

    def _forget_series(self) -> None:
        series = self.series
        if series is not None:
            self.controller.do(PutSeries(series.key, None))

    def _change(self) -> None:
        if self.series is not None:
            self.change_asked.emit(self.series.key)

    def _export(self) -> None:
        series = self.series
        if series is not None:
            name = "".join(c if c.isalnum() or c in "-_" else "-" for c in series.name) or "series"
            self.dialogs.ask_save(self.dialogs.folder / f"{name}.csv", self._write, self)

    def _write(self, path: Path) -> None:
        self.table.export(path)

    def _explain(self) -> None:
        self.choice.setAccessibleName(self.tr("Series"))
        self.choice.setToolTip(self.tr("The series that is shown"))
        self.make_button.setToolTip(self.tr("Say which scans belong together, and what they are"))
        self.tabs.setAccessibleName(self.tr("Pages of the series"))
        self.tabs.setExpanding(True)
        for title, tip in (
            (self.tr("Series"), self.tr("What the series is, and how its holder turned")),
            (self.tr("Carry"), self.tr("Carry leaves from scan to scan, confirm and correct them")),
            (self.tr("Table"), self.tr("Measure, draw, export and fit")),
        ):
            self.tabs.setTabToolTip(self.tabs.addTab(title), tip)

    def _lay_out(self) -> None:
        content = QWidget(self)
        line = QHBoxLayout()
        line.addWidget(self.choice, 1)
        line.addWidget(self.make_button)
        layout = QVBoxLayout(content)
        layout.addLayout(line)
        layout.addWidget(self.notice)
        layout.addWidget(self.tabs)
        for page in self._pages:
            layout.addWidget(page, 1)
        layout.addStretch(0)
        make_scrolling(content, self)

    def _connect(self) -> None:
        self.finder.found.connect(self.refresh_soon)
        self.choice.activated.connect(self.refresh_soon)
        self.tabs.currentChanged.connect(self.refresh_soon)
        self.make_button.clicked.connect(self.make_asked)
        self.about.change_asked.connect(self._change)
        self.about.forget_asked.connect(self._forget_series)
        self.about.pick_asked.connect(self.pick_asked)
        self.table.export_asked.connect(self._export)

"""The pages below the plot: curve, models, certainty, table."""

from __future__ import annotations

from PySide6.QtWidgets import QTabBar, QVBoxLayout, QWidget

from widgets.common.curve_editor import CurveEditor
from widgets.common.lab.certainty_page import CertaintyPage
from widgets.common.lab.models_page import ModelsPage
from widgets.common.lab.plots_view import PlotsView
from widgets.common.lab.subject import Subject
from widgets.common.lab.table_page import TablePage
from widgets.controller import Controller


class LabPages(QWidget):
    """One page is seen; only that one is brought up to date, so that the others cost nothing."""

    def __init__(
        self, controller: Controller, plots: PlotsView, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._subject: Subject | None = None
        self.tabs = QTabBar(self)
        self.editor = CurveEditor(plots, self)
        self.models = ModelsPage(controller, self)
        self.certainty = CertaintyPage(controller, self)
        self.table = TablePage(controller, self)
        for title, tip in (
            (self.tr("Curve"), self.tr("Parameters as sliders, with what a fit says of them")),
            (self.tr("Models"), self.tr("All models on the same points, side by side")),
            (self.tr("Certainty"), self.tr("Intervals of the parameters")),
            (self.tr("Table"), self.tr("Many samples and channels fitted at once")),
        ):
            self.tabs.setTabToolTip(self.tabs.addTab(title), tip)
        self.tabs.setAccessibleName(self.tr("Pages of the phase lab"))
        self.tabs.setExpanding(True)
        self.tabs.setUsesScrollButtons(False)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for widget in (self.tabs, self.editor, self.models, self.certainty, self.table):
            layout.addWidget(widget)
        self._show_page()
        self.tabs.currentChanged.connect(self._show_page)

    def show_subject(self, subject: Subject | None) -> None:
        """Take over what is worked on."""
        self._subject = subject
        self._show_page()

    def forget(self) -> None:
        """The document is another one."""
        self._subject = None
        self.table.forget()

    def _show_page(self, _: int = 0) -> None:
        pages = (self.editor, self.models, self.certainty, self.table)
        seen = pages[self.tabs.currentIndex()]
        for page in pages:
            page.setVisible(page is seen)
        if seen is self.models:
            self.models.show_subject(self._subject)
        elif seen is self.certainty:
            self.certainty.show_subject(self._subject)
        elif seen is self.table:
            self.table.follow()

"""What leaves the lab: the figure on white paper, and the numbers of the fits that are shown."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QByteArray, QMimeData, QObject, Signal
from PySide6.QtGui import QGuiApplication, QImage
from PySide6.QtWidgets import QMenu

from app.core.progress import Progress
from app.services.fit import FitReport
from app.services.lab.figure import FigureOrder, draw_figure, figure_bytes
from app.services.lab.table_files import fits_as_text, write_fits
from widgets.common.lab.exporting import move_first
from widgets.common.lab.series import Series, Shape
from widgets.controller import Controller

FIGURES = (".png", ".svg", ".pdf")


class ExportMenu(QObject):
    """Entries of the menu; the panel says what there is to write.

    Signals
    -------
    file_asked(str)
        A file with that ending shall be chosen: `write` shall be called.
    """

    file_asked = Signal(str)

    def __init__(self, controller: Controller, menu: QMenu) -> None:
        super().__init__(menu)
        self._controller = controller
        self._order: FigureOrder | None = None
        self._report: FitReport | None = None
        titles = {
            ".png": self.tr("Figure as &PNG…"),
            ".svg": self.tr("Figure as &SVG…"),
            ".pdf": self.tr("Figure as P&DF…"),
        }
        self.figure_actions = [menu.addAction(titles[suffix]) for suffix in FIGURES]
        for suffix, action in zip(FIGURES, self.figure_actions, strict=True):
            action.triggered.connect(partial(self._ask, suffix))
        self.copy_figure = menu.addAction(self.tr("&Copy figure"))
        self.copy_figure.setToolTip(self.tr("As a picture and as SVG, on white paper"))
        self.copy_figure.triggered.connect(self._copy_figure)
        menu.addSeparator()
        self.csv = menu.addAction(self.tr("Fits as CS&V…"))
        self.csv.triggered.connect(partial(self._ask, ".csv"))
        self.tex = menu.addAction(self.tr("Fits as &LaTeX…"))
        self.tex.triggered.connect(partial(self._ask, ".tex"))
        self.copy_fits = menu.addAction(self.tr("Copy &fits"))
        self.copy_fits.setToolTip(self.tr("As a table for a spreadsheet"))
        self.copy_fits.triggered.connect(self._copy_fits)
        menu.setToolTipsVisible(True)
        self.offer(None, None)

    def offer(self, order: FigureOrder | None, report: FitReport | None) -> None:
        """Say what there is to write."""
        self._order, self._report = order, report
        for action in (*self.figure_actions, self.copy_figure):
            action.setEnabled(order is not None)
        for action in (self.csv, self.tex, self.copy_fits):
            action.setEnabled(report is not None and bool(report.fits))

    def move_first(self, series: Series, shape: Shape | None) -> None:
        """A slider has moved the curve of the first series."""
        self._order = move_first(self._order, series, shape)

    def write(self, path: Path) -> None:
        """Write figure or fits, by the ending; the dialog has asked about a file that exists."""
        order, report = self._order, self._report
        if path.suffix.lower() in FIGURES and order is not None:

            def work(_: Progress) -> None:
                draw_figure(order, path, overwrite=True)

            self._controller.run(self.tr("Writing the figure"), work, partial(self._tell, path))
        elif report is not None and self._controller.attempt(
            lambda: write_fits(report, path, overwrite=True)
        ):
            self._tell(path)

    def _ask(self, suffix: str, _: bool = False) -> None:
        self.file_asked.emit(suffix)

    def _tell(self, path: Path, _: object = None) -> None:
        self._controller.said.emit(self.tr("Written to {0}.").format(path))

    def _copy_figure(self) -> None:
        order = self._order
        if order is None:
            return

        def work(_: Progress) -> tuple[bytes, bytes]:
            return figure_bytes(order, "png"), figure_bytes(order, "svg")

        self._controller.run(self.tr("Copying the figure"), work, self._take_figure)

    def _take_figure(self, pictures: Sequence[bytes]) -> None:
        png, svg = pictures
        data = QMimeData()
        data.setImageData(QImage.fromData(QByteArray(png)))
        data.setData("image/svg+xml", QByteArray(svg))
        QGuiApplication.clipboard().setMimeData(data)
        self._controller.said.emit(self.tr("The figure is on the clipboard."))

    def _copy_fits(self) -> None:
        if self._report is not None:
            QGuiApplication.clipboard().setText(fits_as_text(self._report, "tsv"))
            self._controller.said.emit(self.tr("The fits are on the clipboard."))

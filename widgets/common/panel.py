"""What all panels have in common: when they look at the document, and how they ask it."""

from __future__ import annotations

from collections.abc import Hashable

from PySide6.QtCore import QEvent, QObject, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget

from app.core.arrays import Ints
from app.model.events import EVERYTHING, Change
from app.model.fields import Same, fingerprint
from widgets.controller import Controller
from widgets.documents import Documents
from widgets.leaf_work import LeafWork


class Panel(QWidget):
    """A panel: shows the document as it is, and asks for changes.

    However much changes, `refresh` runs once per turn of the event loop, and only while
    the panel can be seen: a hidden one computes nothing.

    Signals
    -------
    origin_asked(str)
        The user wants to say where the scanner of that scan stood.
    """

    origin_asked = Signal(str)

    def __init__(
        self,
        controller: Controller,
        work: LeafWork,
        documents: Documents,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.controller = controller
        self.work = work
        self.documents = documents
        self._asked: dict[str, Hashable] = {}
        self._stale = True
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._refresh_if_seen)
        controller.document_changed.connect(self.on_document)
        controller.view_changed.connect(self._on_view)
        self.build()

    def build(self) -> None:
        """Make the parts of the panel, once."""
        raise NotImplementedError

    def refresh(self) -> None:
        """Show the document as it is now."""
        raise NotImplementedError

    def restyle(self) -> None:
        """Take over the colours of the palette; only what Qt does not do itself."""

    def on_document(self, change: Change) -> None:
        """Note that the document changed."""
        if change is EVERYTHING:
            self._asked.clear()  # it holds on to the arrays of the document before
        self.refresh_soon()

    def refresh_soon(self) -> None:
        """Refresh when the present turn of the event loop is over."""
        self._stale = True
        self._later.start()

    def ask(self, scan: str, field: str, points: Ints | None, mark: Hashable = None) -> bool:
        """Say whether a field is known at the points; if not, have it computed.

        The panel is refreshed when the values arrive. What failed or was cancelled is not
        asked for again until something that it depends on changes.

        Parameters
        ----------
        mark : hashable
            Stands for `points` where these are gathered anew each time.
        """
        project = self.controller.project
        known = project.known_field(scan, field)
        if known is not None and known.covers(points):
            return True
        spec = fingerprint(project.catalogue(scan), field, project.subject(scan))
        wanted = (Same(project), scan, spec, Same(points) if mark is None else mark)
        if self._asked.get(field) != wanted:
            self._asked[field] = wanted
            self.controller.want(scan, field, points)
        return False

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        """Catch up with what happened while nobody looked."""
        super().showEvent(event)
        if self._stale:
            self._refresh_if_seen()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Follow the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self.restyle()

    def _on_view(self, _: object) -> None:
        self.refresh_soon()

    def _refresh_if_seen(self) -> None:
        if self._stale and self.isVisible():
            self._stale = False
            self.refresh()


class Column(QScrollArea):
    """Content that scrolls up and down, and is never narrower than it needs."""

    def __init__(self, content: QWidget, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setWidget(content)
        self._content = content

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """As wide as the content and its scroll bar."""
        bar = self.verticalScrollBar().sizeHint().width()
        width = self._content.minimumSizeHint().width() + bar
        return QSize(width, super().minimumSizeHint().height())

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Follow the content when it becomes wider."""
        if event.type() == QEvent.Type.LayoutRequest:
            self.updateGeometry()
        return super().eventFilter(watched, event)


def make_scrolling(content: QWidget, panel: QWidget) -> None:
    """Fill a panel with content that scrolls when the panel is lower than it."""
    layout = QVBoxLayout(panel)
    layout.setContentsMargins(0, 0, 0, 0)
    layout.addWidget(Column(content, panel))

"""The tool bar: what is used all the time, in the order in which it is used."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QToolBar, QToolButton, QWidget

from widgets.actions import ActionTable, RowAction
from widgets.colour_by import ColourBy

Style = Qt.ToolButtonStyle


class Segments(QWidget):
    """Actions side by side as one control, of which one is chosen."""

    def __init__(self, title: str, actions: list[RowAction], parent: QWidget) -> None:
        super().__init__(parent)
        self.setAccessibleName(title)
        self._row = row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        self.buttons = [self._button(action) for action in actions]
        places = ["first", *["middle"] * (len(actions) - 2), "last"]
        for button, place in zip(self.buttons, places, strict=True):
            button.setProperty("segment", place)
            row.addWidget(button)

    def set_compact(self, on: bool) -> int:
        """Show icons alone, or icons with text; give the width that this takes."""
        for button in self.buttons:
            button.setToolButtonStyle(
                Style.ToolButtonIconOnly if on else Style.ToolButtonTextBesideIcon
            )
        self._row.invalidate()
        return self.sizeHint().width()

    def _button(self, action: RowAction) -> QToolButton:
        button = QToolButton(self)
        button.setDefaultAction(action)
        button.setAccessibleName(action.iconText())
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        return button


class MainBar(QToolBar):
    """Leaves words out, the least needed first, when the window is too narrow for them."""

    def __init__(self, table: ActionTable, colour_by: ColourBy, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("bar")
        self.setWindowTitle(self.tr("Tool bar"))
        self.setMovable(False)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        self.setToolButtonStyle(Style.ToolButtonIconOnly)
        self._label = QLabel(self.tr("Colour by"), self)
        self._label.setBuddy(colour_by)
        self._segments = [
            Segments(self.tr("Mouse tool"), table.in_bar("tool"), self),
            Segments(self.tr("What the lasso does"), table.in_bar("purpose"), self),
            Segments(self.tr("What the lasso reaches"), table.in_bar("reach"), self),
        ]
        self._widths: list[int] = []
        self._fill(table, colour_by)
        self._measure()

    def _fill(self, table: ActionTable, colour_by: ColourBy) -> None:
        self.addActions(table.in_bar("file"))
        self.addActions(table.in_bar("history"))
        self.addSeparator()
        for segments in self._segments:
            self.addWidget(segments)
            self.addSeparator()
        self.addWidget(self._label)
        self.addWidget(colour_by)
        self.addSeparator()
        self.addActions(table.in_bar("look"))

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        """Choose words or no words by the room there is."""
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """A new font or style needs other room."""
        super().changeEvent(event)
        if event.type() in (QEvent.Type.FontChange, QEvent.Type.StyleChange) and self._widths:
            self._measure()

    def _measure(self) -> None:
        """Find out how wide the bar is when ever more of its segments have lost their words."""
        em = self.fontMetrics().height()
        self.setIconSize(QSize(round(1.35 * em), round(1.35 * em)))
        with_words = [segments.set_compact(False) for segments in self._segments]
        layout = self.layout()
        if layout is not None:
            layout.invalidate()
        self._widths = [self.sizeHint().width()]
        for segments in self._by_worth():
            spared = with_words[self._segments.index(segments)] - segments.set_compact(True)
            self._widths.append(self._widths[-1] - spared)
        self._fit()

    def _fit(self) -> None:
        fitting = (n for n, width in enumerate(self._widths) if width <= self.width())
        wordless = next(fitting, len(self._segments))
        for number, segments in enumerate(self._by_worth()):
            segments.set_compact(number < wordless)

    def _by_worth(self) -> list[Segments]:
        tool, purpose, reach = self._segments
        return [tool, reach, purpose]

"""Text to read: the guide, the list of keys, what this program is."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QCoreApplication, Qt, QUrl
from PySide6.QtGui import QImage, QTextDocument
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QTextBrowser, QVBoxLayout, QWidget

from widgets.icons import find_resource


class Page(QTextBrowser):
    """Markdown whose pictures are no wider than the page."""

    def __init__(self, width: int, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._width = width

    def loadResource(self, kind: int, name: QUrl | str) -> Any:  # noqa: N802
        """Load a picture, made small enough to fit."""
        if kind != QTextDocument.ResourceType.ImageResource:
            return super().loadResource(kind, name)
        picture = QImage(self.document().baseUrl().resolved(QUrl(name)).toLocalFile())
        if picture.width() <= self._width:
            return picture
        return picture.scaledToWidth(self._width, Qt.TransformationMode.SmoothTransformation)


class GuideDialog(QDialog):
    """Shows Markdown, beside the window rather than in front of it."""

    def __init__(self, title: str, markdown: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setModal(False)
        self.setWindowTitle(title)
        em = self.fontMetrics().height()
        self.page = Page(38 * em, self)
        self.page.setOpenExternalLinks(True)
        self.page.document().setDocumentMargin(self.fontMetrics().height())
        self.page.document().setBaseUrl(QUrl.fromLocalFile(f"{find_resource('docs')}/"))
        self.page.setMarkdown(markdown)
        self.page.setAccessibleName(title)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close, self)
        buttons.rejected.connect(self.close)
        back = buttons.addButton(self.tr("Back"), QDialogButtonBox.ButtonRole.ActionRole)
        back.clicked.connect(self.page.backward)
        back.hide()
        self.page.backwardAvailable.connect(back.setVisible)
        layout = QVBoxLayout(self)
        layout.addWidget(self.page)
        layout.addWidget(buttons)
        self.resize(46 * em, 44 * em)

    @classmethod
    def of_guide(cls, parent: QWidget | None = None) -> GuideDialog:
        """The user guide, and the pages beside it that it links to."""
        dialog = cls(QCoreApplication.translate("GuideDialog", "Leafscope guide"), "", parent)
        # As a source, not as text: links then have a place to start from, and to come back to.
        dialog.page.setSource(QUrl.fromLocalFile(str(find_resource("docs/guide.md"))))
        return dialog

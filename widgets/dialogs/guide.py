"""Text to read: the guide, the list of keys, what this program is."""

from __future__ import annotations

from PySide6.QtCore import QCoreApplication, Qt, QUrl
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QTextBrowser, QVBoxLayout, QWidget

from widgets.icons import find_resource


class GuideDialog(QDialog):
    """Shows Markdown, beside the window rather than in front of it."""

    def __init__(self, title: str, markdown: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setModal(False)
        self.setWindowTitle(title)
        self.page = QTextBrowser(self)
        self.page.setOpenExternalLinks(True)
        self.page.document().setDocumentMargin(self.fontMetrics().height())
        self.page.document().setBaseUrl(QUrl.fromLocalFile(f"{find_resource('docs')}/"))
        self.page.setMarkdown(markdown)
        self.page.setAccessibleName(title)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close, self)
        buttons.rejected.connect(self.close)
        layout = QVBoxLayout(self)
        layout.addWidget(self.page)
        layout.addWidget(buttons)
        em = self.fontMetrics().height()
        self.resize(42 * em, 36 * em)

    @classmethod
    def of_guide(cls, parent: QWidget | None = None) -> GuideDialog:
        """The user guide."""
        text = find_resource("docs/guide.md").read_text(encoding="utf-8")
        title = QCoreApplication.translate("GuideDialog", "Leafscope guide")
        return cls(title, text, parent)

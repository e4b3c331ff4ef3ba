"""Which mouse tool is armed, and what the lasso is for. Nothing of it is in the document."""

from __future__ import annotations

from typing import Literal

from PySide6.QtCore import QObject, Signal

from app.model.selection import LassoMode
from widgets.leaf_work import Purpose

ToolName = Literal["navigate", "lasso", "rectangle", "pick"]


class Tools(QObject):
    """The user's choice of tool; tool bar and 3-D view follow it.

    Signals
    -------
    changed()
    """

    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.tool: ToolName = "navigate"
        self.purpose: Purpose = "select"
        self.mode: LassoMode = "visible"

    def arm(self, tool: ToolName) -> None:
        """Give the left mouse button to a tool."""
        self.tool = tool
        self.changed.emit()

    def use_lasso_to(self, purpose: Purpose) -> None:
        """Choose what lasso and rectangle do, and take one into the hand."""
        self.purpose = purpose
        self.arm("rectangle" if self.tool == "rectangle" else "lasso")

    def reach(self, mode: LassoMode) -> None:
        """Choose whether a lasso also takes what is hidden."""
        self.mode = mode
        self.changed.emit()

    def toggle_reach(self) -> None:
        """Visible points only, or all the way through."""
        self.reach("visible" if self.mode == "through" else "through")

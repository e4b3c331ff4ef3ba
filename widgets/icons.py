"""Icons in the colours of the palette, and files that come with the program."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from PySide6.QtGui import QIcon, QPalette
from PySide6.QtWidgets import QApplication


def draw_icon(name: str, role: QPalette.ColorRole = QPalette.ColorRole.ButtonText) -> QIcon:
    """A symbol of Phosphor (``ph.leaf``) or Material (``mdi6.lasso``) in the palette's colour.

    It keeps the colours of this moment: draw it anew when the theme changes.
    """
    import qtawesome

    palette = QApplication.palette()
    disabled = palette.color(QPalette.ColorGroup.Disabled, QPalette.ColorRole.ButtonText)
    icon: QIcon = qtawesome.icon(name, color=palette.color(role), color_disabled=disabled)
    return icon


def load_mark() -> QIcon:
    """The program's own mark."""
    return QIcon(str(find_resource("icons/leafscope.svg")))


def find_resource(name: str) -> Path:
    """A file that comes with the program, e.g. ``docs/guide.md``."""
    return Path(str(files("resources"))) / name

"""Light and dark: palette and style sheet, by the user's choice or the system's."""

from __future__ import annotations

import re
from dataclasses import dataclass

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QApplication

from app.model.view_state import Theme
from widgets.icons import find_resource
from widgets.style_sheet import SHEET

Role = QPalette.ColorRole
SCHEMES = {
    "system": Qt.ColorScheme.Unknown,
    "light": Qt.ColorScheme.Light,
    "dark": Qt.ColorScheme.Dark,
}


@dataclass(frozen=True, slots=True)
class Colours:
    """Colours of one theme; text on its ground has a contrast of 4.5 or more."""

    window: str
    base: str
    raised: str
    hover: str
    line: str
    border: str
    text: str
    faint: str
    disabled: str
    accent: str
    on_accent: str
    soft: str
    link: str
    notice: str
    warning: str
    error: str
    fault: str


LIGHT = Colours(
    window="#f3f5f6", base="#ffffff", raised="#fbfcfc", hover="#e6eaec", line="#d6dbdf",
    border="#858f99", text="#1c2227", faint="#56606a", disabled="#949da6", accent="#22714a",
    on_accent="#ffffff", soft="#d8ebe0", link="#1a6a9c", notice="#e3eff8", warning="#fdf0d2",
    error="#fbe3e0", fault="#a8261b",
)  # fmt: skip
DARK = Colours(
    window="#22272d", base="#191d22", raised="#2a3037", hover="#353c45", line="#3a424b",
    border="#77838f", text="#e7ebee", faint="#a8b2bc", disabled="#69737d", accent="#6cc494",
    on_accent="#0e1a14", soft="#24463a", link="#7cc0ea", notice="#20394c", warning="#47391a",
    error="#4f2a28", fault="#ff9c8f",
)  # fmt: skip


class ThemeSwitch(QObject):
    """Gives the application its palette and tells who has colours of their own.

    Signals
    -------
    changed(bool)
        Whether it is dark now.
    """

    changed = Signal(bool)

    def __init__(self, application: QApplication) -> None:
        super().__init__(application)
        self._application = application
        self.choice: Theme = "system"
        self.dark = False
        self.apply("system")
        application.styleHints().colorSchemeChanged.connect(self._refresh)

    def apply(self, choice: Theme) -> None:
        """Choose light, dark, or what the system wants."""
        self.choice = choice
        self._application.styleHints().setColorScheme(SCHEMES[choice])
        self._refresh()

    @property
    def colours(self) -> Colours:
        """The colours in use."""
        return DARK if self.dark else LIGHT

    def _refresh(self) -> None:
        system = self._application.styleHints().colorScheme() == Qt.ColorScheme.Dark
        # A system without an opinion answers Unknown whatever was asked for.
        self.dark = system if self.choice == "system" else self.choice == "dark"
        self._application.setPalette(make_palette(self.colours))
        self._application.setStyleSheet(make_sheet(self.colours))
        self.changed.emit(self.dark)


def make_palette(colours: Colours) -> QPalette:
    """The palette of a theme."""
    palette = QPalette()
    roles = {
        Role.Window: colours.window,
        Role.WindowText: colours.text,
        Role.Base: colours.base,
        Role.AlternateBase: colours.raised,
        Role.ToolTipBase: colours.raised,
        Role.ToolTipText: colours.text,
        Role.PlaceholderText: colours.faint,
        Role.Text: colours.text,
        Role.Button: colours.raised,
        Role.ButtonText: colours.text,
        Role.BrightText: colours.on_accent,
        Role.Highlight: colours.accent,
        Role.HighlightedText: colours.on_accent,
        Role.Accent: colours.accent,
        Role.Link: colours.link,
        Role.LinkVisited: colours.link,
        Role.Light: colours.raised,
        Role.Midlight: colours.hover,
        Role.Mid: colours.line,
        Role.Dark: colours.border,
        Role.Shadow: colours.border,
    }
    for role, colour in roles.items():
        palette.setColor(role, QColor(colour))
    for role in (Role.WindowText, Role.Text, Role.ButtonText):
        palette.setColor(QPalette.ColorGroup.Disabled, role, QColor(colours.disabled))
    palette.setColor(QPalette.ColorGroup.Disabled, Role.Highlight, QColor(colours.line))
    return palette


def make_sheet(colours: Colours) -> str:
    """The style sheet of a theme."""
    tick = "light" if colours is LIGHT else "dark"
    sheet = SHEET.replace("@check;", find_resource(f"icons/check-{tick}.svg").as_posix())
    for name in Colours.__slots__:
        sheet = re.sub(rf"@{name}\b", getattr(colours, name), sheet)
    return sheet

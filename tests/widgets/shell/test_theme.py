"""Both themes can be read."""

from __future__ import annotations

import pytest
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QApplication

from widgets.theme import DARK, LIGHT, Colours, ThemeSwitch, make_sheet

GROUNDS = ("window", "base", "raised", "hover", "soft", "notice", "warning", "error")


def luminance(colour: str) -> float:
    """Relative luminance after WCAG 2."""
    parts = QColor(colour).getRgbF()[:3]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(first: str, second: str) -> float:
    light, dark = sorted((luminance(first), luminance(second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("colours", [LIGHT, DARK], ids=["light", "dark"])
def test_text_has_contrast(colours: Colours) -> None:
    for ground in GROUNDS:
        assert contrast(colours.text, getattr(colours, ground)) >= 7.0, ground
    for ground in ("window", "base", "raised"):
        assert contrast(colours.faint, getattr(colours, ground)) >= 4.5, ground
        assert contrast(colours.link, getattr(colours, ground)) >= 4.5, ground
        assert contrast(colours.border, getattr(colours, ground)) >= 3.0, ground
        assert contrast(colours.accent, getattr(colours, ground)) >= 3.0, ground
    assert contrast(colours.on_accent, colours.accent) >= 4.5


@pytest.mark.parametrize("colours", [LIGHT, DARK], ids=["light", "dark"])
def test_sheet_names_no_colour_that_a_theme_lacks(colours: Colours) -> None:
    assert "@" not in make_sheet(colours)


def test_switch_changes_the_palette_and_tells(qapp: QApplication) -> None:
    theme = ThemeSwitch(qapp)
    told: list[bool] = []
    theme.changed.connect(told.append)
    theme.apply("dark")
    assert qapp.palette().color(QPalette.ColorRole.Window) == QColor(DARK.window)
    theme.apply("light")
    assert qapp.palette().color(QPalette.ColorRole.Window) == QColor(LIGHT.window)
    assert (True in told, told[-1]) == (True, False)
    theme.deleteLater()

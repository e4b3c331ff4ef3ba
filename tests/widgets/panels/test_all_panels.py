"""What every panel owes: a name, words for those who cannot see, the theme, patience."""

from __future__ import annotations

import pytest
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QHeaderView,
    QProgressBar,
    QScrollBar,
    QWidget,
)

from app.model.project import Project
from app.model.view_state import ViewState
from widgets.common.plots import Plot
from widgets.panels.angles import AnglesPanel
from widgets.panels.calibration import CalibrationPanel
from widgets.panels.correct import CorrectPanel
from widgets.panels.ghosts import GhostsPanel
from widgets.panels.history import HistoryPanel
from widgets.panels.index import IndexPanel
from widgets.panels.jobs import JobsPanel
from widgets.panels.leaves import LeavesPanel
from widgets.panels.phase_lab import PhaseLabPanel
from widgets.panels.pick import PickPanel
from widgets.panels.planner import PlannerPanel
from widgets.panels.scan_image import ScanImagePanel
from widgets.panels.scans import ScansPanel
from widgets.panels.series import SeriesPanel
from widgets.panels.wrinkles import WrinklesPanel

PANELS = (AnglesPanel, CalibrationPanel, CorrectPanel, GhostsPanel, HistoryPanel, IndexPanel,
          JobsPanel, LeavesPanel, PhaseLabPanel, PickPanel, PlannerPanel, ScanImagePanel,
          ScansPanel, SeriesPanel, WrinklesPanel)  # fmt: skip
SPEAKING = (QAbstractButton, QAbstractItemView, QAbstractSlider, QAbstractSpinBox, QComboBox,
            QProgressBar, Plot)  # fmt: skip
DARK = {"Window": "#22272d", "Base": "#191d22", "Text": "#e7ebee", "WindowText": "#e7ebee"}


@pytest.mark.parametrize("kind", PANELS)
def test_it_has_names_and_follows_theme_and_document(opened, kind, qtbot) -> None:
    panel = opened.show(kind)
    assert panel.objectName()
    assert panel.windowTitle()
    nameless = [w for kind in SPEAKING for w in panel.findChildren(kind) if is_nameless(w, panel)]
    assert not nameless
    palette = QPalette(panel.palette())
    for role, colour in DARK.items():
        palette.setColor(getattr(QPalette.ColorRole, role), QColor(colour))
    panel.setPalette(palette)
    for plot in panel.findChildren(Plot):
        assert plot.backgroundBrush().color() == QColor(DARK["Base"])
        assert plot.getAxis("left").textPen().color() == QColor(DARK["Text"])
    opened.controller.adopt(Project(), ViewState())
    qtbot.waitUntil(lambda: not opened.controller.bridge.jobs)


def is_nameless(widget: QWidget, panel: QWidget) -> bool:
    """Whether a reader would find no words; what Qt builds inside a widget is left out."""
    if isinstance(widget, (QScrollBar, QHeaderView)) or widget.isHidden():
        return False
    inside = isinstance(widget.parent(), (QComboBox, QAbstractItemView))
    if inside or widget.objectName().startswith("qt_") or widget.window() is not panel.window():
        return False
    text = widget.text() if isinstance(widget, QAbstractButton) else ""
    return not (widget.accessibleName() or text)


@pytest.mark.parametrize("kind", PANELS)
def test_a_panel_that_nobody_sees_computes_nothing(desk, kind, qtbot, make_scan) -> None:
    panel = kind(desk.controller, desk.work, desk.documents)
    qtbot.addWidget(panel)
    key = desk.open(make_scan())
    desk.make_halves(key)
    qtbot.wait(20)
    assert desk.controller.project.cache.computed(key) == {}
    assert not desk.controller.bridge.jobs

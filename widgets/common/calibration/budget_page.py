"""How sure a reflectance is and why not more: of the picked point, or as a leaf's mean."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QFormLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from app.core.arrays import Ints
from app.core.progress import Progress
from app.core.radiometry.profile import ChannelCalibration
from app.model.calibrated import calibrated_channels
from app.model.fields import Same
from app.services.error_budget import Explained, explain_reflectance
from widgets.common.aside import copy_aside
from widgets.common.calibration.budget_bars import BudgetBars
from widgets.common.calibration.profile_words import title_channel
from widgets.common.notice import Notice
from widgets.common.numbers import show_count, show_with_sd
from widgets.controller import Controller


class ChannelBudget(QWidget):
    """One channel: its reflectance in words, and the bars."""

    def __init__(self, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.text = QLabel(self)
        self.text.setWordWrap(True)
        self.bars = BudgetBars(self.tr("Error budget of {0}").format(title), self)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.text)
        layout.addWidget(self.bars)


class BudgetPage(QWidget):
    """Explains reflectances; asks for nothing while nobody sees it.

    Signals
    -------
    explained()
        There are new bars.
    """

    explained = Signal()

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._controller = controller
        self._point: tuple[str, int] | None = None
        self._explained_for: Hashable = None
        self.channels: dict[str, ChannelBudget] = {}
        self.notice = Notice(self)
        self.of = QComboBox(self)
        self.of.addItem(self.tr("Picked point"), "point")
        self.of.addItem(self.tr("Current leaf, its mean"), "leaf")
        self.of.setAccessibleName(self.tr("Error budget of"))
        self.of.setToolTip(self.tr("Click a point with the pick tool, or choose a leaf"))
        self.of.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.of.activated.connect(self.refresh)
        form = QFormLayout()
        form.addRow(self.tr("&Of"), self.of)
        self._column = QVBoxLayout()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addLayout(form)
        layout.addWidget(self.notice)
        layout.addLayout(self._column)

    def show_point(self, scan: str, row: int) -> None:
        """Take over which point was picked."""
        self._point = (scan, row)
        self.of.setCurrentIndex(self.of.findData("point"))
        if self.isVisible():
            self.refresh()

    def forget(self) -> None:
        """Let go of a point whose document is gone."""
        self._point = None

    def refresh(self, _: object = None) -> None:
        """Explain the point or leaf that is looked at, or say what is missing."""
        missing = self._find_missing()
        self.notice.say(missing)
        points, calibrations = self._points(), self._calibrations()
        self._dress([] if missing else calibrations)
        state, key = self._controller.scan, self._controller.current
        if missing or state is None or key is None or points is None:
            self._explained_for = None
            return
        mark = (
            key, points.tobytes(), Same(state.scan), Same(state.deleted),
            state.parameters.radiometry,
        )  # fmt: skip
        if mark != self._explained_for:
            self._explained_for = mark
            self._ask(key, points, mark)

    def _ask(self, key: str, points: Ints, mark: Hashable) -> None:
        aside, names = copy_aside(self._controller.project, key), list(self.channels)

        def work(progress: Progress) -> dict[str, Explained]:
            return {name: explain_reflectance(aside, key, name, points, progress) for name in names}

        def done(found: Mapping[str, Explained]) -> None:
            if mark == self._explained_for:
                for name, each in found.items():
                    self._show(name, each, len(points))
                self.explained.emit()

        self._controller.run(self.tr("Explaining reflectance"), work, done)

    def _points(self) -> Ints | None:
        key = self._controller.current
        if self.of.currentData() == "leaf":
            leaf = self._controller.project.state.leaves.get(self._controller.view.leaf or "")
            return leaf.members.indices if leaf is not None and leaf.scan == key else None
        at = self._point
        state = self._controller.scan
        if at is None or at[0] != key or state is None or at[1] >= len(state.scan):
            return None
        return np.array([at[1]])

    def _calibrations(self) -> list[ChannelCalibration]:
        state = self._controller.scan
        profile = None if state is None else state.parameters.profile
        if state is None or profile is None:
            return []
        there = {channel.name for channel in calibrated_channels(state.scan, profile)}
        return [c for c in profile.channels if c.name in there]

    def _find_missing(self) -> str:
        if not self._calibrations():
            return self.tr("There is no reflectance to explain yet: open or make a profile first.")
        if self._points() is not None:
            return ""
        if self.of.currentData() == "leaf":
            return self.tr("Choose a leaf of this scan in the Leaves panel.")
        return self.tr("Click a point in the picture with the pick tool.")

    def _dress(self, calibrations: list[ChannelCalibration]) -> None:
        """One set of bars per channel; they are made anew only when the channels differ."""
        names = [each.name for each in calibrations]
        if names == list(self.channels):
            return
        for widget in self.channels.values():
            self._column.removeWidget(widget)
            widget.deleteLater()
        self.channels = {}
        for each in calibrations:
            self.channels[each.name] = ChannelBudget(title_channel(each), self)
            self._column.addWidget(self.channels[each.name])

    def _show(self, name: str, found: Explained, points: int) -> None:
        widget = self.channels.get(name)
        if widget is None:
            return
        known, sure = found.n > 0, math.isfinite(found.sigma)
        told = any(math.isfinite(part) and part > 0.0 for part in found.parts.values())
        widget.bars.setVisible(known and told)
        if not known:
            why = ", ".join(f"{show_count(n)} {word}" for word, n in found.marks.items())
            widget.text.setText(self.tr("No {name}: {why}.").format(name=name, why=why))
            return
        value = show_with_sd(found.reflectance, found.sigma if sure else None)
        text = f"<b>{name} = {value}</b>"
        if points > 1:
            text += "<br>" + self.tr("mean of {n} points of {total}").format(
                n=show_count(found.n), total=show_count(points)
            )
        if not sure:
            text += "<br>" + self.tr("How sure it is, the profile does not tell.")
        widget.text.setText(text)
        if told:
            parts = {self._title(part): value for part, value in found.parts.items()}
            widget.bars.show_parts(parts, found.sigma)

    def _title(self, part: str) -> str:
        titles = {
            "noise": self.tr("noise"),
            "fit": self.tr("fit"),
            "panels": self.tr("panels"),
            "power": self.tr("power"),
            "range": self.tr("range"),
        }
        return titles.get(part, part)

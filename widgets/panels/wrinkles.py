"""Wrinkles: how far each part of a leaf is turned away from the leaf's plane."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QMenu, QPushButton, QVBoxLayout, QWidget

from app.model.events import EVERYTHING, Change
from app.model.leaf import Leaf
from app.model.wrinkle_fields import DELTA, SIGNIFICANCE
from app.services.wrinkles.measure import LeafWrinkles
from widgets.common.notice import Notice
from widgets.common.numbers import show_count
from widgets.common.panel import Column, Panel
from widgets.common.wrinkles.busy_row import BusyRow
from widgets.common.wrinkles.export import WrinkleExport
from widgets.common.wrinkles.leaf_page import LeafPage
from widgets.common.wrinkles.measuring import Measured, Measuring
from widgets.common.wrinkles.request_form import RequestForm
from widgets.common.wrinkles.table import WrinkleTable
from widgets.common.wrinkles.words import tell_claim
from widgets.dialogs.open_scan import FileDialogs


class WrinklesPanel(Panel):
    """What is asked, what may be claimed, all leaves, and the one that is looked at."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("wrinkles")
        self.setWindowTitle(self.tr("Wrinkles"))
        self.dialogs = FileDialogs(self)
        self._trouble = ""
        self._shown: tuple[Measured, str] | None = None
        self.measuring = Measuring(self.controller, self)
        self.notice = Notice(self)
        self.claim = QLabel(self)
        self.form = RequestForm(self)
        self.busy = BusyRow(self)
        self.remarks = QLabel(self)
        self.table = WrinkleTable(self)
        self.leaf_notice = Notice(self)
        self.page = LeafPage(self)
        self.colour_button = QPushButton(self.tr("&Colour the cloud by Δω"), self)
        self.export_button = QPushButton(self.tr("E&xport"), self)
        menu = QMenu(self.export_button)
        self.export = WrinkleExport(self.controller, menu)
        self.export_button.setMenu(menu)
        self._explain()
        self._lay_out()
        self._connect()

    @property
    def leaf(self) -> Leaf | None:
        """The leaf that is looked at, if it belongs to the current scan."""
        leaf = self.controller.project.state.leaves.get(self.controller.view.leaf or "")
        return leaf if leaf is not None and leaf.scan == self.controller.current else None

    def on_document(self, change: Change) -> None:
        """Let go of what belongs to a document that is gone."""
        if change is EVERYTHING:
            self.measuring.forget()
            self._shown = None
        super().on_document(change)

    def refresh(self) -> None:
        """Show what is known of the leaves, or what is missing for it."""
        state, scan = self.controller.scan, self.controller.current
        missing, action = self._find_missing()
        self.notice.say(missing, action)
        self.form.setVisible(not missing)
        self.busy.setVisible(not missing)
        measured = None if missing else self.measuring.find(scan)
        if state is not None and scan is not None and not missing:
            self.form.follow(state)
            self._tell_busy(scan, measured)
        self._show(scan, measured)

    def measure(self) -> None:
        """Measure all leaves of the scan in the background."""
        scan = self.controller.current
        if scan is not None and not self.form.lack:
            self._trouble = ""
            self.measuring.measure(scan, self.form.request())

    # What is shown

    def _find_missing(self) -> tuple[str, str]:
        state, scan = self.controller.scan, self.controller.current
        if state is None or scan is None:
            return self.tr("Open a scan to see how its leaves are wrinkled."), ""
        if not state.channels:
            return self.tr("This scan has no intensity, and wrinkles are read from it."), ""
        if state.scan.pose is None:
            return self.tr(
                "Nobody knows where the scanner stood, and without that there are no angles."
            ), self.tr("Set position…")
        if not self.controller.project.state.leaves_of(scan):
            return self.tr(
                "There is no leaf yet. Find them all, or draw around one with the lasso."
            ), self.tr("Find leaves")
        return "", ""

    def _tell_busy(self, scan: str, measured: Measured | None) -> None:
        lack = self.form.lack
        words = lack or self._trouble
        if not words and self.measuring.is_stale(scan, self.form.request()):
            words = self.tr("⚠ Something has changed since: measure again.")
        self.busy.show_state(self.measuring.busy, words)
        self.busy.button.setEnabled(not self.measuring.busy and not lack)
        said = [] if measured is None else list(measured.found.warnings)
        if said and self.controller.project.state.scan(scan).parameters.beam is None:
            said.append(self.tr("Give the beam under Scan ▸ Incidence angles."))
        self.remarks.setText("\n".join(said))

    def _show(self, scan: str | None, measured: Measured | None) -> None:
        for part in (self.claim_box, self.table, self.page, self.colour_button,
                     self.export_button, self.leaf_notice):  # fmt: skip
            part.setVisible(measured is not None)
        self.remarks.setVisible(measured is not None and bool(self.remarks.text()))
        if measured is None or scan is None:
            self._shown = None
            self.export.offer((), None, ())
            return
        leaves = self.controller.project.state.leaves_of(scan)
        current = "" if self.leaf is None else self.leaf.key
        rows = {leaf.key: measured.rows[leaf.key] for leaf in leaves if leaf.key in measured.rows}
        self.table.show_leaves(leaves, rows, current)
        found = measured.leaves.get(current)
        self._show_leaf(measured, found)
        self.claim.setText(self._tell_claim(measured, found))
        named = [{"scan": scan, **row} for row in rows.values()]
        self.export.offer(named, found, tuple(measured.leaves.values()))
        self.colour_button.setChecked(self.controller.view.colour in (DELTA, SIGNIFICANCE))

    def _show_leaf(self, measured: Measured, found: LeafWrinkles | None) -> None:
        if found is None:
            self.leaf_notice.say(
                self.tr("Choose a leaf in the table.") if self.leaf is None
                else self.tr("This leaf is newer than the measurement: measure again.")
            )  # fmt: skip
        elif found.judged is None:
            self.leaf_notice.say(f"{found.leaf.name}: {found.refusal}")
        else:
            self.leaf_notice.say("")
            if self._shown != (measured, found.leaf.key):
                self._shown = (measured, found.leaf.key)
                self.page.show_leaf(found, measured.rows[found.leaf.key])
        self.page.setVisible(found is not None and found.judged is not None)

    def _tell_claim(self, measured: Measured, found: LeafWrinkles | None) -> str:
        """What may be claimed of this leaf; without one, of the first that has a curve."""
        every = (found, *measured.leaves.values())
        known = (each.calibration for each in every if each is not None)
        first = next((calibration for calibration in known if calibration is not None), None)
        if first is None:
            return self.tr("Nothing can be said of any of the {n} leaves.").format(
                n=show_count(len(measured.leaves))
            )
        return tell_claim(first)

    # What the user does

    def _on_notice(self) -> None:
        scan, state = self.controller.current, self.controller.scan
        if scan is None or state is None:
            return
        if state.scan.pose is None:
            self.origin_asked.emit(scan)
        else:
            self.work.find_all()

    def _on_refused(self, sentence: str) -> None:
        self._trouble = sentence
        self.refresh_soon()

    def _on_choice(self) -> None:
        self._trouble = ""
        self.refresh_soon()

    def _choose(self, key: str) -> None:
        self.controller.look(leaf=key)

    def _on_colour(self, wanted: bool) -> None:
        field = DELTA if self.page.views.shown == "delta" else SIGNIFICANCE
        self.controller.look(colour=field if wanted else self._other_colour())

    def _on_quantity(self, _: int) -> None:
        if self.colour_button.isChecked():
            self._on_colour(True)

    def _other_colour(self) -> str:
        state = self.controller.scan
        channels = () if state is None else state.channels
        return channels[0].name if channels else ""

    def _ask_table(self) -> None:
        self.dialogs.ask_file(
            self.tr("A goniometer table: angle, value"), ".csv", self.form.source.take_file, self
        )

    def _ask_file(self, word: str, suffix: str) -> None:
        state = self.controller.scan
        stem = "scan" if state is None else Path(state.scan.name).stem
        suggested = self.dialogs.folder / f"{stem}-{word}{suffix}"
        self.dialogs.ask_save(suggested, self.export.write, self)

    # How it looks

    def _explain(self) -> None:
        self.colour_button.setCheckable(True)
        self.colour_button.setToolTip(
            self.tr("The 3-D view shows what the map shows: Δω, or Δω over its σ")
        )
        self.export_button.setToolTip(self.tr("The table of all leaves, and figures"))
        for label in (self.claim, self.remarks):
            label.setWordWrap(True)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.claim.setAccessibleName(self.tr("What may be claimed"))
        self.remarks.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        self.claim_box = QFrame(self)
        self.claim_box.setProperty("notice", "info")

    def _lay_out(self) -> None:
        inner = QVBoxLayout(self.claim_box)
        inner.addWidget(self.claim)
        buttons = QHBoxLayout()
        buttons.addWidget(self.colour_button)
        buttons.addStretch(1)
        buttons.addWidget(self.export_button)
        content = QWidget(self)
        column = QVBoxLayout(content)
        for part in (self.notice, self.form, self.busy, self.table, self.leaf_notice, self.page,
                     self.remarks):  # fmt: skip
            column.addWidget(part)
        column.addLayout(buttons)
        column.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        # Outside what scrolls: the claim is seen with whatever is looked at.
        layout.addWidget(self.claim_box)
        layout.addWidget(Column(content, self), 1)

    def _connect(self) -> None:
        self.notice.clicked.connect(self._on_notice)
        self.form.changed.connect(self._on_choice)
        self.form.source.file_asked.connect(self._ask_table)
        self.busy.asked.connect(self.measure)
        self.busy.cancelled.connect(self.measuring.cancel)
        self.measuring.changed.connect(self.refresh_soon)
        self.measuring.refused.connect(self._on_refused)
        self.measuring.progressed.connect(self.busy.show_progress)
        self.table.chosen.connect(self._choose)
        self.colour_button.clicked.connect(self._on_colour)
        self.page.views.tabs.currentChanged.connect(self._on_quantity)
        self.export.file_asked.connect(self._ask_file)

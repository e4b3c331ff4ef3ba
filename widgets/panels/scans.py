"""Scans: what is open, what is shown, and the facts of the scan that is worked on."""

from __future__ import annotations

import msgspec
from PySide6.QtCore import QItemSelectionModel, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QGridLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.model.leaf import Sample
from app.model.operations import CloseScan, PutSample
from app.model.scan import Channel, Pose, Scan
from app.model.state import next_key
from widgets.common.fact_grid import FactGrid
from widgets.common.fact_table import FactTable
from widgets.common.notice import Notice
from widgets.common.numbers import show_count, show_number
from widgets.common.panel import Panel, make_scrolling
from widgets.common.scan_tree import ScanTree

MOST_CHANNEL_LINES = 8


class ScansPanel(Panel):
    """The open scans, and below them where the current one comes from.

    Signals
    -------
    channel_asked(str, str)
        The user wants to name a channel: scan and channel.
    """

    channel_asked = Signal(str, str)

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("scans")
        self.setWindowTitle(self.tr("Scans"))
        self.notice = Notice(self)
        self.tree = ScanTree(self)
        self.group_button = QPushButton(self.tr("&Group as sample"), self)
        self.ungroup_button = QPushButton(self.tr("&Ungroup"), self)
        self.close_button = QPushButton(self.tr("&Close scan"), self)
        self.facts = FactGrid(self)
        self.origin_button = QPushButton(self.tr("Set &position…"), self)
        titles = (self.tr("Channel"), self.tr("λ (nm)"), self.tr("Kind"))
        self.channels = FactTable(self.tr("Channels of the current scan"), titles, self)
        self.channel_button = QPushButton(self.tr("&Edit channel…"), self)
        self.warnings = QLabel(self)
        self._dress()
        self._arrange()
        self._connect()

    def _dress(self) -> None:
        self.channels.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.warnings.setWordWrap(True)
        self.group_button.setToolTip(
            self.tr("Two or more scans of the same sample, taken by different instruments")
        )
        self.close_button.setToolTip(self.tr("Take the scan off the table; undo brings it back"))
        self.channel_button.setToolTip(self.tr("Say which wavelength and what kind of number"))

    def _arrange(self) -> None:
        buttons = QGridLayout()
        buttons.addWidget(self.group_button, 0, 0)
        buttons.addWidget(self.ungroup_button, 0, 1)
        buttons.addWidget(self.close_button, 1, 0)
        self.body = QWidget(self)
        inner = QVBoxLayout(self.body)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.addWidget(self.tree, 1)
        inner.addLayout(buttons)
        inner.addWidget(self.facts)
        inner.addWidget(self.origin_button, 0, Qt.AlignmentFlag.AlignLeft)
        inner.addWidget(self.channels)
        inner.addWidget(self.channel_button, 0, Qt.AlignmentFlag.AlignLeft)
        inner.addWidget(self.warnings)
        content = QWidget(self)
        layout = QVBoxLayout(content)
        layout.addWidget(self.notice)
        layout.addWidget(self.body, 1)
        layout.addStretch(0)
        make_scrolling(content, self)

    def _connect(self) -> None:
        self.tree.current_asked.connect(self._on_current)
        self.tree.hiding_asked.connect(self._on_hidden)
        self.tree.name_asked.connect(self._on_name)
        self.tree.itemSelectionChanged.connect(self._enable)
        self.group_button.clicked.connect(self.group)
        self.ungroup_button.clicked.connect(self.ungroup)
        self.close_button.clicked.connect(self.close_scans)
        self.origin_button.clicked.connect(self._on_origin)
        self.channel_button.clicked.connect(self._on_channel)
        self.channels.cellDoubleClicked.connect(self._on_channel)
        self.channels.itemSelectionChanged.connect(self._enable)

    def refresh(self) -> None:
        """Show the scans and the facts of the current one."""
        state, view = self.controller.project.state, self.controller.view
        is_open = any(not scan.closed for scan in state.scans.values())
        self.notice.say(
            "" if is_open else self.tr("No scan is open. Drop files here, or press Ctrl+O.")
        )
        self.body.setVisible(is_open)
        self.tree.show_scans(state, view.hidden, self.controller.current)
        current = self.controller.scan
        for widget in (self.facts, self.origin_button, self.channels, self.channel_button):
            widget.setVisible(current is not None)
        if current is not None:
            self._show_scan(current.scan)
        else:
            self.warnings.hide()
        self._enable()

    def _show_scan(self, scan: Scan) -> None:
        self.facts.show_facts(
            (
                (self.tr("File"), self._tell_file(scan)),
                (self.tr("Grid"), self._tell_grid(scan)),
                (self.tr("Scanner"), self._tell_pose(scan.pose)),
            )
        )
        self._show_channels(scan.channels)
        self.warnings.setText("\n".join(f"⚠ {warning}" for warning in scan.warnings))
        self.warnings.setVisible(bool(scan.warnings))

    def _tell_file(self, scan: Scan) -> str:
        if scan.source is None:
            return self.tr("not from a file")
        return scan.source.path.replace("\\", "/").rpartition("/")[2]

    def _tell_grid(self, scan: Scan) -> str:
        if scan.grid is None:
            return self.tr("none: the points have no rows and columns")
        text = self.tr("{rows} rows × {columns} columns").format(
            rows=show_count(scan.grid.rows), columns=show_count(scan.grid.columns)
        )
        lost = len(scan.grid.no_return)
        if lost:
            text += self.tr(", {n} beams without echo").format(n=show_count(lost))
        return text

    def _tell_pose(self, pose: Pose | None) -> str:
        if pose is None:
            return self.tr("unknown (angles need it)")
        known_by = {
            "file": self.tr("from the file"),
            "given": self.tr("given by you"),
            "assumed": self.tr("assumed from the grid"),
        }[pose.known_by]
        x, y, z = (show_number(value, 3) for value in pose.position)
        return f"{x}; {y}; {z} m ({known_by})"

    def _show_channels(self, channels: tuple[Channel, ...]) -> None:
        table = self.channels
        kinds = {
            "DN": self.tr("DN, raw"),
            "dB": self.tr("dB"),
            "linear": self.tr("linear"),
            "reflectance": self.tr("reflectance"),
        }
        kept = table.currentRow()
        rows, tips = [], []
        for channel in channels:
            nm = channel.wavelength_nm
            wavelength = self.tr("unknown") if nm is None else f"{nm:g}"
            rows.append((channel.name, wavelength, kinds[channel.kind]))
            tips.append(channel.calibration or self.tr("as the file holds it"))
        table.show_rows(rows, tips)
        if channels:
            # Current, so that the button knows its channel, without shouting it.
            place = table.model().index(min(max(kept, 0), len(channels) - 1), 0)
            table.selectionModel().setCurrentIndex(
                place, QItemSelectionModel.SelectionFlag.NoUpdate
            )
        lines = min(max(len(channels), 1), MOST_CHANNEL_LINES)
        header = table.horizontalHeader().sizeHint().height()
        table.setFixedHeight(
            header + lines * table.verticalHeader().defaultSectionSize() + 2 * table.frameWidth()
        )

    def _enable(self) -> None:
        state = self.controller.project.state
        scans = [key for key in self.tree.selected if key in state.scans]
        grouped = [key for key in self._samples_of(self.tree.selected)]
        several = sum(not scan.closed for scan in state.scans.values()) > 1
        self.group_button.setVisible(several)
        self.ungroup_button.setVisible(several)
        self.group_button.setEnabled(len(scans) > 1)
        self.ungroup_button.setEnabled(bool(grouped))
        self.close_button.setEnabled(bool(scans) or self.controller.current is not None)
        self.channel_button.setEnabled(self.channels.currentRow() >= 0)

    def _samples_of(self, keys: list[str]) -> list[str]:
        return [
            key
            for key, sample in self.controller.project.state.samples.items()
            if key in keys or set(sample.scans) & set(keys)
        ]

    def group(self) -> None:
        """Make one sample of the selected scans."""
        state = self.controller.project.state
        scans = tuple(sorted(key for key in self.tree.selected if key in state.scans))
        if len(scans) > 1:
            key = next_key(state.samples, "sample")
            number = int(key.rpartition("-")[2])
            name = self.tr("Sample {n}").format(n=number)
            self.controller.do(PutSample(key, Sample(key, name, scans)))

    def ungroup(self) -> None:
        """Dissolve the samples of what is selected."""
        for key in self._samples_of(self.tree.selected):
            self.controller.do(PutSample(key, None))

    def close_scans(self) -> None:
        """Take the selected scans, or the current one, off the table."""
        state = self.controller.project.state
        keys = [key for key in self.tree.selected if key in state.scans]
        current = self.controller.current
        for key in keys or ([] if current is None else [current]):
            self.controller.do(CloseScan(key))
        left = [k for k, scan in self.controller.project.state.scans.items() if not scan.closed]
        if self.controller.current is None:
            self.controller.look(current=left[0] if left else None)

    def _on_current(self, key: str) -> None:
        if key != self.controller.view.current:
            self.controller.look(current=key)

    def _on_hidden(self, keys: tuple[str, ...]) -> None:
        self.controller.look(hidden=keys)

    def _on_name(self, key: str, name: str) -> None:
        sample = self.controller.project.state.samples.get(key)
        if sample is not None and name and name != sample.name:
            self.controller.do(PutSample(key, msgspec.structs.replace(sample, name=name)))

    def _on_origin(self) -> None:
        if self.controller.current is not None:
            self.origin_asked.emit(self.controller.current)

    def _on_channel(self) -> None:
        current, row = self.controller.scan, self.channels.currentRow()
        if current is not None and self.controller.current is not None and row >= 0:
            self.channel_asked.emit(self.controller.current, current.scan.channels[row].name)

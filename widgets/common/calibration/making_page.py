"""Make a profile: from panels drawn in scans, or from a table."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QPushButton, QVBoxLayout, QWidget

from app.core.progress import Progress
from app.model.leaf import Leaf
from app.model.project import Project
from app.model.scan import Channel, Scan
from app.services.beams import name_instrument
from app.services.calibrate import CalibrationReport, Naming, calibrate_table
from app.services.panel_columns import TableOptions
from app.services.panel_files import TableLook, look_at_table
from app.services.scan_panels import KnownPanel, SeenPanel, calibrate_panels, scale_of
from widgets.common.aside import copy_aside
from widgets.common.calibration.fit_view import FitView
from widgets.common.calibration.making_form import MakingForm
from widgets.common.calibration.panel_list import PanelList
from widgets.common.notice import Notice
from widgets.common.numbers import show_count
from widgets.controller import Controller

RAW = ("DN", "dB", "linear")
Plan = Callable[[Progress], tuple[CalibrationReport, tuple[SeenPanel, ...]]]


class MakingPage(QWidget):
    """Asks for panels and a model, has them fitted, shows what came of it.

    Signals
    -------
    table_asked()
        A file is wanted; `open_table` takes it.
    """

    table_asked = Signal()

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._controller = controller
        self._table: TableLook | None = None
        self._percent = False
        self._scan: Hashable = None
        self.form = MakingForm(self)
        self.panels = PanelList(self)
        self.notice = Notice(self)
        self.button = QPushButton(self.tr("&Calibrate"), self)
        self.fit = FitView(self)
        self.fit.hide()
        self.button.setProperty("primary", "true")
        self.button.setToolTip(self.tr("Fit the model to the panels; nothing is changed by it"))
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for widget in (self.form, self.panels, self.notice, self.button, self.fit):
            layout.addWidget(widget)
        self.form.changed.connect(self.refresh)
        self.form.table_asked.connect(self.table_asked)
        self.panels.edited.connect(self.refresh)
        self.notice.clicked.connect(self._divide_percent)
        self.button.clicked.connect(self.calibrate)

    def refresh(self) -> None:
        """Show channels and panels of what is chosen, and what is missing."""
        key, state = self._controller.current, self._controller.scan
        table = self.form.origin == "table"
        self.panels.setVisible(not table)
        self.form.offer_channels(self._raw_channels())
        self.form.ask_wavelength(self._lacks_wavelength())
        leaves = self._leaves()
        scans = self._controller.project.state.scans
        several = self.form.origin == "scans"
        names = {k: state.scan.name for k, state in scans.items()} if several else {}
        self.panels.show_leaves(leaves, names)
        if state is not None and key != self._scan:
            self._scan = key
            self.form.show_limits(*scale_of(state.scan))
        missing, action = self._find_missing(len(leaves))
        self.notice.say(missing, action)
        self.button.setEnabled(not missing)

    def forget(self) -> None:
        """Let go of what belongs to a document that is gone."""
        self._scan = None
        self.panels.forget()
        self.fit.show_report(None)

    def open_table(self, path: Path) -> None:
        """Look at a table of panels, in the background."""

        def done(look: TableLook) -> None:
            self._table, self._percent = look, False
            words = self.tr("{name}: {rows} rows, {n} panels, {m} scans; {channels}")
            self.form.show_table(
                words.format(
                    name=path.name, rows=show_count(look.rows), n=look.panels, m=look.scans,
                    channels=", ".join(filter(None, look.channels)) or self.tr("one channel"),
                )
            )  # fmt: skip
            self.refresh()

        self._controller.run(
            self.tr("Reading {0}").format(path.name), lambda _: look_at_table(path), done
        )

    def calibrate(self) -> None:
        """Fit the model in the background; what is shown stays until it is done."""
        work = self._plan()
        if work is None:
            return

        def done(found: tuple[CalibrationReport, tuple[SeenPanel, ...]]) -> None:
            report, seen = found
            self.panels.show_seen(seen)
            colours = self.panels.colours if seen else {}
            self.fit.show_report(report, sum(not each.usable for each in seen), colours)

        self._controller.run(self.tr("Calibrating"), work, done)

    def _plan(self) -> Plan | None:
        """What the worker is to do, free of the document."""
        form, channel = self.form, self._channel()
        model, wishes, nm = form.model, form.wishes, form.wavelength.value()
        naming = form.naming
        if form.origin == "table":
            look = self._table
            if look is None:
                return None
            given = nm if look.wavelength_missing else None
            options = TableOptions(wavelength_nm=given, percent=self._percent)
            return lambda progress: (
                calibrate_table(look.path, model.name, options, wishes, naming, progress), (),
            )  # fmt: skip
        key, state = self._controller.current, self._controller.scan
        if key is None or state is None:
            return None
        aside, panels = copy_aside(self._controller.project, key), self._known_panels()
        naming = self._name(naming, state.scan, len({panel.scan for panel in panels}))
        wanted = (channel, self._wavelength() or nm)
        return lambda progress: calibrate_panels(
            aside, panels, wanted, model, wishes, naming, progress
        )

    def _name(self, naming: Naming, scan: Scan, scans: int) -> Naming:
        """What a profile of the instrument that a scan names is called, where nobody said."""
        tool = name_instrument(scan)
        if tool is None:
            return naming
        told = Path(scan.name).stem if scans == 1 else self.tr("{0} scans").format(scans)
        return replace(naming, name=naming.name or f"{tool.title}, {told}", instrument=tool.name)

    def _known_panels(self) -> list[KnownPanel]:
        leaves, found = self._controller.project.state.leaves, []
        for key, entry in self.panels.entries.items():
            leaf, rho = leaves.get(key), entry.rho
            if leaf is not None and rho is not None:
                points = leaf.members.indices
                found.append(KnownPanel(leaf.scan, leaf.name, points, rho, entry.sigma))
        return found

    def _leaves(self) -> tuple[Leaf, ...]:
        project, key = self._controller.project, self._controller.current
        if self.form.origin == "scans":
            return tuple(
                leaf for scan in _open_scans(project) for leaf in project.state.leaves_of(scan)
            )
        return project.state.leaves_of(key) if key is not None else ()

    def _raw_channels(self) -> list[tuple[str, str]]:
        state = self._controller.scan
        channels = state.scan.channels if state is not None else ()
        return [(c.name, _title(c)) for c in channels if c.kind in RAW]

    def _channel(self) -> str:
        return str(self.form.channel.currentData() or "")

    def _wavelength(self) -> float | None:
        state, name = self._controller.scan, self._channel()
        channels = state.scan.channels if state is not None else ()
        return next((c.wavelength_nm for c in channels if c.name == name), None)

    def _find_missing(self, leaves: int) -> tuple[str, str]:
        form = self.form
        if form.origin == "table":
            return self._find_missing_of_table()
        if self._controller.scan is None:
            return self.tr("Open a scan of panels, or take a table."), ""
        if not self._channel():
            return self.tr(
                "This scan has no raw values to calibrate: its channels are reflectance already."
            ), ""
        if leaves == 0:
            return self.tr(
                "Draw around each panel with the lasso (Tools ▸ Lasso makes a leaf), then give "
                "its reflectance here."
            ), ""
        if self.panels.in_percent:
            return self.tr("{0} looks like percent, not like a fraction of 0 to 1.").format(
                ", ".join(f"{rho:g}" for rho in self.panels.in_percent)
            ), self.tr("They are percent")
        if not self.panels.entries:
            return self.tr("Give the reflectance of each leaf that lies on a panel."), ""
        return self._ask_wavelength(), ""

    def _find_missing_of_table(self) -> tuple[str, str]:
        look = self._table
        if look is None:
            return self.tr(
                "Choose a table with a row for each panel in each scan: its range, DN and "
                "reflectance."
            ), ""
        if look.looks_percent and not self._percent:
            return self.tr("A reflectance of {0} looks like percent, not like a fraction.").format(
                f"{look.brightest:g}"
            ), self.tr("They are percent")
        return self._ask_wavelength(), ""

    def _ask_wavelength(self) -> str:
        if self._lacks_wavelength() and self.form.wavelength.value() == 0.0:
            return self.tr("At which wavelength was this channel measured?")
        return ""

    def _lacks_wavelength(self) -> bool:
        if self.form.origin == "table":
            return self._table is not None and self._table.wavelength_missing
        return bool(self._channel()) and self._wavelength() is None

    def _divide_percent(self) -> None:
        if self.form.origin == "table":
            self._percent = True
            self.refresh()
        else:
            self.panels.divide_percent()


def _open_scans(project: Project) -> list[str]:
    return [key for key, state in project.state.scans.items() if not state.closed]


def _title(channel: Channel) -> str:
    nm = channel.wavelength_nm
    return channel.name if nm is None else f"{channel.name} ({nm:g} nm)"

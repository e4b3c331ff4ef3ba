"""Planner: what a scan will show of a leaf before it is made; footprints in the picture."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.core.errors import LeafscopeError
from app.core.progress import Progress
from app.model.leaf import Leaf
from app.services.beams import name_instrument
from app.services.jobs import Job
from app.services.plan_files import write_plan
from app.services.plan_leaf import measure_leaf, range_of
from app.services.plan_texts import list_assumptions, tell_range
from app.services.planning import Plan, PlanOrder, RangePlan, check_order, make_plan
from widgets.common.footprint_switch import FootprintSwitch
from widgets.common.notice import Notice
from widgets.common.numbers import show_number
from widgets.common.panel import Panel, make_scrolling
from widgets.common.plan_form import PlanForm
from widgets.common.plan_plot import PlanPlot
from widgets.common.plan_table import BINDS, PlanTable
from widgets.dialogs.open_scan import FileDialogs

PAUSE = 120  # milliseconds after the last change


class PlannerPanel(Panel):
    """Instrument and leaf to the left of the answer: a sentence, a plot and a table."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("planner")
        self.setWindowTitle(self.tr("Planner"))
        self.dialogs = FileDialogs(self)
        self.plan: Plan | None = None
        self._order: PlanOrder | None = None
        self._job: Job | None = None
        self._named: object = None
        self._pause = QTimer(self, singleShot=True, interval=PAUSE)
        self._pause.timeout.connect(self.refresh_soon)
        self.form = PlanForm(self)
        self.take_button = QPushButton(self.tr("&Take from the current leaf"), self)
        self.notice = Notice(self)
        self.sentence = QLabel(self)
        self.plot = PlanPlot(self)
        self.table = PlanTable(self)
        self.assumed = QLabel(self)
        self.table_button = QPushButton(self.tr("Save &table…"), self)
        self.figure_button = QPushButton(self.tr("Save fi&gure…"), self)
        self.switch = FootprintSwitch(self)
        self._explain()
        self._lay_out()
        self._connect()

    # What is shown

    def refresh(self) -> None:
        """Show the plan of what the form asks; work it out first if it is another one."""
        view, state = self.controller.view, self.controller.scan
        beam = None if state is None else state.parameters.beam
        self.switch.show_state(
            state is not None, view.show_footprints, view.footprint_step,
            beam != self.form.tool.beam,
        )  # fmt: skip
        self.take_button.setEnabled(self._leaf() is not None)
        self._follow_scan()
        order = self.form.order()
        if order == self._order:
            return
        self._order = order
        try:
            check_order(order)
        except LeafscopeError as error:
            self._show_trouble(str(error))
            return
        self._work_out(order)

    def take_point(self, scan: str, row: int) -> None:
        """The user picked a point: its range is the position."""
        state = self.controller.project.state.scans.get(scan)
        if state is not None and state.scan.pose is not None:
            self.form.take_position(range_of(state, row))

    def take_leaf(self) -> None:
        """Take range and size of the current leaf."""
        leaf = self._leaf()
        if leaf is None:
            return
        state = self.controller.project.state.scan(leaf.scan)
        try:
            seen = measure_leaf(state, leaf.members.indices)
        except LeafscopeError as error:
            self.controller.failed.emit(error)
            return
        self.form.take_leaf(seen.length, seen.width)
        self.form.take_position(seen.distance)
        self.controller.said.emit(
            self.tr("{0}: {1} × {2} mm at {3} m.").format(
                leaf.name, show_number(1000 * seen.length, 0), show_number(1000 * seen.width, 0),
                show_number(seen.distance, 2),
            )
        )  # fmt: skip

    def use_beam(self) -> None:
        """Give the scan the beam of the plan: footprints in the picture are made of it."""
        if self.controller.scan is not None:
            self.work.set_parameters(beam=self.form.tool.beam)

    def _leaf(self) -> Leaf | None:
        leaf = self.controller.project.state.leaves.get(self.controller.view.leaf or "")
        return leaf if leaf is not None and leaf.scan == self.controller.current else None

    def _follow_scan(self) -> None:
        """Take the instrument that a scan names, once for each scan."""
        state = self.controller.scan
        if state is None or state.scan is self._named:
            return
        self._named = state.scan
        known = name_instrument(state.scan)
        if known is not None:
            self.form.take_instrument(known.name)

    def _work_out(self, order: PlanOrder) -> None:
        if self._job is not None and self._job in self.controller.bridge.jobs:
            self._job.cancel()

        def work(progress: Progress) -> Plan:
            progress.report(0.0)
            return make_plan(order)

        def done(plan: Plan) -> None:
            if plan.order == self._order:
                self._show(plan)

        self._job = self.controller.run(self.tr("Planning"), work, done)

    def _show(self, plan: Plan) -> None:
        self.plan = plan
        here = self._row_here(plan)
        self.notice.say("")
        self.sentence.setText(tell_range(here))
        self.plot.show_plan(plan, here.range_m)
        self.table.show_plan(plan, here)
        self.assumed.setText(
            " ".join((self.tr("{0}: the limit that binds.").format(BINDS.strip()),
                      *list_assumptions(plan)[:2]))
        )  # fmt: skip
        self.body.show()

    def _show_trouble(self, text: str) -> None:
        self.plan = None
        self.notice.say(text)
        self.body.hide()

    def _row_here(self, plan: Plan) -> RangePlan:
        position = self.form.position.value()
        return min(plan.rows, key=lambda row: abs(row.range_m - position))

    # What the user does

    def _save(self, suffix: str) -> None:
        plan = self.plan
        if plan is None:
            return

        def write(path: Path) -> None:
            if suffix == ".csv":
                write_plan(plan, path, overwrite=True)  # the dialog has asked
            else:
                from app.services.plan_figure import draw_plan

                draw_plan(plan, path, overwrite=True)

        self.dialogs.ask_save(self.dialogs.folder / f"plan{suffix}", self._writer(write), self)

    def _writer(self, write: Callable[[Path], None]) -> Callable[[Path], None]:
        def save(path: Path) -> None:
            said = self.tr("{0} written.").format(path)
            self.controller.run(
                self.tr("Writing {0}").format(path.name),
                lambda _: write(path),
                lambda _: self.controller.said.emit(said),
            )

        return save

    def _save_table(self) -> None:
        self._save(".csv")

    def _save_figure(self) -> None:
        self._save(".pdf")

    def _toggle(self, on: bool) -> None:
        self.controller.look(show_footprints=on)

    def _space(self, every: int) -> None:
        self.controller.look(footprint_step=every)

    def _connect(self) -> None:
        self.form.changed.connect(self._pause.start)
        self.take_button.clicked.connect(self.take_leaf)
        self.table_button.clicked.connect(self._save_table)
        self.figure_button.clicked.connect(self._save_figure)
        self.switch.toggled.connect(self._toggle)
        self.switch.spaced.connect(self._space)
        self.switch.beam_asked.connect(self.use_beam)

    # How it looks

    def _explain(self) -> None:
        self.take_button.setToolTip(
            self.tr("Fill in range, length and width of the leaf that is chosen in Leaves")
        )
        self.table_button.setToolTip(self.tr("A row per range and angle, as CSV"))
        self.figure_button.setToolTip(self.tr("Footprint and largest angle, as PDF for print"))
        for label in (self.sentence, self.assumed):
            label.setWordWrap(True)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        font = self.sentence.font()
        font.setBold(True)
        self.sentence.setFont(font)
        self.assumed.setProperty("faint", "true")

    def _lay_out(self) -> None:
        usable = QLabel(self.tr("Usable is what keeps to:"), self)
        usable.setProperty("faint", "true")
        self.body = QWidget(self)
        inner = QVBoxLayout(self.body)
        inner.setContentsMargins(0, 0, 0, 0)
        for part in (self.sentence, self.plot, self.table):
            inner.addWidget(part)
        files = QHBoxLayout()
        files.addWidget(self.table_button)
        files.addWidget(self.figure_button)
        files.addStretch(1)
        inner.addLayout(files)
        inner.addWidget(self.assumed)
        content = QWidget(self)
        layout = QVBoxLayout(content)
        layout.addWidget(self.form)
        layout.addWidget(self.take_button, 0, Qt.AlignmentFlag.AlignLeft)
        layout.addWidget(usable)
        layout.addWidget(self.form.limits_form(content))
        layout.addWidget(self.notice)
        layout.addWidget(self.body)
        layout.addWidget(self.switch)
        layout.addStretch(1)
        make_scrolling(content, self)

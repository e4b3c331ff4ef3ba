"""Phase lab: intensity against incidence angle, and the curves through it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QSizePolicy, QVBoxLayout, QWidget

from app.core.errors import BadInput
from app.model.events import EVERYTHING, Change
from app.services.curves import channel_in_use
from app.services.lab.fit_table import each_leaf
from widgets.common.angular_points import NO_POINTS, STEP, AngularPoints
from widgets.common.curve_choice import CurveChoice, Target
from widgets.common.lab.brushing import Brushing
from widgets.common.lab.export_menu import ExportMenu
from widgets.common.lab.exporting import order_figure, report_fits
from widgets.common.lab.fitting import LabFits, name_samples
from widgets.common.lab.follow import CurveFollower
from widgets.common.lab.gathering import Gathering, Order, Wanted
from widgets.common.lab.own_formulas import OwnFormulas
from widgets.common.lab.pages import LabPages
from widgets.common.lab.plots_view import PlotsView
from widgets.common.lab.series import MOST_SERIES
from widgets.common.lab.subject import Subject
from widgets.common.lab.targets import build_series, choose_groups, find_missing, title_values
from widgets.common.lab.use_row import UseRow
from widgets.common.lab.using import CurveUse
from widgets.common.notice import Notice
from widgets.common.panel import Panel, make_scrolling
from widgets.dialogs.open_scan import FileDialogs


class PhaseLabPanel(Panel):
    """Choose points, channels and a model; see the curves, move them, fit them, use them."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("phase-lab")
        self.setWindowTitle(self.tr("Phase lab"))
        self.dialogs = FileDialogs(self)
        self._chosen: tuple[str, ...] = ()
        self._found: dict[Wanted, AngularPoints] = {}
        self.choice = CurveChoice(self)
        self.notice = Notice(self)
        self.plots = PlotsView(self)
        self.row = UseRow(self)
        self.pages = LabPages(self.controller, self.plots, self)
        self.fit_button, self.use_button = self.row.fit_button, self.row.use_button
        self.editor, self.in_use = self.pages.editor, self.row.in_use
        self.gathering = Gathering(self)
        self.fits = LabFits(self.controller, self)
        self.follower = CurveFollower(self.controller, self.choice, self.editor)
        self.brushing = Brushing(self.controller, self.work, self.plots.plot)
        self.formulas = OwnFormulas(self.controller, self.choice.models, self)
        self.export = ExportMenu(self.controller, self.plots.tools.menu)
        self.curve_use = CurveUse(
            self.controller, self.work, self.editor, self.follower, self._read_target
        )
        self._lay_out()
        self._connect()

    def choose_leaves(self, keys: Sequence[str]) -> None:
        """Take over which leaves are selected in the table."""
        self._chosen = tuple(keys)
        self.refresh_soon()

    @property
    def targets(self) -> tuple[Target, ...]:
        """What shall be fitted: each group of leaves in each ticked channel, that at work first."""
        scan, choice = self.controller.current, self.choice
        if scan is None:
            return ()
        groups = choose_groups(self.controller, choice.what, self._chosen)
        return tuple(
            Target(scan, group, channel, choice.model.name, choice.method)
            for channel in choice.channels
            for group in groups
        )

    @property
    def target(self) -> Target | None:
        """What the curve belongs to; None while something is missing."""
        targets = self.targets
        return targets[0] if targets else None

    @property
    def drawn_targets(self) -> tuple[Target, ...]:
        """What is drawn: for leaves apart, only the channel at work."""
        targets = self.targets
        if self.choice.what == "each":
            targets = tuple(each for each in targets if each.channel == targets[0].channel)
        return targets[:MOST_SERIES]

    def on_document(self, change: Change) -> None:
        """Let go of what belongs to a document that is gone."""
        if change is EVERYTHING:
            self.gathering.forget()
            self.pages.forget()
            self.follower.forget()
            self._found = {}
        super().on_document(change)

    def refresh(self) -> None:
        """Show points, curves and numbers for what is chosen."""
        scan, state = self.controller.current, self.controller.scan
        channels = state.channels if state is not None else ()
        in_use = channel_in_use(self.controller.project, scan) if scan and channels else ""
        self.choice.fill_channels(channels, in_use)
        self.formulas.offer()
        missing, action = find_missing(self, self.controller, self.choice.what, self.targets)
        self.notice.say(missing, action)
        self.plots.setVisible(not missing)
        self.pages.setVisible(not missing)
        self.choice.setVisible(state is not None)
        self.row.setVisible(state is not None)
        self.fit_button.setEnabled(not missing)
        if missing:
            self._found = {}
            self.brushing.follow(None, NO_POINTS)
        else:
            self.follower.follow(self._read_target)
            self._gather()
        self._tell_use()

    def restyle(self) -> None:
        """Draw in the new colours."""
        self.plots.plot.restyle()

    def fit(self) -> None:
        """Fit the model to all that is chosen, as one step."""
        self.fits.fit(self.targets, self.choice.model)

    def _read_target(self) -> Target | None:
        return self.target

    def _gather(self) -> None:
        """Have the points read that are drawn; draw them when they are there."""
        targets = self.drawn_targets
        method = self.choice.method
        width = method.width if method.to == "bins" else STEP
        wanted = tuple((target.leaves, target.channel) for target in targets)
        found = self.gathering.gather(Order(targets[0].scan, wanted, width))
        if found is not None:
            self._found = found
            self._show(targets)

    def _show(self, targets: Sequence[Target]) -> None:
        project, choice, first = self.controller.project, self.choice, targets[0]
        state, points = project.state.scan(first.scan), self._found[first.leaves, first.channel]
        self.editor.show_points(points)
        self.follower.check(first, points)
        series = build_series(project.state, targets, self._found, choice, self.editor.shape)
        title = title_values(self, state.channel(first.channel).kind)
        self.plots.show_series(series, title)
        self.brushing.follow(first, points)
        self.formulas.show_preview(series[0], title)
        self.export.offer(
            order_figure(series, targets, title, choice, self.plots.tools.strip.isChecked()),
            report_fits(project, targets, choice.model),
        )
        self.row.tell_aside(state, choice.channels, len(self.targets), len(targets))
        self.pages.show_subject(Subject(first, choice.model, points, self.editor.result))

    def _on_choice(self) -> None:
        self.curve_use.end_drag()
        self.refresh_soon()

    def _on_moved(self) -> None:
        self.export.move_first(self.plots.series[0], self.editor.shape)
        self._tell_use()

    def _tell_use(self) -> None:
        self.row.tell_use(self.curve_use.curve)
        ready = self.target is not None and not self.notice.text
        self.use_button.setEnabled(ready and not self.curve_use.is_used)
        self.plots.tools.map.setChecked(self.curve_use.is_mapped)

    def _take_model(self, name: str) -> None:
        self.choice.models.choose(name)
        self._on_choice()

    def _make_table(self) -> None:
        targets, project, choice = self.targets, self.controller.project, self.choice
        if not targets:
            return
        table, scan = self.pages.table, targets[0].scan
        groups = list(dict.fromkeys(target.leaves for target in targets))
        every = table.all_leaves
        samples = each_leaf(project, scan) if every else name_samples(project, groups)
        table.tabulate(scan, samples, choice.channels, choice.model, choice.method)

    def _ask_file(self, write: Callable[[Path], object], suffix: str) -> None:
        """Ask where to write; the dialog asks about a file that exists."""
        state = self.controller.scan
        stem = "scan" if state is None else Path(state.scan.name).stem
        self.dialogs.ask_save(self.dialogs.folder / f"{stem}-curves{suffix}", write, self)

    def _on_notice(self) -> None:
        if self.controller.current is not None:
            self.origin_asked.emit(self.controller.current)

    def _on_formulas(self) -> None:
        self.pages.models.forget()
        self._on_choice()

    def _tell_failed(self, sentences: Sequence[str]) -> None:
        if sentences:
            self.controller.failed.emit(BadInput(sentences[0], " ".join(sentences[1:])))

    def _lay_out(self) -> None:
        content = QWidget(self)
        layout = QVBoxLayout(content)
        # Without a plot the room below the choices is nobody's: they do not spread over it.
        self.choice.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        layout.addWidget(self.choice)
        layout.addWidget(self.notice)
        layout.addWidget(self.plots, 1)
        layout.addWidget(self.row)
        layout.addWidget(self.pages)
        layout.addStretch(0)
        make_scrolling(content, self)

    def _connect(self) -> None:
        self.choice.changed.connect(self._on_choice)
        self.notice.clicked.connect(self._on_notice)
        self.gathering.ready.connect(self.refresh_soon)
        self.formulas.changed.connect(self._on_formulas)
        self.editor.moved.connect(self._on_moved)
        self.fit_button.clicked.connect(self.fit)
        self.use_button.clicked.connect(self.curve_use.use)
        self.fits.failed_cells.connect(self._tell_failed)
        self.pages.models.chosen.connect(self._take_model)
        self.pages.table.samples_asked.connect(self._make_table)
        self.pages.table.file_asked.connect(partial(self._ask_file, self.pages.table.write))
        self.export.file_asked.connect(partial(self._ask_file, self.export.write))
        self.plots.tools.map_toggled.connect(self.curve_use.map_residuals)

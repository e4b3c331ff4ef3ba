"""Correct: channels without what the angle of incidence does to them, by workflow."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.core.errors import LeafscopeError
from app.core.progress import Progress
from app.model.correction_fields import MARK
from app.model.fields import Same
from app.model.leaf import join_members
from app.model.scan import ChannelKind
from app.services.corrections import apply_corrections, remove_corrections
from app.services.curves import channel_in_use
from app.services.leaves import write_table
from app.services.workflow_preview import (
    TOGETHER,
    Order,
    Preview,
    list_leaves,
    preview_workflows,
)
from widgets.common.aside import copy_aside
from widgets.common.colour_buttons import ColourButtons
from widgets.common.colour_buttons import Row as ColourRow
from widgets.common.correct.numbers_table import NumbersTable
from widgets.common.correct.order_form import OrderForm
from widgets.common.correct.words import tell_marks
from widgets.common.correct.workflow_grid import SHORT, WorkflowGrid
from widgets.common.correct.workflow_plot import WorkflowPlot
from widgets.common.missing import find_missing, list_keys
from widgets.common.notice import Notice
from widgets.common.panel import Panel, make_scrolling
from widgets.dialogs.open_scan import FileDialogs


class CorrectPanel(Panel):
    """Shows what corrections would do, puts them to use, takes them out."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("correct")
        self.setWindowTitle(self.tr("Correct"))
        self.dialogs = FileDialogs(self)
        self.preview: Preview | None = None
        self._preview_for: Hashable = None
        self._chosen: tuple[str, ...] = ()
        self._trouble = ""
        self.notice = Notice(self)
        self.form = OrderForm(self)
        self.state = QLabel(self)
        self.numbers = NumbersTable(self)
        self.plot = WorkflowPlot(self)
        self.grid = WorkflowGrid(self)
        self.marks = QLabel(self)
        self.colours = ColourButtons(3, self)
        self.correct_button = QPushButton(self.tr("&Correct"), self)
        self.remove_button = QPushButton(self.tr("&Remove correction"), self)
        self.export_button = QPushButton(self.tr("&Export table…"), self)
        self._arrange()
        self._connect()

    def _arrange(self) -> None:
        for label in (self.state, self.marks):
            label.setWordWrap(True)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.correct_button.setProperty("primary", "true")
        self.correct_button.setToolTip(
            self.tr("Add the corrected channels to the scan; what is there stays, undo takes back")
        )
        self.remove_button.setToolTip(self.tr("Take the corrected channels out; can be undone"))
        self.export_button.setToolTip(self.tr("Write leaves × workflows as a CSV table"))
        self.body = QWidget(self)
        inner = QVBoxLayout(self.body)
        inner.setContentsMargins(0, 0, 0, 0)
        buttons = QHBoxLayout()
        for button in (self.correct_button, self.remove_button):
            buttons.addWidget(button)
        buttons.addStretch(1)
        inner.addWidget(self.numbers)
        inner.addLayout(buttons)
        inner.addWidget(self.state)
        inner.addWidget(self.grid)
        inner.addWidget(self.marks)
        inner.addWidget(self.plot)
        inner.addWidget(self.colours)
        last = QHBoxLayout()
        last.addWidget(self.export_button)
        last.addStretch(1)
        inner.addLayout(last)
        content = QWidget(self)
        layout = QVBoxLayout(content)
        for widget in (self.notice, self.form, self.body):
            layout.addWidget(widget)
        layout.addStretch(1)
        make_scrolling(content, self)

    def _connect(self) -> None:
        self.notice.clicked.connect(self._on_notice)
        self.form.changed.connect(self.refresh_soon)
        self.correct_button.clicked.connect(self.correct)
        self.remove_button.clicked.connect(self.remove)
        self.export_button.clicked.connect(self._export)
        self.colours.asked.connect(self._colour)

    def choose_leaves(self, keys: Sequence[str]) -> None:
        """Take over which leaves are selected in the table."""
        self._chosen = tuple(keys)
        self.refresh_soon()

    def refresh(self) -> None:
        """Show what the chosen corrections would do, or what is missing for it."""
        state, scan, project = (
            self.controller.scan,
            self.controller.current,
            self.controller.project,
        )
        channels = state.channels if state is not None else ()
        in_use = channel_in_use(project, scan) if scan and channels else ""
        self.form.fill_channels(channels, in_use)
        missing, action = self._find_missing()
        self.notice.say(missing or self._trouble, action)
        self.form.setVisible(state is not None and state.scan.pose is not None and bool(channels))
        if missing or scan is None:
            self._forget()
            return
        order = self._order()
        leaves = list_leaves(project, scan, order.leaves)
        parts = tuple(Same(leaf.members) for leaf in leaves)
        points = join_members(leaves, len(project.state.scan(scan).scan)) if leaves else None
        self._tell()
        if self.ask(scan, "incidence", points, parts):
            self._ask_preview(scan, order, parts)

    def correct(self) -> None:
        """Put the corrections that are shown to use, as one step."""
        scan, preview, project = self.controller.current, self.preview, self.controller.project
        if scan is not None and preview is not None:
            made = preview.made
            self.controller.attempt(lambda: apply_corrections(project, scan, made, instead=True))

    def remove(self) -> None:
        """Take the corrected channels of what is chosen out, as one step."""
        scan, project, names = self.controller.current, self.controller.project, self._in_use()
        if scan is not None and names:
            self.controller.attempt(lambda: remove_corrections(project, scan, names))

    def _order(self) -> Order:
        form = self.form
        leaves: tuple[str, ...] | None = None
        if form.what != "all":
            leaves = self._list_keys() or ()
        return Order(
            form.channels,
            form.workflows,
            form.source,
            leaves,
            form.species,
            form.values,
            form.least.value(),
        )

    def _list_keys(self) -> tuple[str, ...] | None:
        return list_keys(self.controller, self.form.what, self._chosen)

    def _find_missing(self) -> tuple[str, str]:
        return find_missing(
            self.controller.scan,
            self.tr("Open a scan to correct its channels for the angle of incidence."),
            self.tr("This scan has no intensity, and there is nothing to correct."),
            self.form.what,
            self._list_keys(),
        )

    def _ask_preview(self, scan: str, order: Order, parts: tuple[Same, ...]) -> None:
        state, project = self.controller.project.state.scan(scan), self.controller.project
        angles = Same(project.known_field(scan, "incidence"))
        values = tuple(order.values.items())
        mark = (scan, order.channels, order.workflows, order.source, order.leaves, order.species,
                values, order.least_bracket, parts, angles, Same(state.deleted), state.channels,
                Same(state.parameters.profile), state.parameters.radiometry[1:])  # fmt: skip
        if mark == self._preview_for:
            return
        self._preview_for, self.preview = mark, None
        self._tell()
        aside = copy_aside(project, scan)

        def work(progress: Progress) -> Preview | LeafscopeError:
            try:
                return preview_workflows(aside, scan, order, progress)
            except LeafscopeError as error:
                return error

        def done(found: Preview | LeafscopeError) -> None:
            if mark == self._preview_for:
                self._take(found)

        self.controller.run(self.tr("Comparing workflows"), work, done)

    def _take(self, found: Preview | LeafscopeError) -> None:
        self.preview = found if isinstance(found, Preview) else None
        self._trouble = "" if isinstance(found, Preview) else str(found)
        self.notice.say(self._trouble)
        self._show()

    def _forget(self) -> None:
        self.preview, self._preview_for, self._trouble = None, None, ""
        self.body.hide()

    def _show(self) -> None:
        preview = self.preview
        self.body.setVisible(preview is not None)
        self._tell()
        if preview is None:
            return
        shown = [row for row in preview.rows if row["channel"] == self.form.channel]
        self.grid.show_rows(shown)
        leaves = self.controller.project.state.leaves
        names = {key: leaf.name for key, leaf in leaves.items()}
        mine = [c for c in preview.corrections if c.source == self.form.channel]
        self.numbers.show_corrections(mine, names)
        self._draw()

    def _draw(self) -> None:
        state, preview, channel = self.controller.scan, self.preview, self.form.channel
        if preview is None or state is None or not channel:
            return
        kind: ChannelKind = next((c.kind for c in state.channels if c.name == channel), "linear")
        steps = {w: found for (name, w), found in preview.steps.items() if name == channel}
        self.plot.show_steps(steps, kind)

    def _tell(self) -> None:
        """What depends on what is in use: sentence, buttons, colours."""
        state, preview = self.controller.scan, self.preview
        if state is None:
            return
        used = state.parameters.corrections
        new = (
            preview is not None
            and bool(preview.made)
            and set_of(preview.corrections) != set_of(used)
        )
        self.correct_button.setEnabled(new)
        self.remove_button.setEnabled(bool(self._in_use()))
        self.export_button.setEnabled(preview is not None)
        words = []
        if preview is not None:
            words = [
                self.tr("Not in use yet: this is what these corrections would do.") if new
                else self.tr("In use: the corrected channels are fields of the scan.")
                if self._in_use() else self.tr("Nothing is corrected: tick a workflow.")
            ]  # fmt: skip
            words += [f"⚠ {text}" for text in preview.warnings]
            self.marks.setText("\n".join(self._tell_marks(preview)))
            self.marks.setVisible(bool(self.marks.text()))
        self.state.setText("\n".join(words))
        self.colours.show_fields(self._list_colours(), self.controller.view.colour)

    def _tell_marks(self, preview: Preview) -> list[str]:
        found = []
        for (channel, workflow), counts in preview.marks.items():
            if channel == self.form.channel:
                mine = [c for c in preview.corrections if c.name == f"{channel}_{workflow}"]
                least = mine[0].least_bracket if mine else self.form.least.value()
                found.append(tell_marks(workflow, counts, least))
        return found

    def _in_use(self) -> list[str]:
        """Corrected channels of those that are chosen."""
        state = self.controller.scan
        used = state.parameters.corrections if state is not None else ()
        return list(dict.fromkeys(c.name for c in used if c.source in self.form.channels))

    def _list_colours(self) -> list[ColourRow]:
        state, channel = self.controller.scan, self.form.channel
        there = {c.name for c in state.channels} if state is not None else set()
        made = [(w, f"{channel}_{w}") for w in SHORT if f"{channel}_{w}" in there]
        if not made:
            return []
        rows: list[ColourRow] = [(
            self.tr("View WF1"), channel, self.tr("Colour the view by {0}").format(channel)
        )]  # fmt: skip
        for workflow, name in made:
            short = SHORT[workflow]
            tip = self.tr("Colour the view by {0}")
            rows.append((self.tr("View {0}").format(short), name, tip.format(name)))
        for workflow, name in made:
            tip = self.tr("Colour the view by why points of {0} have no value").format(name)
            rows.append((self.tr("{0} marks").format(SHORT[workflow]), name + MARK, tip))
        return rows

    def _colour(self, field: str) -> None:
        self.controller.look(colour=field or self.form.channel)

    def _export(self) -> None:
        state, preview = self.controller.scan, self.preview
        if state is None or preview is None:
            return
        name = state.scan.name
        rows = [row for row in preview.rows if row["leaf"] != TOGETHER] or preview.rows
        table = [{"scan": name, **row} for row in rows]

        def write(path: Path) -> None:
            if self.controller.attempt(lambda: write_table(table, path, overwrite=True)):
                self.controller.said.emit(self.tr("Table written to {0}.").format(path))

        suggested = self.dialogs.folder / f"{Path(name).stem}-workflows.csv"
        self.dialogs.ask_save(suggested, write, self)

    def _on_notice(self) -> None:
        if self.controller.current is not None:
            self.origin_asked.emit(self.controller.current)


def set_of(corrections: Sequence[object]) -> frozenset[str]:
    """Corrections whatever their order."""
    return frozenset(map(repr, corrections))

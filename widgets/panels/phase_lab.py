"""Phase lab: intensity against incidence angle, and the curve through it."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from uuid import uuid4

from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.core.arrays import Ints
from app.core.fitting import FitResult
from app.core.phase import get_model
from app.model.fields import Same
from app.model.leaf import join_members
from app.model.parameters import Curve
from app.services.curves import channel_in_use
from widgets.common.angular_points import AngularPoints, gather_points
from widgets.common.aside import copy_aside
from widgets.common.curve_choice import CurveChoice, Target
from widgets.common.curve_editor import CurveEditor
from widgets.common.known_fits import find_newest, find_source, have_same_values
from widgets.common.notice import Notice
from widgets.common.panel import Panel, make_scrolling
from widgets.common.plots import MOST_DOTS

FEW_POINTS = 200_000


class PhaseLabPanel(Panel):
    """Choose a model, see its curve, move it, fit it, put it to use."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("phase-lab")
        self.setWindowTitle(self.tr("Phase lab"))
        self._chosen: tuple[str, ...] = ()
        self._points_for: Hashable = None
        self._seen: tuple[object, ...] = (None, None, None)
        self._drag = uuid4().hex
        self.choice = CurveChoice(self)
        self.notice = Notice(self)
        self.editor = CurveEditor(self)
        self.in_use = QLabel(self)
        self.fit_button = QPushButton(self.tr("&Fit"), self)
        self.use_button = QPushButton(self.tr("&Use this curve"), self)
        self._arrange()
        self._connect()

    def _arrange(self) -> None:
        self.fit_button.setToolTip(self.tr("Find the curve that lies closest to the points"))
        self.use_button.setToolTip(
            self.tr("Read angles from intensity by this curve: wrinkles and Δω rest on it")
        )
        self.in_use.setWordWrap(True)
        self.fit_button.setProperty("primary", "true")
        buttons = QHBoxLayout()
        buttons.addWidget(self.fit_button)
        buttons.addWidget(self.use_button)
        buttons.addStretch(1)
        content = QWidget(self)
        layout = QVBoxLayout(content)
        layout.addWidget(self.choice)
        layout.addWidget(self.notice)
        layout.addWidget(self.editor, 1)
        layout.addLayout(buttons)
        layout.addWidget(self.in_use)
        layout.addStretch(0)
        make_scrolling(content, self)

    def _connect(self) -> None:
        self.choice.changed.connect(self._on_choice)
        self.notice.clicked.connect(self._on_notice)
        self.editor.moved.connect(self._tell_use)
        self.editor.released.connect(self._on_released)
        self.editor.rows.grabbed.connect(self._on_grabbed)
        self.fit_button.clicked.connect(self.fit)
        self.use_button.clicked.connect(self.use)

    def choose_leaves(self, keys: Sequence[str]) -> None:
        """Take over which leaves are selected in the table."""
        self._chosen = tuple(keys)
        self.refresh_soon()

    @property
    def target(self) -> Target | None:
        """What the curve belongs to; None while something is missing."""
        state, scan, choice = self.controller.project.state, self.controller.current, self.choice
        if scan is None or not choice.channel:
            return None
        if choice.what == "scan":
            return Target(scan, (), choice.channel, choice.model)
        asked = (self.controller.view.leaf or "",) if choice.what == "leaf" else self._chosen
        keys = tuple(k for k in asked if k in state.leaves and state.leaves[k].scan == scan)
        return Target(scan, keys, choice.channel, choice.model) if keys else None

    def refresh(self) -> None:
        """Show points, curve and numbers for what is chosen."""
        scan, state = self.controller.current, self.controller.scan
        channels = state.channels if state is not None else ()
        in_use = channel_in_use(self.controller.project, scan) if scan and channels else ""
        self.choice.fill_channels(channels, in_use)
        missing, action = self._find_missing()
        self.notice.say(missing, action)
        self.editor.setVisible(not missing)
        self.fit_button.setEnabled(not missing)
        for widget in (self.choice, self.fit_button, self.use_button, self.in_use):
            widget.setVisible(state is not None)
        if missing:
            self._points_for = None
        else:
            self._follow_document()
            self._gather()
        self._tell_use()

    def restyle(self) -> None:
        """Draw in the new colours."""
        self.editor.restyle()

    def _find_missing(self) -> tuple[str, str]:
        state = self.controller.scan
        if state is None:
            return self.tr("Open a scan to see how its intensity depends on the angle."), ""
        if not state.channels:
            return self.tr(
                "This scan has no intensity, and a curve needs it. If one of its values is an "
                "intensity, name it as a channel in the Scans panel."
            ), ""
        if state.scan.pose is None:
            return self.tr(
                "Nobody knows where the scanner stood, and without that there are no angles."
            ), self.tr("Set position…")
        if self.target is None and self.choice.what == "chosen":
            return self.tr("Select one or more leaves of this scan in the Leaves panel."), ""
        if self.target is None:
            return self.tr(
                "Choose a leaf in the Leaves panel or draw one with the lasso, "
                "or look at the whole scan."
            ), ""
        return "", ""

    def _follow_document(self) -> None:
        """Show what changed last: the curve in use, else the newest fit, else a start."""
        state, before = self.controller.scan, self._seen
        if state is None:
            return
        curve = state.parameters.curve
        turned = curve is not None and curve != before[0]
        if curve is not None and turned:
            self.choice.show_model(curve.model)
            self.choice.show_channel(curve.channel)
        target = self.target
        if target is None:
            return
        record = find_newest(self.controller.project.state, target)
        self._seen = (curve, record, target)
        if self._seen == before:
            return
        fits = curve is not None and (curve.model, curve.channel) == (target.model, target.channel)
        if curve is not None and (turned or (record is None and fits)):
            source = find_source(self.controller.project.state, target.scan, curve)
            shown = curve.values if source is None else source.values
            self.editor.show_curve(get_model(target.model), shown, source)
        else:
            result = None if record is None else FitResult.from_dict(record.result)
            values = None if result is None else result.values
            self.editor.show_curve(get_model(target.model), values, result)

    def _gather(self) -> None:
        target, state, project = self.target, self.controller.scan, self.controller.project
        if target is None or state is None:
            return
        leaves = [project.state.leaves[key] for key in target.leaves]
        parts = tuple(Same(leaf.members) for leaf in leaves)
        points = join_members(leaves, len(state.scan)) if leaves else None
        if not self.ask(target.scan, "incidence", points, parts):
            return
        angles = Same(project.known_field(target.scan, "incidence"))
        alive, radiometry = Same(state.deleted), state.parameters.radiometry
        mark = (target.channel, parts, angles, alive, state.channels, radiometry)
        if mark != self._points_for:
            self._points_for = mark
            self._reduce(target, points, mark)

    def _reduce(self, target: Target, points: Ints | None, mark: Hashable) -> None:
        project, scan, channel = self.controller.project, target.scan, target.channel
        size = len(project.state.scan(scan).scan) if points is None else len(points)
        if size <= FEW_POINTS:
            self._show_points(gather_points(project, scan, points, channel, MOST_DOTS))
            return
        aside = copy_aside(project, scan)

        def done(found: AngularPoints) -> None:
            if mark == self._points_for:
                self._show_points(found)

        self.controller.run(
            self.tr("Drawing intensity against angle"),
            lambda progress: gather_points(aside, scan, points, channel, MOST_DOTS, progress),
            done,
        )

    def _show_points(self, points: AngularPoints) -> None:
        state, target = self.controller.scan, self.target
        if state is None or target is None:
            return
        titles = {
            "DN": self.tr("Intensity (DN)"),
            "dB": self.tr("Intensity (dB)"),
            "linear": self.tr("Intensity (linear)"),
            "reflectance": self.tr("Reflectance (0–1)"),
        }
        self.editor.show_points(points, titles[state.channel(target.channel).kind])

    def fit(self) -> None:
        """Fit the model to what is looked at; the curve can then be put to use."""
        target = self.target
        if target is not None:
            self.work.fit(target.leaves, target.model, target.channel)

    def use(self) -> None:
        """Put the curve that is shown to use."""
        target = self.target
        if target is None:
            return
        record = find_newest(self.controller.project.state, target)
        fitted = None if record is None else FitResult.from_dict(record.result)
        if record is not None and fitted == self.editor.result:
            self.work.use_fit(record)
        else:
            self._use_by_hand("")

    def _use_by_hand(self, drag: str) -> None:
        target = self.target
        if target is not None:
            origin = self.tr("set by hand")
            self.work.use_curve(
                Curve(target.model, self.editor.values, target.channel, origin), drag
            )

    def _on_grabbed(self) -> None:
        self._drag = uuid4().hex

    def _on_released(self) -> None:
        self._use_by_hand(f"curve {self._drag}")

    def _on_choice(self) -> None:
        self._drag = uuid4().hex
        self.refresh_soon()

    def _on_notice(self) -> None:
        if self.controller.current is not None:
            self.origin_asked.emit(self.controller.current)

    def _tell_use(self) -> None:
        state, target = self.controller.scan, self.target
        curve = None if state is None else state.parameters.curve
        if curve is None:
            self.in_use.setText(self.tr("No curve is in use yet."))
        else:
            text = self.tr("In use: {model} on {channel}, {origin}.")
            self.in_use.setText(
                text.format(
                    model=get_model(curve.model).title,
                    channel=curve.channel,
                    origin=curve.origin or self.tr("origin unknown"),
                )
            )
        used = (
            curve is not None
            and target is not None
            and (curve.model, curve.channel) == (target.model, target.channel)
            and have_same_values(curve.values, self.editor.values)
        )
        self.use_button.setEnabled(target is not None and not self.notice.text and not used)

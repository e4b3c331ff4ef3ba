"""Wrinkles: how far each part of a leaf is turned away from the leaf's plane."""

from __future__ import annotations

import math
from collections.abc import Hashable

from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.core.arrays import Ints
from app.core.errors import LeafscopeError
from app.core.units import to_degrees
from app.core.wrinkles import SIGN_OF_DELTA
from app.model.fields import Same
from app.model.leaf import FitRecord, Leaf
from app.services.curves import DEFAULT_MODEL, channel_in_use
from widgets.common.aside import copy_aside
from widgets.common.colour_strip import ColourStrip
from widgets.common.delta_plots import DeltaHistogram, DeltaMap
from widgets.common.fact_grid import FactGrid
from widgets.common.known_fits import find_source
from widgets.common.notice import Notice
from widgets.common.numbers import show_count, show_number, show_signed
from widgets.common.panel import Panel, make_scrolling
from widgets.common.wrinkle_map import SeenLeaf, see_leaf

FIELD = "delta_omega"
FEW_POINTS = 20_000


class WrinklesPanel(Panel):
    """Map and distribution of Δω of the current leaf."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("wrinkles")
        self.setWindowTitle(self.tr("Wrinkles"))
        self.seen: SeenLeaf | None = None
        self._seen_for: Hashable = None
        self._awaits_fit = False
        self.notice = Notice(self)
        self.title = QLabel(self)
        self.map = DeltaMap(self)
        self.strip = ColourStrip("delta-omega", self)
        self.legend = QLabel(SIGN_OF_DELTA, self)
        self.histogram = DeltaHistogram(self)
        self.facts = FactGrid(self)
        self.colour_button = QPushButton(self.tr("&Colour the cloud by Δω"), self)
        self._arrange()
        self.notice.clicked.connect(self._on_notice)
        self.colour_button.clicked.connect(self._on_colour)
        self.work.fitted.connect(self._on_fitted)

    def _arrange(self) -> None:
        self.legend.setWordWrap(True)
        self.colour_button.setCheckable(True)
        self.body = QWidget(self)
        inner = QVBoxLayout(self.body)
        inner.setContentsMargins(0, 0, 0, 0)
        for widget in (self.map, self.strip, self.legend, self.histogram, self.facts):
            inner.addWidget(widget)
        inner.setStretch(0, 3)
        inner.setStretch(3, 2)
        buttons = QHBoxLayout()
        buttons.addWidget(self.colour_button)
        buttons.addStretch(1)
        content = QWidget(self)
        layout = QVBoxLayout(content)
        layout.addWidget(self.title)
        layout.addWidget(self.notice)
        layout.addWidget(self.body, 1)
        layout.addLayout(buttons)
        layout.addStretch(0)
        make_scrolling(content, self)

    @property
    def leaf(self) -> Leaf | None:
        """The leaf that is looked at, if it belongs to the current scan."""
        leaf = self.controller.project.state.leaves.get(self.controller.view.leaf or "")
        return leaf if leaf is not None and leaf.scan == self.controller.current else None

    def refresh(self) -> None:
        """Show the Δω of the current leaf, or what is missing for it."""
        leaf = self.leaf
        missing, action = self._find_missing()
        self.title.setText("" if leaf is None else f"<b>{leaf.name}</b>")
        self.title.setVisible(leaf is not None)
        self.notice.say(missing, action)
        self.colour_button.setVisible(not missing)
        self.colour_button.setChecked(self.controller.view.colour == FIELD)
        if missing or leaf is None:
            self.body.setVisible(False)
            self.seen, self._seen_for = None, None
            return
        members = leaf.members.indices
        if self.ask(leaf.scan, FIELD, members):
            self._show_leaf(leaf.scan, members)

    def restyle(self) -> None:
        """Draw in the new colours."""
        if self.seen is not None:
            self._show_seen(self.seen)

    def _find_missing(self) -> tuple[str, str]:
        state = self.controller.scan
        if state is None:
            return self.tr("Open a scan to see how its leaves are wrinkled."), ""
        if not state.channels:
            return self.tr("This scan has no intensity, and wrinkles are read from it."), ""
        if state.scan.pose is None:
            return self.tr(
                "Nobody knows where the scanner stood, and without that there are no angles."
            ), self.tr("Set position…")
        if self.leaf is None:
            return self.tr("Choose a leaf in the Leaves panel, or draw one with the lasso."), ""
        if state.parameters.curve is None:
            return self.tr(
                "No curve is in use that turns intensity into an angle. Fit one to this leaf, "
                "or choose a curve in the Phase lab."
            ), self.tr("Fit and use")
        return "", ""

    def _show_leaf(self, scan: str, members: Ints) -> None:
        project, state = self.controller.project, self.controller.scan
        if state is None or state.parameters.curve is None:
            return
        known = Same(project.known_field(scan, FIELD))
        mark = (scan, Same(members), known, Same(state.deleted), Same(state.parameters))
        if mark == self._seen_for:
            return
        self._seen_for = mark
        source = find_source(project.state, scan, state.parameters.curve)
        sigma = state.channel(state.parameters.curve.channel).sigma
        noise = sigma if sigma is not None else (0.0 if source is None else source.rmse)
        aside = copy_aside(project, scan)

        def look() -> SeenLeaf | LeafscopeError:
            try:
                return see_leaf(aside, scan, members, noise)
            except LeafscopeError as error:
                return error

        def done(found: SeenLeaf | LeafscopeError) -> None:
            if mark == self._seen_for:
                self._show_found(found)

        if len(members) <= FEW_POINTS:
            done(look())
        else:
            self.controller.run(self.tr("Drawing Δω"), lambda _: look(), done)

    def _show_found(self, found: SeenLeaf | LeafscopeError) -> None:
        self.seen = found if isinstance(found, SeenLeaf) else None
        self.body.setVisible(self.seen is not None)
        if isinstance(found, SeenLeaf):
            self._show_seen(found)
        else:
            self.notice.say(str(found))

    def _show_seen(self, seen: SeenLeaf) -> None:
        limit = seen.limit
        self.map.show_leaf(seen, limit)
        self.histogram.show_distribution(seen.spread, limit)
        self.strip.show_texts(
            self.tr("{angle}° face-on").format(angle=show_number(-limit, 0)),
            self.tr("0° on the plane"),
            self.tr("edge-on {angle}°").format(angle=show_signed(limit, 0)),
        )
        self.facts.show_facts(self._list_facts(seen))
        self.facts.setToolTip(
            self.tr(
                "Doubtful: near face-on and beyond 60° intensity says little about the angle. "
                "Off the curve: the curve in use nowhere has that intensity."
            )
        )

    def _list_facts(self, seen: SeenLeaf) -> list[tuple[str, str]]:
        spread = seen.spread
        mean, median, sd, shift = (
            float(to_degrees(v)) for v in (spread.mean, spread.median, spread.sd, spread.shift)
        )
        modes = ", ".join(f"{show_signed(float(to_degrees(m)))}°" for m in spread.modes)
        from_mean = self.tr("{angle}° (shift {shift}°)").format(
            angle=show_number(seen.plane + shift, 1), shift=show_signed(shift)
        )
        return [
            (self.tr("ω of the leaf's plane"), f"{show_number(seen.plane, 1)}°"),
            (
                self.tr("ω from the mean intensity"),
                from_mean if math.isfinite(shift) else self.tr("not on the curve"),
            ),
            (self.tr("Δω, mean ± sd"), f"{show_signed(mean)}° ± {show_number(sd, 1)}°"),
            (self.tr("Δω, median"), f"{show_signed(median)}°"),
            (self.tr("Skewness"), show_signed(spread.skewness, 2)),
            (self.tr("Peaks of Δω"), self._tell_modes(modes, len(spread.modes))),
            (
                self.tr("Points"),
                self.tr("{n}, {m} more are off the curve").format(
                    n=show_count(spread.count), m=show_count(spread.undefined)
                ),
            ),
            (
                self.tr("Doubtful (faint)"),
                self.tr("{share} % of the points").format(
                    share=show_number(100 * seen.doubtful, 0)
                ),
            ),
        ]

    def _tell_modes(self, modes: str, count: int) -> str:
        if count == 1:
            return self.tr("{modes} (one: a simple curvature)").format(modes=modes)
        return self.tr("{modes} (several: wrinkles)").format(modes=modes)

    def _on_notice(self) -> None:
        state, scan, leaf = self.controller.scan, self.controller.current, self.leaf
        if state is None or scan is None:
            return
        if state.scan.pose is None:
            self.origin_asked.emit(scan)
        elif leaf is not None:
            self._awaits_fit = True
            channel = channel_in_use(self.controller.project, scan)
            self.work.fit([leaf.key], DEFAULT_MODEL, channel)

    def _on_fitted(self, record: FitRecord) -> None:
        if self._awaits_fit:
            self._awaits_fit = False
            self.work.use_fit(record)

    def _on_colour(self, wanted: bool) -> None:
        self.controller.look(colour=FIELD if wanted else self._other_colour())

    def _other_colour(self) -> str:
        state = self.controller.scan
        channels = () if state is None else state.channels
        return channels[0].name if channels else ""

"""Incidence angles: how planes are found, with which beam, and how good the angles are."""

from __future__ import annotations

from collections.abc import Hashable
from uuid import uuid4

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QComboBox, QFormLayout, QLabel, QVBoxLayout, QWidget

from app.core.incidence import ESTIMATORS
from app.core.units import MM_PER_M, to_mm
from app.model.fields import Same, Values
from app.model.parameters import LARGEST_RADIUS, Beam
from app.model.scan import Scan
from app.services.angles import AngleFacts, describe_angles
from app.services.beams import propose_beam
from widgets.common.beam_form import BeamForm
from widgets.common.fact_grid import FactGrid
from widgets.common.notice import Notice
from widgets.common.numbers import NumberField, show_count, show_number
from widgets.common.panel import Panel, make_scrolling

FIELD = "incidence"
LEAST_RADIUS_MM = 0.1
TITLES = {
    "adaptive": ("Adaptive", "The window grows where the surface is flat, stays narrow "
                 "where it bends, and keeps to one side at edges. The best choice for nearly "
                 "everything."),
    "robust": ("Robust", "A window of the radius; points that do not lie on the surface lose "
               "their weight. For many edges and ghosts."),
    "window": ("Window", "A plain window of the radius, cut at jumps of the range. The fastest, "
               "and the easiest to describe."),
    "ball": ("Ball", "All points within the radius, as other programs do it. To compare with "
             "them; it needs no rows and columns."),
}  # fmt: skip


class AnglesPanel(Panel):
    """Radius, estimator and beam of the current scan; what came of them."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("angles")
        self.setWindowTitle(self.tr("Angles"))
        self.facts: AngleFacts | None = None
        self._facts_of: Hashable = None
        self._proposed: tuple[Scan, Beam | None] | None = None
        self._drag = uuid4().hex
        self._radius = 0.0
        self.notice = Notice(self)
        self.radius = NumberField(LEAST_RADIUS_MM, to_mm(LARGEST_RADIUS), 2, "mm", self)
        self.estimator = QComboBox(self)
        self.sentence = QLabel(self)
        self.beam = BeamForm(self)
        self.found = FactGrid(self)
        self._explain()
        self._lay_out()
        self.notice.clicked.connect(self._on_notice)
        self.radius.valueChanged.connect(self._set_radius)
        self.radius.editingFinished.connect(self._end_drag)
        self.estimator.activated.connect(self._set_estimator)
        self.beam.changed.connect(self._set_beam)

    def refresh(self) -> None:
        """Show the parameters of the current scan and what came of them, or what is missing."""
        state, known = self.controller.scan, self._known()
        self.notice.say(*self._find_missing(known))
        self.body.setVisible(state is not None)
        if state is None:
            self.facts, self._facts_of, self._proposed = None, None, None
            return
        parameters = state.parameters
        self._show_radius(parameters.radius)
        self.estimator.setCurrentIndex(ESTIMATORS.index(parameters.estimator))
        self.sentence.setText(self.tr(TITLES[parameters.estimator][1]))
        self.beam.show_beam(parameters.beam, self._propose(state.scan))
        self._tell(known)

    def _show_radius(self, metres: float) -> None:
        if metres != self._radius:  # else a number that is half typed would be lost
            self._radius = metres
            with QSignalBlocker(self.radius):
                self.radius.setValue(to_mm(metres))

    def _known(self) -> Values | None:
        scan = self.controller.current
        known = None if scan is None else self.controller.project.known_field(scan, FIELD)
        return known if known is not None and known.computed else None

    def _find_missing(self, known: Values | None) -> tuple[str, str]:
        state = self.controller.scan
        if state is None:
            return self.tr("Open a scan to see the angles at which the beam met it."), ""
        if state.scan.pose is None:
            return self.tr(
                "Nobody knows where the scanner stood, and angles are those of its beams."
            ), self.tr("Set position…")
        if known is None or not known.complete:
            return self.tr("The angle between the beam and the surface, at every point."), self.tr(
                "Compute angles"
            )
        return "", ""

    def _propose(self, scan: Scan) -> Beam | None:
        if self._proposed is None or self._proposed[0] is not scan:
            self._proposed = (scan, propose_beam(scan))
        return self._proposed[1]

    def _tell(self, known: Values | None) -> None:
        state = self.controller.scan
        if known is None or state is None:
            self.facts, self._facts_of = None, None
            self.found.hide()
            return
        mark = (Same(known), known.computed)
        if mark != self._facts_of:
            self.facts, self._facts_of = describe_angles(known, state.scan.valid), mark
            self.found.show_facts(self._list_facts(self.facts, len(state.scan)))
        self.found.show()

    def _list_facts(self, facts: AngleFacts, total: int) -> list[tuple[str, str]]:
        points = show_count(facts.points)
        if facts.points < total:
            points = self.tr("{0} of {1}").format(points, show_count(total))
        share = 100.0 * facts.undefined / facts.points if facts.points else 0.0
        return [
            (self.tr("Neighbours"), self.tr(facts.neighbours)),
            (self.tr("Why"), facts.reason),
            (self.tr("Estimator"), self.tr(TITLES[facts.estimator][0])),
            (self.tr("Points"), points),
            (self.tr("Half-width"), self.tr("{0} mm (median)").format(
                show_number(facts.width_mm, 2))),
            (self.tr("σ of the angle"), self.tr("{0}° (median)").format(
                show_number(facts.sigma_deg, 2))),
            (self.tr("Without value"), f"{show_number(share, 2)} %"),
        ]  # fmt: skip

    def _set_radius(self, mm: float) -> None:
        self.work.set_parameters(drag=f"radius {self._drag}", radius=mm / MM_PER_M)

    def _end_drag(self) -> None:
        self._drag = uuid4().hex  # arrows that are pressed later are another step

    def _set_estimator(self, row: int) -> None:
        state = self.controller.scan
        if state is not None and state.parameters.estimator != ESTIMATORS[row]:
            self.work.set_parameters(estimator=ESTIMATORS[row])

    def _set_beam(self, beam: Beam | None) -> None:
        state = self.controller.scan
        if state is not None and state.parameters.beam != beam:
            self.work.set_parameters(beam=beam)

    def _on_notice(self) -> None:
        state, scan = self.controller.scan, self.controller.current
        if state is None or scan is None:
            return
        if state.scan.pose is None:
            self.origin_asked.emit(scan)
        else:
            self.controller.want(scan, FIELD)

    def _explain(self) -> None:
        self.estimator.addItems(
            [self.tr(title) for title, _ in map(TITLES.__getitem__, ESTIMATORS)]
        )
        told = (
            (self.radius, self.tr("Radius around a point, mm"),
             self.tr("Half-width of the window around a point, or radius of the ball "
                     "(0.1–500 mm)")),
            (self.estimator, self.tr("Estimator"), self.tr("How the plane at a point is found")),
        )  # fmt: skip
        for widget, name, tip in told:
            widget.setAccessibleName(name)
            widget.setToolTip(tip)
        self.sentence.setWordWrap(True)
        self.sentence.setProperty("faint", "true")

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(self.tr("&Radius"), self.radius)
        form.addRow(self.tr("&Estimator"), self.estimator)
        form.addRow(self.sentence)
        self.body = QWidget(self)
        inner = QVBoxLayout(self.body)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.setSpacing(self.fontMetrics().height())
        inner.addLayout(form)
        inner.addWidget(self.beam)
        inner.addWidget(self.found)
        content = QWidget(self)
        layout = QVBoxLayout(content)
        layout.addWidget(self.notice)
        layout.addWidget(self.body)
        layout.addStretch(1)
        make_scrolling(content, self)

"""Page "Certainty": how sure the parameters are, plainly, by profile and by resampled leaves."""

from __future__ import annotations

from typing import Literal

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QGridLayout,
    QLabel,
    QPushButton,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from app.model.fields import Same
from app.services.lab.uncertainty import (
    IntervalRow,
    ParameterRow,
    bootstrap,
    describe_parameters,
    profile,
)
from widgets.common.fact_table import FactTable
from widgets.common.lab.asking import Asking
from widgets.common.lab.subject import Subject
from widgets.common.lab.tables import fit_height
from widgets.common.numbers import UNKNOWN, count_decimals, show_number
from widgets.controller import Controller

LEFT, RIGHT = Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignRight
FEWEST, MOST, USUAL = 100, 20_000, 1000
Way = Literal["profile", "bootstrap"]


class CertaintyPage(QWidget):
    """95 % intervals of the fit that is shown; those that take time are made on request."""

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._subject: Subject | None = None
        self._of: object = None
        self.found: dict[Way, tuple[IntervalRow, ...]] = {}
        self._asking = Asking(controller, self)
        self.words = QLabel(self)
        self.table = FactTable(
            self.tr("95 % intervals of the parameters"),
            (self.tr("Parameter"), self.tr("Interval"), self.tr("From"), self.tr("To")),
            self,
            (LEFT, LEFT, RIGHT, RIGHT),
        )
        self.note = QLabel(self)
        self.profile_button = QPushButton(self.tr("&Profile intervals"), self)
        self.bootstrap_button = QPushButton(self.tr("&Bootstrap by leaf"), self)
        self.cancel_button = QPushButton(self.tr("Cance&l"), self)
        self.trials = QSpinBox(self)
        self._explain()
        self._lay_out()
        self.profile_button.clicked.connect(self.ask_profile)
        self.bootstrap_button.clicked.connect(self.ask_bootstrap)
        self.cancel_button.clicked.connect(self._asking.cancel)
        self._asking.changed.connect(self._tell)
        self._asking.refused.connect(self._refuse)

    def show_subject(self, subject: Subject | None) -> None:
        """Show the intervals of the fit of a subject."""
        self._subject = subject
        mark = None
        if subject is not None and subject.result is not None:
            mark = (subject.result, Same(subject.points.measured), subject.target)
        if mark != self._of:
            self._of = mark
            self._asking.cancel()
            self.found = {}
            self._show()

    def ask_profile(self) -> None:
        """Find profile intervals in the worker."""
        subject = self._subject
        if subject is None:
            return
        method, model, measured = subject.target.method, subject.model, subject.points.measured
        self._asking.ask(
            self.tr("Profile intervals"),
            lambda _: profile(method, model, measured.angle, measured.value),
            self._take_profile,
        )

    def ask_bootstrap(self) -> None:
        """Draw leaves again and again in the worker."""
        subject, count = self._subject, self.trials.value()
        if subject is None:
            return
        method, model, measured = subject.target.method, subject.model, subject.points.measured
        self._asking.ask(
            self.tr("Bootstrap by leaf"),
            lambda progress: bootstrap(method, model, measured, count, progress=progress),
            self._take_bootstrap,
        )

    def _take_profile(self, rows: tuple[IntervalRow, ...]) -> None:
        self.found["profile"] = rows
        self._show()

    def _take_bootstrap(self, rows: tuple[IntervalRow, ...]) -> None:
        self.found["bootstrap"] = rows
        self._show()

    def _show(self) -> None:
        result = None if self._subject is None else self._subject.result
        rows = () if result is None else describe_parameters(result)
        cells = [line for row in rows for line in self._write(row)]
        self.table.show_rows([texts for texts, _ in cells], [tip for _, tip in cells])
        fit_height(self.table)
        said = [row.words for found in self.found.values() for row in found]
        said += [row.words for row in rows]
        self.note.setText("\n".join(dict.fromkeys(filter(None, said))))
        self._tell()

    def _write(self, row: ParameterRow) -> list[tuple[tuple[str, ...], str]]:
        """A line for each way that an interval was found."""
        decimals = count_decimals(row.value, row.sd)
        value = self.tr("not determined")
        if row.value is not None:
            value = f"{row.name} = {show_number(row.value, decimals)}"
        ends = (show_number(row.low, decimals), show_number(row.high, decimals))
        lines: list[tuple[tuple[str, ...], str]] = []
        lines.append(((value, self.tr("plain"), *ends), row.words or row.meaning))
        ways: tuple[tuple[Way, str], ...] = (
            ("profile", self.tr("profile")),
            ("bootstrap", self.tr("by leaf")),
        )
        for way, title in ways:
            one = next((r for r in self.found.get(way, ()) if r.name == row.name), None)
            if one is not None:
                low = self._show_end(one.low, one.low_open, decimals)
                high = self._show_end(one.high, one.high_open, decimals)
                lines.append((("", title, low, high), one.words or row.meaning))
        return lines

    def _show_end(self, end: float | None, is_open: bool, decimals: int) -> str:
        if end is None:
            return self.tr("none") if is_open else UNKNOWN
        number = show_number(end, decimals)
        return self.tr("{0} (bound)").format(number) if is_open else number

    def _tell(self) -> None:
        fitted = self._subject is not None and self._subject.result is not None
        busy = self._asking.busy
        if busy:
            self.words.setText(self.tr("Computing… the other pages go on."))
        elif not fitted:
            self.words.setText(self.tr("Press Fit: only a fitted curve has intervals."))
        else:
            self.words.setText(self.tr("95 % intervals of the fit that is shown above."))
        self.table.setVisible(fitted)
        self.note.setVisible(fitted and bool(self.note.text()))
        for button in (self.profile_button, self.bootstrap_button):
            button.setEnabled(fitted and not busy)
        self.cancel_button.setEnabled(busy)

    def _refuse(self, sentence: str) -> None:
        self.note.setText(sentence)
        self.note.setVisible(True)

    def _explain(self) -> None:
        self.table.explain_columns(
            self.tr("Parameter of the model with its fitted value"),
            self.tr(
                "Plain: value ± t · sd, right where the curve is nearly straight in it. Profile: "
                "how far it can go while the others follow, right at bounds too. By leaf: what "
                "other leaves of the same kind would have given"
            ),
            self.tr("Lower end, 95 %"),
            self.tr("Upper end, 95 %"),
        )
        self.profile_button.setToolTip(
            self.tr("Let each parameter go until the points contradict it, the others following")
        )
        self.bootstrap_button.setToolTip(
            self.tr(
                "Draw leaves with replacement and fit each draw; needs points of several leaves "
                "taken together"
            )
        )
        self.cancel_button.setToolTip(self.tr("Stop what is being computed"))
        self.trials.setRange(FEWEST, MOST)
        self.trials.setSingleStep(FEWEST)
        self.trials.setValue(USUAL)
        self.trials.setSuffix(self.tr(" draws"))
        self.trials.setAccessibleName(self.tr("Draws of the bootstrap"))
        self.trials.setToolTip(self.tr("How often leaves are drawn, 100 to 20 000 times"))
        for label in (self.words, self.note):
            label.setWordWrap(True)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)

    def _lay_out(self) -> None:
        buttons = QGridLayout()
        buttons.addWidget(self.profile_button, 0, 0)
        buttons.addWidget(self.cancel_button, 0, 1)
        buttons.addWidget(self.bootstrap_button, 1, 0)
        buttons.addWidget(self.trials, 1, 1)
        buttons.setColumnStretch(2, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.words)
        layout.addLayout(buttons)  # above what grows: they are seen in a low window too
        layout.addWidget(self.table)
        layout.addWidget(self.note)
        layout.addStretch(1)
        self._show()

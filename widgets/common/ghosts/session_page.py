"""Going through the ghosts of a scan: one after the other, a leaf at a time, or by lasso."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QItemSelectionModel, QSignalBlocker, Qt, QTimer, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QTableView,
    QVBoxLayout,
    QWidget,
)

from app.model.points import EMPTY
from app.services.cleanup.answers import Answer
from app.services.cleanup.areas import AreaChange
from app.services.cleanup.evidence import say_length
from app.services.cleanup.statistics import Statistics
from widgets.common.ghosts.answer_menu import AnswerMenu
from widgets.common.ghosts.keys import SessionKeys
from widgets.common.ghosts.queue_table import ANSWER, LEAF, SCORE, WHY, QueueTable
from widgets.common.ghosts.session import Session
from widgets.common.ghosts.tally import (
    describe_areas,
    describe_leaves,
    describe_reasons,
    describe_short,
)
from widgets.common.numbers import show_count, show_number
from widgets.controller import Controller

LINES = 6
PAUSE_MS = 120


class SessionPage(QWidget):
    """Queue, sentence and answers of a clean-up.

    Signals
    -------
    after_toggled(bool)
        Show the scan as it would be after the clean-up, or as it is.
    """

    after_toggled = Signal(bool)

    def __init__(self, controller: Controller, parent: QWidget) -> None:
        super().__init__(parent)
        self.controller = controller
        self.session = Session(controller, self)
        self.model = QueueTable(self)
        self.batch_box = QComboBox(self)
        self.table = QTableView(self)
        self.sentence = QLabel(self)
        self.proposal = QLabel(self)
        self.accept_button = QPushButton(self.tr("Accept (A)"), self)
        self.keep_button = QPushButton(self.tr("Keep (R)"), self)
        self.delete_button = QPushButton(self.tr("Delete (D)"), self)
        self.correct_button = QPushButton(self.tr("Correct (C)"), self)
        self.back_button = QPushButton(self.tr("Previous (P)"), self)
        self.next_button = QPushButton(self.tr("Next (N)"), self)
        self.batch_button = QPushButton(self.tr("All of &them"), self)
        self.lasso_button = QPushButton(self.tr("The &selected"), self)
        self.after_button = QPushButton(self.tr("Show a&fter"), self)
        self.tally = QLabel(self)
        self.done = QLabel(self)
        self.proposals = QCheckBox(self.tr("Take the &proposals where I gave no answer"), self)
        self.apply_button = QPushButton(self.tr("Appl&y"), self)
        self.keys = SessionKeys(
            {
                Qt.Key.Key_N: self.next, Qt.Key.Key_P: self.back, Qt.Key.Key_A: self.accept,
                Qt.Key.Key_R: self.keep, Qt.Key.Key_D: self.delete, Qt.Key.Key_C: self.correct,
            },
            self.is_on,
            self,
        )  # fmt: skip
        self._applied: object = None
        self._found: Statistics | None = None
        self._later = QTimer(self, singleShot=True, interval=PAUSE_MS)
        self._arrange()
        self._explain()
        self._connect()

    # What keys and buttons do

    def is_on(self) -> bool:
        """Whether somebody sees the queue, so that letters belong to it."""
        return self.isVisible() and self.session.plan is not None

    def next(self) -> None:
        """Go to the next ghost."""
        self.session.step(1)

    def back(self) -> None:
        """Go to the ghost before."""
        self.session.step(-1)

    def accept(self) -> None:
        """Do what is proposed."""
        self.session.answer(None, accept=True)

    def keep(self) -> None:
        """It is no ghost."""
        self.session.answer(Answer.KEEP)

    def delete(self) -> None:
        """It is to be deleted."""
        self.session.answer(Answer.DELETE)

    def correct(self) -> None:
        """It is to be put back on its surface."""
        self.session.answer(Answer.CORRECT)

    def apply(self) -> None:
        """Do all that is answered."""
        done = self.session.apply(self.proposals.isChecked())
        if done is None:
            self.controller.said.emit(self.tr("There is nothing to do: no ghost is answered."))
            return
        self._applied, self._found = self.controller.project.history.done[-1], done
        self._tell_done(())
        self.done.show()

    def _tell_done(self, areas: Sequence[AreaChange]) -> None:
        """Say what was done; of areas as soon as they are measured."""
        done = self._found
        if done is None:
            return
        text = self.tr("<b>Done:</b> {0}").format(describe_short(done))
        self.done.setText(text + describe_areas(areas))
        self.done.setToolTip(f"{describe_reasons(done)}{describe_leaves(done, areas)}")

    # Putting together

    def _arrange(self) -> None:
        self.table.setModel(self.model)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.setTabKeyNavigation(False)
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setDefaultSectionSize(round(1.5 * self.fontMetrics().height()))
        self.table.setMinimumHeight(LINES * self.fontMetrics().height())
        header, modes = self.table.horizontalHeader(), QHeaderView.ResizeMode
        letter = 1.5 * self.fontMetrics().averageCharWidth()
        for column, letters in ((SCORE, 6), (LEAF, 8), (WHY, 8), (ANSWER, 9)):
            header.resizeSection(column, round(letters * letter))
        header.setSectionResizeMode(LEAF, modes.Stretch)
        header.setMinimumSectionSize(3 * self.fontMetrics().averageCharWidth())
        self.sentence.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        for label in (self.sentence, self.proposal, self.tally, self.done):
            label.setWordWrap(True)
        self.sentence.setMinimumHeight(3 * self.fontMetrics().lineSpacing())
        self.sentence.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        self.proposal.setProperty("faint", "true")
        policy = QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        self.batch_box.setSizeAdjustPolicy(policy)
        self.batch_box.setMinimumContentsLength(12)
        self.after_button.setCheckable(True)
        self.proposals.setChecked(True)
        self.apply_button.setProperty("primary", "true")
        label = QLabel(self.tr("Go &through"), self)
        label.setBuddy(self.batch_box)
        top = QHBoxLayout()
        top.addWidget(label)
        top.addWidget(self.batch_box, 1)
        grid = QGridLayout()
        for place, button in enumerate(self._buttons):
            grid.addWidget(button, place // 2, place % 2)
        all_ = QHBoxLayout()
        all_.addWidget(self.batch_button, 1)
        all_.addWidget(self.lasso_button, 1)
        last = QHBoxLayout()
        last.addWidget(self.after_button, 1)
        last.addWidget(self.apply_button, 1)
        layout = QVBoxLayout(self)
        layout.addLayout(top)
        layout.addWidget(self.table, 1)
        layout.addWidget(self.sentence)
        layout.addWidget(self.proposal)
        layout.addLayout(grid)
        layout.addLayout(all_)
        layout.addWidget(self.tally)
        layout.addWidget(self.done)
        layout.addWidget(self.proposals)
        layout.addLayout(last)

    @property
    def _buttons(self) -> tuple[QPushButton, ...]:
        return (self.back_button, self.next_button, self.accept_button, self.keep_button,
                self.delete_button, self.correct_button)  # fmt: skip

    def _explain(self) -> None:
        told = (
            (self.batch_box, self.tr("Which ghosts to go through"),
             self.tr("All ghosts, those of one leaf, or those of one kind; doubtful ones first")),
            (self.table, self.tr("Queue of ghosts"),
             self.tr("Ghosts, the doubtful ones first; N and P go on and back")),
            (self.accept_button, "", self.tr("Do with this ghost what is proposed (A)")),
            (self.keep_button, "", self.tr("Reject: this point is no ghost, keep it (R)")),
            (self.delete_button, "", self.tr("Delete this point when answers are applied (D)")),
            (self.correct_button, "",
             self.tr("Put this point back on its surface when answers are applied (C)")),
            (self.next_button, "", self.tr("Look at the next ghost of the queue (N)")),
            (self.back_button, "", self.tr("Look at the ghost before (P)")),
            (self.batch_button, "", self.tr("One answer for all ghosts of this queue")),
            (self.lasso_button, "",
             self.tr("One answer for the ghosts among the selected points; select with the lasso "
                     "(L) or the rectangle")),
            (self.after_button, "",
             self.tr("See where points would go, without changing anything")),
            (self.proposals, "",
             self.tr("Off: ghosts without an answer of yours are left alone")),
            (self.apply_button, "",
             self.tr("Correct and delete as answered, in one step that can be undone")),
        )  # fmt: skip
        for widget, name, tip in told:
            widget.setToolTip(tip)
            if name:
                widget.setAccessibleName(name)
        self.sentence.setAccessibleName(self.tr("Why this point is a ghost"))

    def _connect(self) -> None:
        session = self.session
        session.changed.connect(self._show_queue)
        session.moved.connect(self._show_ghost)
        session.answered.connect(self._show_answers)
        session.measured.connect(self._tell_done)
        self._later.timeout.connect(self._count)
        self.batch_box.activated.connect(self._choose_batch)
        for button, answer in (
            (self.batch_button, self._answer_batch), (self.lasso_button, self._answer_selected)
        ):  # fmt: skip
            menu = AnswerMenu(button)
            menu.chosen.connect(answer)
            button.setMenu(menu)
        # Not currentRowChanged: Qt makes the first row current when the table gets the focus.
        self.table.selectionModel().selectionChanged.connect(self._on_row)
        own = (self.back, self.next, self.accept, self.keep, self.delete, self.correct)
        for button, deed in zip(self._buttons, own, strict=True):
            button.clicked.connect(deed)
        self.after_button.toggled.connect(self._on_after)
        self.proposals.toggled.connect(self._count_soon)
        self.apply_button.clicked.connect(self.apply)
        self.keys.serve(self.table, self.after_button, self.apply_button, self.proposals,
                        self.batch_button, self.lasso_button, *self._buttons)  # fmt: skip

    # What is shown

    def _show_queue(self) -> None:
        session = self.session
        with QSignalBlocker(self.batch_box):
            self.batch_box.clear()
            for batch in session.batches:
                name = batch.name or self.tr("all ghosts")
                self.batch_box.addItem(f"{name}: {show_count(len(batch.places))}", batch.name)
            wanted = session.batch
            if wanted is not None:
                self.batch_box.setCurrentIndex(self.batch_box.findData(wanted.name))
        self.model.show_queue(session.plan, session.order)
        there = session.plan is not None and len(session.plan) > 0
        for widget in (self.batch_box, self.batch_button, self.after_button, self.apply_button,
                       *self._buttons):  # fmt: skip
            widget.setEnabled(there)
        self.after_button.setChecked(False)
        self._show_answers()
        self._show_ghost()

    def _show_answers(self) -> None:
        steps = self.controller.project.history.done
        self.done.setVisible(bool(steps) and steps[-1] is self._applied)
        plan, marks = self.session.plan, self.session.marks
        if plan is not None and marks is not None:
            self.model.show_answers(self.session.answers(), plan.answered(marks))
            self._count_soon()
        self._tell_proposal()
        state = self.controller.scan
        self.lasso_button.setEnabled(state is not None and len(state.selection) > 0)

    def _show_ghost(self) -> None:
        plan, place, row = self.session.plan, self.session.place, self.session.row
        if plan is None or place < 0:
            self.sentence.setText(
                self.tr("N shows the first one.") if plan is not None and len(plan) else ""
            )
        else:
            sentence = plan.explain(place)
            self.sentence.setText(sentence[0].upper() + sentence[1:] + ".")
        if row >= 0:
            index = self.model.index(row, 0)
            select = QItemSelectionModel.SelectionFlag
            with QSignalBlocker(self.table.selectionModel()):
                self.table.selectionModel().setCurrentIndex(
                    index, select.ClearAndSelect | select.Rows
                )
            self.table.scrollTo(index)
            self.table.viewport().update()
        self._tell_proposal()

    def _tell_proposal(self) -> None:
        plan, place, marks = self.session.plan, self.session.place, self.session.marks
        if plan is None or marks is None or place < 0:
            self.proposal.clear()
            return
        proposed = Answer(int(plan.proposal[place]))
        text = self.tr("Proposed: {0}").format(self.model.name(proposed))
        if plan.correctable[place]:
            text += self.tr(" ({0} along the beam, confidence {1})").format(
                say_length(float(plan.shift[place])), show_number(float(plan.confidence[place]))
            )
        if plan.answered(marks)[place]:
            given = Answer(int(marks[plan.ghosts[place]]))
            text += self.tr(". <b>Your answer: {0}</b>").format(self.model.name(given))
        self.proposal.setText(text)

    def _count_soon(self, *_: object) -> None:
        self._later.start()

    def _count(self) -> None:
        found = self.session.count(self.proposals.isChecked())
        if found is None:
            return
        given = int(np.count_nonzero(self.session.answers(proposals=False)))
        text = self.tr("{0} of {1} answered. ").format(show_count(given), show_count(found.ghosts))
        self.tally.setText(text + describe_short(found))
        self.tally.setToolTip(f"{describe_reasons(found)}{describe_leaves(found)}")

    # What the user does

    def _choose_batch(self, row: int) -> None:
        self.session.choose_batch(self.batch_box.itemData(row))
        self.table.setFocus()  # so that N goes on there

    def _on_row(self, *_: object) -> None:
        rows = self.table.selectionModel().selectedRows()
        if rows:
            self.session.go(rows[0].row())

    def _on_after(self, on: bool) -> None:
        self.after_button.setText(self.tr("Show be&fore") if on else self.tr("Show a&fter"))
        self.after_toggled.emit(on)

    def _answer_batch(self, answer: Answer | None, accept: bool) -> None:
        batch = self.session.batch
        if batch is not None:
            self.session.give(batch.places, answer, accept, batch.name)
        self.table.setFocus()

    def _answer_selected(self, answer: Answer | None, accept: bool) -> None:
        state = self.controller.scan
        places = self.session.select(EMPTY.indices if state is None else state.selection.indices)
        if not len(places):
            self.controller.said.emit(self.tr("There are no ghosts of the queue in the selection."))
        self.session.give(places, answer, accept, self.tr("the selection"))
        self.table.setFocus()

"""The profile in use: whose it is, what it gives, and which points it leaves without a value."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QLabel,
    QMenu,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.core.radiometry.marks import GOOD, WORDS
from app.core.radiometry.partial_hits import FULL_HIT
from app.core.radiometry.profile import Profile
from widgets.common.calibration.profile_words import Counts, describe_channel, title_channel
from widgets.common.fact_grid import FactGrid
from widgets.common.notice import Notice
from widgets.common.numbers import show_count, show_number


class ProfileInUse(QWidget):
    """Shows a profile and offers to change it; does nothing itself.

    Signals
    -------
    open_asked(), save_asked(), removed()
    ready_asked(Profile)
        A published profile is wanted.
    list_asked()
        The menu of published profiles opens for the first time.
    partial_asked(bool)
        Partial hits are to have a reflectance too, or not.
    compute_asked(str)
        The reflectance of all points is wanted, by the name of its field.
    """

    open_asked = Signal()
    save_asked = Signal()
    removed = Signal()
    ready_asked = Signal(object)
    list_asked = Signal()
    partial_asked = Signal(bool)
    compute_asked = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._first = ""
        self.name = QLabel(self)
        self.whose = Notice(self)
        self.whose.setProperty("notice", "warning")
        self.facts = FactGrid(self)
        self.open_button = QPushButton(self.tr("&Open profile…"), self)
        self.ready_button = QPushButton(self.tr("Pu&blished"), self)
        self.save_button = QPushButton(self.tr("Save &as…"), self)
        self.remove_button = QPushButton(self.tr("&Remove"), self)
        self.menu = QMenu(self.ready_button)
        self.ready_button.setMenu(self.menu)
        self.share = QLabel(self)
        self.reasons = FactGrid(self)
        self.compute_button = QPushButton(self.tr("Compute &reflectance"), self)
        self.partial = QCheckBox(self.tr("Use &partial hits too"), self)
        self.partial_words = QLabel(self)
        self._explain()
        self._lay_out()
        self._connect()

    def offer(self, ready: Iterable[Profile]) -> None:
        """Fill the menu of published profiles."""
        self.menu.clear()
        self.menu.setToolTipsVisible(True)
        for profile in ready:
            action = QAction(profile.name, self.menu)
            action.setToolTip("\n".join(profile.notes[:1]))
            action.setData(profile)
            self.menu.addAction(action)

    def show_profile(self, profile: Profile | None) -> None:
        """Show a profile, or that there is none."""
        there = profile is not None
        parts: tuple[QWidget, ...] = (
            self.name, self.facts, self.save_button, self.remove_button, self.share,
            self.compute_button, self.reasons, self.partial, self.partial_words,
        )  # fmt: skip
        for widget in parts:
            widget.setVisible(there)
        self.whose.say("")
        if profile is None:
            return
        self._first = profile.channels[0].name
        self.name.setText(f"<b>{profile.name}</b>")
        self.name.setToolTip("\n".join(profile.notes))
        if profile.origin == "published":
            self.whose.say(self.tr(
                "Published, not yours: measured on another instrument of this make. For numbers "
                "to rely on, calibrate with panels of your own."
            ))  # fmt: skip
        self.facts.show_facts((title_channel(c), describe_channel(c)) for c in profile.channels)

    def show_counts(self, field: str, counts: Counts | None, points: int, total: int) -> None:
        """Tell how many points have the field and why the others do not; None: not known yet."""
        self.compute_button.setVisible(counts is None or points < total)
        self.share.setVisible(counts is not None)
        missing = {} if counts is None else {w: n for w, n in counts.items() if w != WORDS[GOOD]}
        self.reasons.setVisible(bool(missing))
        if counts is None:
            return
        good = counts.get(WORDS[GOOD], 0)
        text = self.tr("<b>{n} of {total} points</b> have a {field}.")
        self.share.setText(
            text.format(n=show_count(good), total=show_count(points), field=field)
        )  # fmt: skip
        self.reasons.show_facts((self._name(word), _tell(n, points)) for word, n in missing.items())

    def show_partial(self, used: bool, words: str) -> None:
        """Show whether partial hits count, and how they were looked for."""
        with QSignalBlocker(self.partial):
            self.partial.setChecked(used)
        told = self._found_how()
        sentence = next((told[start] for start in told if words.startswith(start)), words)
        self.partial_words.setText(sentence)
        self.partial_words.setVisible(bool(words) and self.partial.isVisibleTo(self))

    def _name(self, word: str) -> str:
        return self._words().get(word, word)

    def _words(self) -> Mapping[str, str]:
        names = (
            self.tr("with a value"),
            self.tr("No signal"),
            self.tr("Dark"),
            self.tr("Saturated"),
            self.tr("Outside the calibrated ranges"),
            self.tr("Outside the response"),
            self.tr("Partial hit"),
        )
        return dict(zip(WORDS, names, strict=True))

    def _found_how(self) -> Mapping[str, str]:
        return {
            "not looked for: the beam": self.tr(
                "Partial hits are not looked for: the beam is unknown. Give it in the Angles panel."
            ),
            "not looked for: the scanner's position": self.tr(
                "Partial hits are not looked for: the scanner's position is unknown."
            ),
            "not looked for: the scan": self.tr(
                "Partial hits are not looked for: the scan has no rows and columns."
            ),
            "left out": self.tr(
                "Points with less than {0} % of the beam on their surface count as partial hits."
            ).format(f"{100 * FULL_HIT:g}"),
            "taken along": self.tr("Partial hits read too dark: take care with edges."),
        }

    def _explain(self) -> None:
        for button, tip in (
            (self.open_button, self.tr("A profile that was saved, as a TOML file")),
            (self.ready_button, self.tr("Profiles made of what papers published")),
            (self.save_button, self.tr("Keep this profile for other scans of the instrument")),
            (self.remove_button, self.tr("Use no profile; undo brings it back")),
            (self.compute_button, self.tr("Compute the reflectance of all points")),
            (self.partial, self.tr("Points that the beam hits in part: its intensity comes from "
                                   "two surfaces or from none")),
        ):  # fmt: skip
            button.setToolTip(tip)
        for label in (self.name, self.share, self.partial_words):
            label.setWordWrap(True)
        self.partial_words.setProperty("faint", "true")

    def _lay_out(self) -> None:
        buttons = QGridLayout()
        for place, button in enumerate(
            (self.open_button, self.ready_button, self.save_button, self.remove_button)
        ):
            buttons.addWidget(button, place // 2, place % 2)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.name)
        layout.addWidget(self.whose)
        layout.addWidget(self.facts)
        layout.addLayout(buttons)
        layout.addWidget(self.share)
        layout.addWidget(self.reasons)
        layout.addWidget(self.compute_button)
        layout.addWidget(self.partial)
        layout.addWidget(self.partial_words)

    def _connect(self) -> None:
        self.open_button.clicked.connect(self.open_asked)
        self.save_button.clicked.connect(self.save_asked)
        self.remove_button.clicked.connect(self.removed)
        self.menu.triggered.connect(lambda action: self.ready_asked.emit(action.data()))
        self.menu.aboutToShow.connect(self._ask_list)
        self.partial.clicked.connect(self.partial_asked)
        self.compute_button.clicked.connect(lambda: self.compute_asked.emit(self._first))

    def _ask_list(self) -> None:
        if self.menu.isEmpty():
            self.list_asked.emit()


def _tell(count: int, points: int) -> str:
    return f"{show_count(count)} ({show_number(100.0 * count / max(points, 1), 1)} %)"

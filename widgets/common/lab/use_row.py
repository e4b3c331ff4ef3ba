"""Fit, use, and what is in use."""

from __future__ import annotations

from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.model.parameters import Curve
from app.model.state import ScanState


class UseRow(QWidget):
    """The two buttons that matter most, with the curve in use said below them."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.fit_button = QPushButton(self.tr("&Fit"), self)
        self.use_button = QPushButton(self.tr("&Use this curve"), self)
        self.in_use, self.aside = QLabel(self), QLabel(self)
        self.fit_button.setToolTip(
            self.tr("Find the curves that lie closest: of all ticked channels, in one step")
        )
        self.use_button.setToolTip(
            self.tr("Read angles from intensity by this curve: wrinkles and Δω rest on it")
        )
        self.fit_button.setProperty("primary", "true")
        for label in (self.in_use, self.aside):
            label.setWordWrap(True)
        self.aside.setProperty("faint", "true")
        self.aside.hide()
        buttons = QHBoxLayout()
        buttons.addWidget(self.fit_button)
        buttons.addWidget(self.use_button)
        buttons.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.aside)
        layout.addLayout(buttons)
        layout.addWidget(self.in_use)

    def tell_use(self, curve: Curve | None) -> None:
        """Say which curve is in use."""
        text = self.tr("No curve is in use yet.")
        if curve is not None:
            text = self.tr("In use: {model} on {channel}, {origin}.").format(
                model=curve.angular_model.title,
                channel=curve.channel,
                origin=curve.origin or self.tr("origin unknown"),
            )
        if text != self.in_use.text():  # else each move of a slider would lay the panel out anew
            self.in_use.setText(text)

    def tell_aside(
        self, state: ScanState, channels: tuple[str, ...], count: int, most: int
    ) -> None:
        """Say what the plot cannot: curves that are not drawn, units that differ."""
        said = []
        if count > most:
            said.append(
                self.tr("{n} of {all} curves are drawn; all of them are fitted.").format(
                    n=most, all=count
                )
            )
        if len({state.channel(name).kind for name in channels}) > 1:
            said.append(self.tr("The ticked channels have different units on one axis."))
        self.aside.setText(" ".join(said))
        self.aside.setVisible(bool(said))

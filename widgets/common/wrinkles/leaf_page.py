"""Pages of one leaf: its map, its distribution, its numbers."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel, QTabBar, QVBoxLayout, QWidget

from app.core.wrinkling.shape import RULE
from app.services.leaves import Row
from app.services.wrinkles.measure import LeafWrinkles
from app.services.wrinkles.picture import find_limit
from widgets.common.fact_grid import FactGrid
from widgets.common.wrinkles.leaf_views import LeafViews
from widgets.common.wrinkles.spread_plot import SpreadPlot
from widgets.common.wrinkles.words import list_facts, tell_reasons, tell_shape, tell_title


class LeafPage(QWidget):
    """One page is seen at a time; the title stays."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.found: LeafWrinkles | None = None
        self.title = QLabel(self)
        self.tabs = QTabBar(self)
        self.views = LeafViews(self)
        self.plot = SpreadPlot(self)
        self.shape = QLabel(self)
        self.rule = QLabel(RULE[0].upper() + RULE[1:] + ".", self)
        self.facts = FactGrid(self)
        self.spread = QWidget(self)
        self._explain()
        self._lay_out()
        self._turn()
        self.tabs.currentChanged.connect(self._turn)

    def show_leaf(self, found: LeafWrinkles, row: Row) -> None:
        """Show a leaf that was judged."""
        self.found, judged = found, found.judged
        if judged is None:
            return
        self.title.setText(tell_title(found, row))
        self.views.show_leaf(found)
        known = judged.spread is not None
        self.plot.setVisible(known)
        if judged.spread is not None:
            self.plot.show_distribution(judged.spread, find_limit([judged]))
        self.shape.setText(tell_shape(judged) if known else tell_reasons(judged))
        self.facts.show_facts(list_facts(found, row))

    def _turn(self, _: int = 0) -> None:
        pages = (self.views, self.spread, self.facts)
        for number, page in enumerate(pages):
            page.setVisible(number == self.tabs.currentIndex())

    def _explain(self) -> None:
        for title, tip in (
            (self.tr("Map"), self.tr("The leaf from the scanner and from the side")),
            (self.tr("Distribution"), self.tr("How the Δω of its points are spread")),
            (self.tr("Numbers"), self.tr("Angles, errors and their parts, offset, curve")),
        ):
            self.tabs.setTabToolTip(self.tabs.addTab(title), tip)
        self.tabs.setAccessibleName(self.tr("Pages of the leaf"))
        self.tabs.setExpanding(True)
        for label in (self.title, self.shape, self.rule):
            label.setWordWrap(True)
        self.rule.setProperty("faint", "true")
        self.facts.setToolTip(
            self.tr(
                "Noise differs from point to point; errors of curve, reflectance and offset are "
                "shared by the whole leaf."
            )
        )

    def _lay_out(self) -> None:
        inner = QVBoxLayout(self.spread)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.addWidget(self.plot)
        inner.addWidget(self.shape)
        inner.addWidget(self.rule)
        inner.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for part in (self.title, self.tabs, self.views, self.spread, self.facts):
            layout.addWidget(part)

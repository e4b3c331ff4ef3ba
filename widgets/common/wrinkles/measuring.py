"""Has wrinkles measured in the worker and keeps what was found, scan by scan."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal

from app.core.progress import Progress
from app.model.fields import Same, Values
from app.model.leaf import join_members
from app.model.project import Project
from app.model.state import State
from app.services.leaves import Row
from app.services.wrinkles.fields import fields_of
from app.services.wrinkles.measure import LeafWrinkles, ScanWrinkles, measure_wrinkles
from app.services.wrinkles.request import OwnCurve, WrinkleRequest
from app.services.wrinkles.table import tabulate
from widgets.common.aside import copy_aside
from widgets.common.lab.asking import Asking
from widgets.controller import Controller

FOR_ANGLES = 0.5
"""Share of the work that local planes are, where a leaf's own curve needs them."""


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What was found of a scan, and for what.

    Attributes
    ----------
    found : ScanWrinkles
    leaves : mapping of str to LeafWrinkles
    rows : mapping of str to Row
        By the key of the leaf, as tables have them.
    mark : hashable
        All that it rests on.
    fields : mapping of str to Values
        For the document: wrinkles, and angles that were found on the way.
    """

    found: ScanWrinkles
    leaves: Mapping[str, LeafWrinkles]
    rows: Mapping[str, Row]
    mark: Hashable
    fields: Mapping[str, Values]


class Measuring(QObject):
    """One measurement at a time; the latest of each scan is kept.

    Signals
    -------
    changed()
        Something was found, or a measurement began or ended.
    refused(str)
        Why nothing was found.
    progressed(float, str)
    """

    changed = Signal()
    refused = Signal(str)
    progressed = Signal(float, str)

    def __init__(self, controller: Controller, parent: QObject) -> None:
        super().__init__(parent)
        self._controller = controller
        self._found: dict[str, Measured] = {}
        self._asking = Asking(controller, self)
        self._asking.changed.connect(self.changed)
        self._asking.refused.connect(self.refused)
        self._asking.progressed.connect(self.progressed)

    @property
    def busy(self) -> bool:
        """Whether a measurement is under way."""
        return self._asking.busy

    def find(self, scan: str | None) -> Measured | None:
        """What is known of a scan, stale or not."""
        return self._found.get(scan or "")

    def is_stale(self, scan: str, request: WrinkleRequest) -> bool:
        """Whether what is known rests on something else than what is there and asked now."""
        held = self._found.get(scan)
        return held is not None and held.mark != _mark(
            self._controller.project.state, scan, request
        )

    def measure(self, scan: str, request: WrinkleRequest) -> None:
        """Measure all leaves of a scan."""
        project = self._controller.project
        aside, known = copy_aside(project, scan), project.cache.known(scan)
        mark = _mark(project.state, scan, request)

        def work(progress: Progress) -> Measured:
            found = _measure(aside, scan, request, progress)
            rows = {str(row["leaf"]): row for row in tabulate(found)}
            fresh = {
                name: values
                for name, values in aside.cache.known(scan).items()
                if values is not known.get(name)
            }
            leaves = {leaf.leaf.key: leaf for leaf in found.leaves}
            return Measured(found, leaves, rows, mark, fresh | fields_of(aside, scan, found))

        def done(measured: Measured) -> None:
            if project is self._controller.project:
                self._found[scan] = measured
                project.accept(scan, measured.fields)
                self.changed.emit()

        self._asking.ask(self.tr("Measuring wrinkles"), work, done)

    def cancel(self) -> None:
        """Stop the measurement; what was known before stays."""
        self._asking.cancel()

    def forget(self) -> None:
        """The document is another one."""
        self._asking.cancel()
        self._found.clear()


def _measure(
    aside: Project, scan: str, request: WrinkleRequest, progress: Progress
) -> ScanWrinkles:
    if isinstance(request.source, OwnCurve):  # all its local planes, not a few of each leaf
        state = aside.state.scan(scan)
        points = join_members(aside.state.leaves_of(scan), len(state.scan))
        aside.field(scan, "incidence", points[state.alive[points]], progress.part(0.0, FOR_ANGLES))
        progress = progress.part(FOR_ANGLES, 1.0)
    return measure_wrinkles(aside, scan, request, None, progress)


def _mark(state: State, scan: str, request: WrinkleRequest) -> Hashable:
    """All that wrinkles rest on."""
    if scan not in state.scans:
        return None
    held = state.scan(scan)
    parameters = held.parameters
    return (
        request,
        tuple((leaf.key, Same(leaf.members)) for leaf in state.leaves_of(scan)),
        Same(held.scan.xyz),
        Same(held.deleted),
        Same(held.marks),
        held.scan.pose,
        held.channels,
        parameters.curve,
        parameters.channel,
        parameters.radiometry,
        parameters.radius,
        parameters.estimator,
        parameters.ghost_threshold,
    )

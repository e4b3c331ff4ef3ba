"""A click in the picture becomes a point: looked for among all points, in the worker."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject, Signal

from app.core.progress import Progress
from app.core.radiometry.marks import WORDS
from app.core.screen import View, pick, project
from app.core.units import to_degrees
from app.model.calibrated import calibrated_channels
from app.model.fields import Values
from app.model.project import Project
from app.model.radiometry_fields import SIGMA
from widgets.common.numbers import show_with_sd
from widgets.controller import Controller
from widgets.fields_at_hand import find_calibration, why_not

REACH = 6.0  # pixels around the cursor
ANSWERED = ("range", "incidence_sigma")  # which computes the incidence too

Found = tuple[str, int] | None
Value = tuple[str, str | float | int, str]


class Picker(QObject):
    """Finds the point that a click means, and all that is known of it.

    Signals
    -------
    picked()
        There is a point.
    found(str, int)
        The same, with its scan and its number.
    described(list)
        Names, values and units; again when the incidence of the point is computed.
    """

    picked = Signal()
    found = Signal(str, int)
    described = Signal(object)

    def __init__(self, controller: Controller, parent: QObject) -> None:
        super().__init__(parent)
        self._controller = controller
        self.point: Found = None

    def pick(self, view: View, x: float, y: float, scale: float = 1.0) -> None:
        """Look for the point at a place.

        Parameters
        ----------
        view : View
        x, y : float
            Shares of the viewport, y down.
        scale : float
            Device pixels per pixel of the hand.
        """
        scans = self._controller.project.state.scans
        clouds = [(c.scan, scans[c.scan]) for c in self._controller.scene.clouds]
        place = (x * view.size[0], y * view.size[1])

        def work(progress: Progress) -> Found:
            found: list[tuple[float, str, int]] = []
            for number, (key, state) in enumerate(clouds):
                progress.report(number / len(clouds))
                where = project(state.scan.xyz, view.origin, view.matrix, view.size)
                mask = where.inside & state.alive
                row = pick(where.px, where.depth, mask, place, REACH * scale)
                if row >= 0:
                    found.append((float(where.depth[row]), key, row))
            return min(found)[1:] if found else None

        self._controller.run(self.tr("Picking"), work, self._tell)

    def take(self, scan: str, row: int) -> None:
        """Take a point that is known: a click in the scan image."""
        self._tell((scan, row))

    def _tell(self, found: Found) -> None:
        if found is None:
            self._controller.said.emit(self.tr("There is no point here."))
            return
        self.point = found
        key, row = found
        self.picked.emit()
        self.found.emit(key, row)
        self._describe()
        rows = np.array([row])
        for field in (*ANSWERED, *self._calibrated(key)):
            if not why_not(self._controller.project, key, field):
                self._controller.want(key, field, rows, self._describe)

    def _calibrated(self, scan: str) -> list[str]:
        """σ of the reflectances that a profile gives, which compute these and their marks too."""
        state = self._controller.project.state.scan(scan)
        channels = calibrated_channels(state.scan, state.parameters.profile)
        return [channel.name + SIGMA for channel in channels]

    def _describe(self) -> None:
        if self.point is not None:
            self.described.emit(describe_point(self._controller.project, *self.point))


def _measure(project: Project, scan: str, name: str, known: Values, row: int) -> str | float:
    """The value; angle and reflectance with their error, or why there is no reflectance."""
    value = float(known.values[row])
    calibration = find_calibration(project.state.scan(scan), name)
    if calibration is not None and "mark" in known.beside:
        error = project.known_field(scan, name + SIGMA)
        if not np.isfinite(value):
            return WORDS[int(known.beside["mark"][row])]
        there = error is not None and error.have[row]
        return show_with_sd(value, float(error.values[row]) if error and there else None)
    sigma = known.beside.get("sigma") if name == "incidence" else None
    if sigma is None or not np.isfinite(sigma[row]):
        return value
    return show_with_sd(value, float(to_degrees(sigma[row])))


def describe_point(project: Project, scan: str, row: int) -> list[Value]:
    """All that is known of a point; computes nothing."""
    state = project.state.scan(scan)
    x, y, z = (float(value) for value in state.scan.xyz[row])
    values: list[Value] = [("Scan", state.scan.name, ""), ("Number in the file", row, "")]
    values += [("x", x, "m"), ("y", y, "m"), ("z", z, "m")]
    if state.scan.grid is not None:
        values.append(("Row", int(state.scan.grid.row[row]), ""))
        values.append(("Column", int(state.scan.grid.column[row]), ""))
    for name, spec in project.catalogue(scan).items():
        held = state.scan.attributes.get(name)
        known = project.known_field(scan, name)
        if held is not None:
            values.append((spec.title, held[row].item(), spec.unit))
        elif known is not None and known.have[row]:
            values.append((spec.title, _measure(project, scan, name, known, row), spec.unit))
    leaves = [leaf.name for leaf in project.state.leaves_of(scan) if row in leaf.members.indices]
    if leaves:
        values.append(("Leaf", ", ".join(leaves), ""))
    return values

"""Fits asked for in the lab: in the worker, one step of the history however many they are."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QObject, Signal

from app.core.arrays import Ints
from app.core.progress import Progress
from app.model.fit_method import Method, usual_method
from app.model.leaf import FitRecord
from app.model.project import Project
from app.services.curves import fit_leaves, members_of
from app.services.lab.fit_table import SampleLeaves, record_fits, tabulate_fits
from app.services.lab.own_models import AnyModel
from widgets.common.curve_choice import Target
from widgets.controller import Controller

MOST_NAMED = 4


class LabFits(QObject):
    """Fits targets.

    Signals
    -------
    failed_cells(tuple)
        Sentences on those of several fits that could not be made.
    """

    failed_cells = Signal(object)

    def __init__(self, controller: Controller, parent: QObject) -> None:
        super().__init__(parent)
        self._controller = controller

    def fit(self, targets: Sequence[Target], model: AnyModel) -> None:
        """Fit a model to all targets; they share scan and method."""
        if not targets:
            return
        controller, scan = self._controller, targets[0].scan
        points = self._find_points(targets)

        def then() -> None:
            if len(targets) == 1:
                controller.carry_out(scan, self.tr("Fitting"), fit_one)
            else:
                controller.carry_out(scan, self.tr("Fitting"), fit_all, self._tell)

        def fit_one(aside: Project, progress: Progress) -> FitRecord:
            (target,) = targets
            return fit_leaves(
                aside, scan, target.leaves, model, target.channel, progress,
                method=_unless_usual(target),
            )  # fmt: skip

        def fit_all(aside: Project, progress: Progress) -> tuple[str, ...]:
            return _fit_table(aside, targets, model, progress)

        controller.want(scan, "incidence", points, then)

    def _find_points(self, targets: Sequence[Target]) -> Ints | None:
        project, scan = self._controller.project, targets[0].scan
        if any(not target.leaves for target in targets):
            return None
        keys = dict.fromkeys(key for target in targets for key in target.leaves)
        return members_of(project, scan, list(keys))

    def _tell(self, sentences: tuple[str, ...]) -> None:
        self.failed_cells.emit(sentences)


def _fit_table(
    aside: Project, targets: Sequence[Target], model: AnyModel, progress: Progress
) -> tuple[str, ...]:
    """Fit all groups of leaves and all channels as one table."""
    scan = targets[0].scan
    groups = list(dict.fromkeys(target.leaves for target in targets))
    samples = name_samples(aside, groups)
    channels = list(dict.fromkeys(target.channel for target in targets))
    table = tabulate_fits(aside, scan, samples, channels, model, targets[0].method, progress)
    record_fits(aside, table)
    return tuple(
        f"{sample}, {channel}: {' '.join(cell.warnings)}"
        for (sample, channel), cell in table.cells.items()
        if cell.result is None
    )


def name_samples(project: Project, groups: Sequence[tuple[str, ...]]) -> list[SampleLeaves]:
    """Groups of leaves with names; those of the same name are told apart by their keys."""
    names = [name_group(project, group) for group in groups]
    return [
        SampleLeaves(name if names.count(name) == 1 else f"{name} ({'+'.join(group)})", group)
        for name, group in zip(names, groups, strict=True)
    ]


def name_group(project: Project, group: Sequence[str]) -> str:
    """Names of the leaves of a group."""
    names = [project.state.leaves[key].name for key in group]
    if not names:
        return "whole scan"
    return ", ".join(names) if len(names) <= MOST_NAMED else f"{len(names)} leaves"


def _unless_usual(target: Target) -> Method | None:
    return None if target.method == usual_method(target.leaves) else target.method

"""All that a command asks of groups of pairs: fits, comparisons, intervals, in one report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput, WrongUse
from app.core.fitting.bootstrap import COUNT, MOST_COUNT
from app.core.progress import QUIET, Progress
from app.model.fit_method import Method
from app.services.fit import POINTS, FitReport, fit_groups
from app.services.lab.compare import ModelTable, compare
from app.services.lab.gather import Measured
from app.services.lab.own_models import AnyModel, find_model
from app.services.lab.uncertainty import IntervalRow, bootstrap, profile
from app.services.table_notes import tell_negative

Labels = Mapping[str, str]
NONE = np.empty(0, np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class PairGroup:
    """Pairs that are fitted together.

    Attributes
    ----------
    labels : mapping of str to str
    angle, value : (n,) arrays
        Angles in degrees.
    leaf : (n,) array of int
        Number of the leaf of each pair, for a bootstrap; empty where nobody asks.
    notes : tuple of str
        What is to be said of the table that they come from.
    """

    labels: Labels
    angle: Floats
    value: Floats
    leaf: Ints = field(default_factory=lambda: NONE)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class FitOrder:
    """What is to be done with each group.

    Attributes
    ----------
    model : str, AngularModel, FormulaDefinition or None
        None fits nothing: models are compared only.
    method : Method
    compare : bool
        Set all models side by side.
    profile : bool
        Profile intervals.
    trials : int or None
        Of a bootstrap by leaf; None for none.
    fixed : mapping of str to float
    """

    model: AnyModel | None
    method: Method = POINTS
    compare: bool = False
    profile: bool = False
    trials: int | None = None
    fixed: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.model is None and not self.compare:
            raise WrongUse("Say which model is fitted.", "Or compare all of them.")
        if self.model is None and (self.profile or self.trials is not None or self.fixed):
            raise WrongUse("Intervals and fixed parameters are of one model; say which.")
        if self.trials is not None and not 1 <= self.trials <= MOST_COUNT:
            raise WrongUse(f"A bootstrap takes 1 to {MOST_COUNT} trials, not {self.trials}.")


@dataclass(frozen=True, slots=True)
class Asked:
    """Rows of one group, or the sentence that says why there are none."""

    labels: Labels
    rows: tuple[IntervalRow, ...] = ()
    words: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Intervals by parameter; the words under ``words``."""
        return {row.name: row.as_dict() for row in self.rows} | (
            {"words": self.words} if self.words else {}
        )


@dataclass(frozen=True, slots=True)
class LabReport:
    """What was found of all groups, each in the order of the groups; notes are of all of them."""

    fits: FitReport
    comparisons: tuple[tuple[Labels, ModelTable | str], ...] = ()
    profiles: tuple[Asked, ...] = ()
    bootstraps: tuple[Asked, ...] = ()
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The JSON answer of the commands that fit."""
        found = self.fits.as_dict()
        for name, asked in (("profile", self.profiles), ("bootstrap", self.bootstraps)):
            for entry, one in zip(found["fits"] if asked else (), asked, strict=True):
                entry[name] = one.as_dict()
        if self.comparisons:
            found["comparisons"] = [_compared(*one) for one in self.comparisons]
        return found | {"notes": list(self.notes)}


def _compared(labels: Labels, table: ModelTable | str) -> dict[str, Any]:
    if isinstance(table, str):
        return {"group": dict(labels), "models": [], "note": table}
    return {"group": dict(labels), "models": table.as_rows(), "note": table.note}


def carry_out(
    groups: Sequence[PairGroup], order: FitOrder, progress: Progress = QUIET
) -> LabReport:
    """Do what is ordered; a group that cannot be fitted says why and stops nothing.

    Raises
    ------
    WrongUse
        Unknown model or parameter; intervals of a fit that has none.
    Cancelled
    """
    count = 1 + order.compare + order.profile + (order.trials is not None)
    shares = iter([progress.part(k / count, (k + 1) / count) for k in range(count)])
    part, model = next(shares), order.model
    tables = _compare_all(groups, order, next(shares)) if order.compare else ()
    notes = _take_notes(groups, order)
    if model is None:
        return LabReport(FitReport((), order.method), tables, notes=notes)
    sets = [(group.labels, group.angle, group.value) for group in groups]
    fits = fit_groups(sets, model, method=order.method, fixed=order.fixed, progress=part)
    profiles = _profile_all(groups, model, order, next(shares)) if order.profile else ()
    draws = _bootstrap_all(groups, model, order, next(shares)) if order.trials is not None else ()
    return LabReport(fits, tables, profiles, draws, notes)


def _take_notes(groups: Sequence[PairGroup], order: FitOrder) -> tuple[str, ...]:
    """What is to be said of the pairs, each sentence once."""
    notes = dict.fromkeys(note for group in groups for note in group.notes)
    turned = order.model is not None and find_model(order.model).accepts(np.array([-0.1])).all()
    for group in () if turned else groups:
        notes |= dict.fromkeys(tell_negative(group.angle))
    return tuple(notes)


Each = Iterator[tuple[PairGroup, Progress]]


def _each(groups: Sequence[PairGroup], progress: Progress) -> Each:
    """Each group with its part of the progress."""
    for place, group in enumerate(groups):
        yield group, progress.part(place / len(groups), (place + 1) / len(groups))


def _compare_all(
    groups: Sequence[PairGroup], order: FitOrder, progress: Progress
) -> tuple[tuple[Labels, ModelTable | str], ...]:
    found: list[tuple[Labels, ModelTable | str]] = []
    for group, part in _each(groups, progress):
        try:
            table = compare(group.angle, group.value, None, order.method, part)
            found.append((group.labels, table))
        except BadInput as error:
            found.append((group.labels, str(error)))
    return tuple(found)


def _profile_all(
    groups: Sequence[PairGroup], model: AnyModel, order: FitOrder, progress: Progress
) -> tuple[Asked, ...]:
    found = []
    for group, part in _each(groups, progress):
        part.report(0.0, "Looking for intervals")
        try:
            rows = profile(order.method, model, group.angle, group.value, fixed=order.fixed)
            found.append(Asked(group.labels, rows))
        except BadInput as error:
            found.append(Asked(group.labels, words=str(error)))
    return tuple(found)


def _bootstrap_all(
    groups: Sequence[PairGroup], model: AnyModel, order: FitOrder, progress: Progress
) -> tuple[Asked, ...]:
    found = []
    for group, part in _each(groups, progress):
        try:
            if len(group.leaf) != len(group.angle):
                raise BadInput("A bootstrap by leaf needs the leaf of each pair.")
            points = np.arange(len(group.angle))
            measured = Measured(group.angle, group.value, points, group.leaf)
            rows = bootstrap(
                order.method, model, measured, order.trials or COUNT,
                fixed=order.fixed, progress=part,
            )  # fmt: skip
            found.append(Asked(group.labels, rows))
        except BadInput as error:
            found.append(Asked(group.labels, words=str(error)))
    return tuple(found)

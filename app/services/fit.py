"""Fit angular models to groups of a table; degrees outside, radians inside."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.core.arrays import Floats
from app.core.fitting import FitResult
from app.core.phase.angular import AngularModel
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees
from app.model.fit_method import Method
from app.services.lab.batch import fit_sets
from app.services.lab.own_models import AnyModel, find_model
from app.services.tables import MISSING, Table, read_table

Group = tuple[Mapping[str, str], Floats, Floats]
POINTS = Method()


@dataclass(frozen=True, slots=True)
class GroupFit:
    """The fit of one group, or why there is none.

    Attributes
    ----------
    group : mapping of str to str
        Column and value that the rows share; empty without grouping.
    model : AngularModel
    n : int
        Pairs used, or pairs there were if they could not be fitted.
    result : FitResult or None
    warnings : tuple of str
    """

    group: Mapping[str, str]
    model: AngularModel
    n: int
    result: FitResult | None
    warnings: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """The entry of the JSON answer; a group without a fit has null for every number."""
        r = self.result
        spans = {p.name: r.interval(p.name) if r else None for p in self.model.parameters}
        return {
            "group": dict(self.group),
            "model": self.model.name,
            "n": self.n,
            "parameters": {p.name: _describe(r, p.name, p.unit) for p in self.model.parameters},
            "rss": r.rss if r else None,
            "warnings": list(self.warnings),
            "intervals": {name: list(span) if span else None for name, span in spans.items()},
            "covariance": r.covariance if r else {},
            "rmse": r.rmse if r else None,
            "r2": r.r2 if r else None,
            **criteria_of(r),
            "angles_deg": [float(to_degrees(angle)) for angle in r.angle_range] if r else None,
            "kind": r.kind if r else None,
            "tau": r.tau if r else None,
            "scale": r.scale if r else None,
        }


def criteria_of(result: FitResult | None) -> dict[str, float | None]:
    """AIC, AICc and BIC of a least-squares fit; other fits have none."""
    if result is None or result.kind in ("edge", "huber", "tukey"):
        return {"aic": None, "aicc": None, "bic": None}
    return {"aic": result.aic, "aicc": result.aicc, "bic": result.bic}


def _describe(result: FitResult | None, name: str, unit: str) -> dict[str, Any]:
    if result is None:
        return {"value": None, "sd": None, "unit": unit}
    found = result.parameters[name]
    return {"value": found.value, "sd": found.sd, "unit": unit}


@dataclass(frozen=True, slots=True)
class FitReport:
    """Fits of all groups, in the order in which the groups appear."""

    fits: tuple[GroupFit, ...]
    method: Method = POINTS

    def as_dict(self) -> dict[str, Any]:
        """The JSON answer of ``leafscope fit``."""
        return {
            "method": self.method.as_dict(),
            "fits": [one.as_dict() for one in self.fits],
        }


def fit_groups(
    groups: Iterable[Group],
    model: AnyModel,
    *,
    method: Method = POINTS,
    fixed: Mapping[str, float] | None = None,
    progress: Progress = QUIET,
) -> FitReport:
    """Fit each group on its own; one that cannot be fitted does not stop the others.

    Parameters
    ----------
    groups : iterable of (labels, angles in degrees, values)
    model : str, AngularModel or FormulaDefinition
    method : Method
        To what, and how.
    fixed : mapping of str to float, optional
        Parameters that are not fitted.
    progress : Progress

    Raises
    ------
    WrongUse
        Unknown model or parameter, or a model that the method does not suit.
    """
    known, groups = find_model(model), list(groups)
    sets = [(angle_deg, value) for _, angle_deg, value in groups]
    found = fit_sets(sets, known, method, fixed, progress)
    fits = [
        GroupFit(labels, known, one.n, one, one.warnings)
        if isinstance(one, FitResult)
        else GroupFit(labels, known, len(value), None, (str(one),))
        for (labels, _, value), one in zip(groups, found, strict=True)
    ]
    return FitReport(tuple(fits), method)


def fit_table(
    path: str | Path,
    x: str,
    y: str,
    group: Sequence[str],
    model: AnyModel,
    *,
    method: Method = POINTS,
    fixed: Mapping[str, float] | None = None,
    progress: Progress = QUIET,
) -> FitReport:
    """Fit a table of angles and values, one curve per group.

    Parameters
    ----------
    path : str or Path
        CSV with a header, see `app.services.tables.read_table`.
    x, y : str
        Columns of the angle, degrees, and of the value.
    group : sequence of str
        Rows that agree in these columns belong together; may be empty.
    model, method, fixed, progress
        See `fit_groups`.

    Raises
    ------
    WrongUse
        Unknown model or parameter.
    BadInput
        The table cannot be read, lacks a column or has a cell that is not a number.
    """
    known = find_model(model)
    table = read_table(path, (x, y, *group))
    groups = split_table(table, x, y, group)
    return fit_groups(groups, known, method=method, fixed=fixed, progress=progress)


def split_table(table: Table, x: str, y: str, group: Sequence[str]) -> list[Group]:
    """The groups of a table, in the order in which they appear."""
    angle, value = table.numbers(x, MISSING), table.numbers(y, MISSING)
    rows = group_rows(table, group)
    return [
        (dict(zip(group, label, strict=True)), angle[chosen], value[chosen])
        for label, chosen in rows.items()
    ]


def group_rows(table: Table, group: Sequence[str]) -> dict[tuple[str, ...], list[int]]:
    """Numbers of the rows that agree in some columns, by what they agree in."""
    labels = (
        zip(*(table.columns[name] for name in group), strict=True) if group else [()] * len(table)
    )
    rows: dict[tuple[str, ...], list[int]] = {}
    for row, label in enumerate(labels):
        rows.setdefault(label, []).append(row)
    return rows

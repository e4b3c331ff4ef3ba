"""Fit angular models to tables and points; degrees outside, radians inside."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.fitting import FitResult, fit
from app.core.phase import PhaseModel, get_model
from app.core.progress import QUIET, Progress
from app.core.units import to_radians
from app.services.tables import Table, read_table

Group = tuple[Mapping[str, str], Floats, Floats]


@dataclass(frozen=True, slots=True)
class GroupFit:
    """The fit of one group, or why there is none.

    Attributes
    ----------
    group : mapping of str to str
        Column and value that the rows share; empty without grouping.
    model : str
    n : int
        Pairs used, or pairs there were if they could not be fitted.
    result : FitResult or None
    warnings : tuple of str
    """

    group: Mapping[str, str]
    model: str
    n: int
    result: FitResult | None
    warnings: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """The entry of the JSON answer; a group without a fit has null for every number."""
        fitted = self.result.parameters if self.result else {}
        parameters = {
            p.name: {
                "value": fitted[p.name].value if fitted else None,
                "sd": fitted[p.name].sd if fitted else None,
                "unit": p.unit,
            }
            for p in get_model(self.model).parameters
        }
        return {
            "group": dict(self.group),
            "model": self.model,
            "n": self.n,
            "parameters": parameters,
            "rss": self.result.rss if self.result else None,
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True, slots=True)
class FitReport:
    """Fits of all groups, in the order in which the groups appear."""

    fits: tuple[GroupFit, ...]

    def as_dict(self) -> dict[str, Any]:
        """The JSON answer of ``leafscope fit``."""
        return {"fits": [one.as_dict() for one in self.fits]}


def fit_points(
    angle_deg: Floats,
    value: Floats,
    model: PhaseModel | str,
    *,
    weights: Floats | None = None,
    fixed: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit one curve to points; the angles of several leaves may simply be joined.

    Parameters
    ----------
    angle_deg : (n,) array
        Degrees.
    value : (n,) array
    model, weights, fixed
        See `app.core.fitting.fit`, which also names the errors.
    """
    return fit(model, to_radians(np.asarray(angle_deg)), value, weights=weights, fixed=fixed)


def fit_groups(
    groups: Iterable[Group],
    model: PhaseModel | str,
    *,
    fixed: Mapping[str, float] | None = None,
    progress: Progress = QUIET,
) -> FitReport:
    """Fit each group on its own; one that cannot be fitted does not stop the others.

    Parameters
    ----------
    groups : iterable of (labels, angles in degrees, values)
    model, fixed
        See `app.core.fitting.fit`.
    progress : Progress

    Raises
    ------
    WrongUse
        Unknown model or parameter.
    """
    model = get_model(model) if isinstance(model, str) else model
    groups = list(groups)
    fits = []
    for done, (labels, angle_deg, value) in enumerate(groups):
        progress.report(done / len(groups), f"Fitting {model.title}")
        fits.append(_fit_group(labels, angle_deg, value, model, fixed))
    return FitReport(tuple(fits))


def _fit_group(
    labels: Mapping[str, str],
    angle_deg: Floats,
    value: Floats,
    model: PhaseModel,
    fixed: Mapping[str, float] | None,
) -> GroupFit:
    try:
        result = fit_points(angle_deg, value, model, fixed=fixed)
    except BadInput as error:
        return GroupFit(labels, model.name, len(value), None, (str(error),))
    return GroupFit(labels, model.name, result.n, result, result.warnings)


def fit_table(
    path: str | Path,
    x: str,
    y: str,
    group: Sequence[str],
    model: str,
    *,
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
    model, fixed, progress
        See `fit_groups`.

    Raises
    ------
    WrongUse
        Unknown model or parameter.
    BadInput
        The table cannot be read, lacks a column or has a cell that is not a number.
    """
    known = get_model(model)
    table = read_table(path, (x, y, *group))
    return fit_groups(_split(table, x, y, group), known, fixed=fixed, progress=progress)


def _split(table: Table, x: str, y: str, group: Sequence[str]) -> list[Group]:
    angle, value = table.numbers(x), table.numbers(y)
    rows: dict[tuple[str, ...], list[int]] = {}
    labels = (
        zip(*(table.columns[name] for name in group), strict=True) if group else [()] * len(table)
    )
    for row, label in enumerate(labels):
        rows.setdefault(label, []).append(row)
    return [
        (dict(zip(group, label, strict=True)), angle[chosen], value[chosen])
        for label, chosen in rows.items()
    ]

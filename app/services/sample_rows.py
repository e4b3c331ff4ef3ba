"""What a table says of one sample: means of its channels, indices of them, pairs if asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import WrongUse
from app.core.indices import NamedIndex
from app.core.sample_means import (
    IndexOfMeans,
    Mean,
    covariance_of_means,
    index_of_means,
    mean_of,
    mean_of_index,
    pair_nearest,
)
from app.model.project import Project
from app.services.error_budget import explain_reflectance
from app.services.leaves import Row


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """A channel of one of the scans, under a name that is its own in the table."""

    name: str
    scan: str
    channel: str
    wavelength_nm: float | None
    kind: str
    calibrated: bool = False


class Sample:
    """One sample: its points in each scan that holds it."""

    def __init__(self, project: Project, members: Mapping[str, Ints]) -> None:
        self.project, self.members = project, members

    def values(self, column: Column) -> Floats:
        """Values of a channel at the sample's points; none where its scan has not the sample."""
        if column.scan not in self.members:
            return np.empty(0)
        return self.project.field(column.scan, column.channel, self.members[column.scan])

    def describe(self, column: Column) -> Row:
        """Mean, sd, standard error and count of a channel; of a calibrated one σ of its mean."""
        row = _tell(column.name, mean_of(self.values(column)))
        if column.calibrated and column.scan in self.members:
            points = self.members[column.scan]
            told = explain_reflectance(self.project, column.scan, column.channel, points)
            row[f"{column.name}_sigma"] = _number(told.sigma)
        return row

    def describe_index(self, index: NamedIndex, first: Column, second: Column) -> Row:
        """Index of the means; the mean of the index too where one scan has both channels."""
        a, b = self.values(first), self.values(second)
        together = first.scan == second.scan
        covariance = covariance_of_means(a, b) if together else 0.0
        found = index_of_means(index, mean_of(a), mean_of(b), covariance)
        row = _tell_index(index.name, found)
        if together:
            values = dict(zip(index.roles, (a, b), strict=True))
            row |= _tell(f"{index.name}_mean_of_points", mean_of_index(index, values), bare=True)
        return row

    def pair(
        self, index: NamedIndex, first: Column, second: Column, within: float, counts: Ints
    ) -> Row:
        """Mean of the index over pairs of nearest points; adds points and pairs to `counts`."""
        name = f"{index.name}_mean_of_pairs"
        if first.scan == second.scan:
            raise WrongUse(f"Both channels of {index.name} are in one scan: nothing to pair.")
        if first.scan not in self.members or second.scan not in self.members:
            return _tell(name, mean_of(np.empty(0)), bare=True)
        places = [
            self.project.state.scan(c.scan).scan.xyz[self.members[c.scan]] for c in (first, second)
        ]
        pairs = pair_nearest(places[0], places[1], within)
        counts += [len(places[0]), len(places[1]), len(pairs.first)]
        chosen = self.values(first)[pairs.first], self.values(second)[pairs.second]
        row = _tell(name, mean_of_index(index, dict(zip(index.roles, chosen, strict=True))), True)
        for column, share in zip((first, second), pairs.shares, strict=True):
            row[f"{index.name}_matched_share_{column.name}"] = share
        return row


def _tell(name: str, mean: Mean, bare: bool = False) -> Row:
    """Columns of a mean; `bare`: the name itself says that it is one."""
    return {
        name if bare else f"{name}_mean": _number(mean.mean),
        f"{name}_sd": _number(mean.sd),
        f"{name}_se": _number(mean.standard_error),
        f"{name}_n": mean.count,
    }


def _tell_index(name: str, found: IndexOfMeans) -> Row:
    return {
        f"{name}_of_means": _number(found.value),
        f"{name}_of_means_se": _number(found.standard_error),
    }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None

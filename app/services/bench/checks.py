"""One line of a validation table: what must come out, what did, and whether that will do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from app.services.bench.results import ResultTable, Value


@dataclass(frozen=True, slots=True)
class Check:
    """Something that was computed twice, in different ways.

    Attributes
    ----------
    group, what : str
    expected, found : float
        Where they differ most.
    deviation, limit : float
        Largest difference, and how large it may be; of the expected value where `relative`.
    count : int
        How many values were compared.
    unit : str
    relative : bool
    """

    group: str
    what: str
    expected: float
    found: float
    deviation: float
    limit: float
    count: int
    unit: str = ""
    relative: bool = False

    @property
    def passed(self) -> bool:
        """Whether the deviation is within the limit; one that is no number is not."""
        return bool(self.deviation <= self.limit)

    def as_row(self) -> dict[str, Value]:
        """A row of the table."""
        return {
            "group": self.group,
            "check": self.what,
            "values": self.count,
            "expected": self.expected,
            "found": self.found,
            "largest deviation": self.deviation,
            "limit": self.limit,
            "unit": "of expected" if self.relative else self.unit,
            "verdict": "agrees" if self.passed else "DIFFERS",
        }


def compare(
    group: str,
    what: str,
    expected: npt.ArrayLike,
    found: npt.ArrayLike,
    limit: float,
    unit: str = "",
    relative: bool = False,
) -> Check:
    """The check of arrays of equal shape, at the place where they differ most."""
    wanted = np.asarray(expected, float).ravel()
    got = np.asarray(found, float).ravel()
    if len(wanted) != len(got) or len(wanted) == 0:
        return Check(group, what, len(wanted), len(got), np.inf, limit, len(got), "values")
    away = np.abs(got - wanted) / (np.abs(wanted) if relative else 1.0)
    worst = int(np.argmax(np.where(np.isnan(away), np.inf, away)))
    values = float(wanted[worst]), float(got[worst]), float(away[worst])
    return Check(group, what, *values, limit, len(got), unit, relative)


def tabulate(name: str, title: str, checks: Iterable[Check], note: str = "") -> ResultTable:
    """Checks as a table."""
    return ResultTable(name, title, [check.as_row() for check in checks], note)

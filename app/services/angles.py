"""What there is to tell about incidence angles that were computed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools
from app.core.units import to_degrees, to_mm
from app.model.fields import Values

SAMPLE = 200_000
"""Points that medians are taken over, spread evenly through the scan."""


@dataclass(frozen=True, slots=True)
class AngleFacts:
    """How angles were found, and how good they are.

    Attributes
    ----------
    neighbours, reason, estimator : str
        As in the notes of the field ``incidence``.
    points, undefined : int
        Points that were computed, and those of them without a value.
    width_mm, sigma_deg : float
        Medians of the window's half-width and of the standard error; NaN without a value.
    """

    neighbours: str
    reason: str
    estimator: str
    points: int
    undefined: int
    width_mm: float
    sigma_deg: float


def describe_angles(known: Values, valid: Bools) -> AngleFacts:
    """Sum up the values of the field ``incidence`` as far as they are there.

    Parameters
    ----------
    known : Values
    valid : (n,) bool
        Points with coordinates; others have no angle for another reason.
    """
    counted = known.have & valid
    angled = counted & np.isfinite(known.values)
    points, found = int(np.count_nonzero(counted)), int(np.count_nonzero(angled))
    rows = np.flatnonzero(angled)[:: max(1, found // SAMPLE)]
    notes = known.notes
    return AngleFacts(
        str(notes["neighbours"]),
        str(notes["reason"]),
        str(notes["estimator"]),
        points,
        points - found,
        to_mm(_median(known.beside["width"][rows])),
        to_degrees(_median(known.beside["sigma"][rows])),
    )


def _median(values: AnyArray) -> float:
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else float("nan")

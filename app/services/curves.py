"""Angular curves of a scan or of leaves: fit them, keep them, put them to use."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput, WrongUse
from app.core.fitting import FitResult, fit
from app.core.progress import QUIET, Progress
from app.core.units import to_radians
from app.model.leaf import FitRecord, join_members
from app.model.operations import PutFit
from app.model.parameters import Curve
from app.model.project import Project
from app.model.state import next_key

STEEPEST = 80.0
BIN = 5.0
DEFAULT_MODEL = "lambert-beckmann"


def channel_in_use(project: Project, scan: str) -> str:
    """Name of the channel that fits use; see `ScanState.channel_in_use`."""
    return project.state.scan(scan).channel_in_use("a curve").name


def angles_and_values(
    project: Project, scan: str, points: Ints | None, channel: str, progress: Progress = QUIET
) -> tuple[Floats, Floats]:
    """Incidence (degrees) and intensity of the points that can be fitted."""
    alive = project.state.scan(scan).alive
    points = np.flatnonzero(alive) if points is None else points[alive[points]]
    angle = project.field(scan, "incidence", points, progress)
    value = project.field(scan, channel, points)
    usable = np.isfinite(angle) & np.isfinite(value)
    return angle[usable], value[usable]


def bin_means(angle: Floats, value: Floats, width: float = BIN) -> tuple[Floats, Floats, Floats]:
    """Mean angle and value per step of `width` degrees up to 80°, and the count in each."""
    inside = angle < STEEPEST
    bins = (angle[inside] // width).astype(np.int64)
    count = np.bincount(bins)
    filled = count > 0
    with np.errstate(invalid="ignore"):
        angles = np.bincount(bins, angle[inside])[filled] / count[filled]
        values = np.bincount(bins, value[inside])[filled] / count[filled]
    return angles, values, count[filled].astype(np.float64)


def fit_leaves(
    project: Project,
    scan: str,
    leaves: Sequence[str],
    model: str,
    channel: str | None = None,
    progress: Progress = QUIET,
) -> FitRecord:
    """Fit a model to the points of leaves (none named: of the whole scan, per 5° step).

    The fit is kept in the project as one step of the history.

    Raises
    ------
    BadInput
        Too few points with an angle and an intensity.
    """
    channel = channel or channel_in_use(project, scan)
    points = members_of(project, scan, leaves)
    angle, value = angles_and_values(project, scan, points, channel, progress)
    result = fit_values(angle, value, model, binned=points is None)
    key = next_key(project.state.fits, "fit")
    record = FitRecord(key, scan, tuple(leaves), channel, model, plain(result))
    project.do(PutFit(key, record))
    return record


def fit_values(angle: Floats, value: Floats, model: str, binned: bool = False) -> FitResult:
    """Fit a model to angles in degrees, point by point or on means per 5° step."""
    if len(angle) == 0:
        raise BadInput("There is no point with both an incidence angle and an intensity to fit.")
    if not binned:
        return fit(model, to_radians(angle), value)
    angles, values, counts = bin_means(angle, value)
    return fit(model, to_radians(angles), values, weights=counts)


def members_of(project: Project, scan: str, leaves: Sequence[str]) -> Ints | None:
    """Points of leaves of a scan; None when none is named.

    Raises
    ------
    WrongUse
        One of them is not there, or belongs to another scan.
    """
    if not leaves:
        return None
    there = {leaf.key: leaf for leaf in project.state.leaves_of(scan)}
    whole = project.state.scan(scan).scan
    for key in leaves:
        if key not in there:
            raise WrongUse(f"There is no {key} in {whole.name}.")
    return join_members([there[key] for key in leaves], len(whole))


def use_fit(project: Project, record: FitRecord) -> None:
    """Make a fit the curve that turns intensity into angles, as one step of the history."""
    names = [project.state.leaves[key].name for key in record.leaves if key in project.state.leaves]
    origin = f"fit of {', '.join(names) if names else 'the whole scan'}"
    result = FitResult.from_dict(record.result)
    values = {name: value for name, value in result.values.items() if math.isfinite(value)}
    curve = Curve(record.model, values, record.channel, origin, result.valid_range)
    use_curve(project, record.scan, curve)


def use_curve(project: Project, scan: str, curve: Curve, drag: str = "") -> None:
    """Put a curve to use; the steps of one slider drag merge into one step."""
    project.set_parameters(scan, drag, curve=curve)


def plain(result: FitResult) -> dict[str, object]:
    """A fit as plain values, as sessions keep it."""
    return dict(result.as_dict())

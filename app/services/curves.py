"""Angular curves of a scan or of leaves: fit them, keep them, put them to use."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from app.core.errors import BadInput
from app.core.fitting import FitResult
from app.core.progress import QUIET, Progress
from app.model.fit_method import WHOLE_SCAN, Method, usual_method
from app.model.leaf import FitRecord
from app.model.operations import PutFit
from app.model.parameters import Curve
from app.model.project import Project
from app.model.state import next_key
from app.services.lab.gather import gather, members_of
from app.services.lab.method import fit_by
from app.services.lab.own_models import AnyModel, find_model

__all__ = [
    "BIN",
    "DEFAULT_MODEL",
    "STEEPEST",
    "channel_in_use",
    "curve_of",
    "fit_again",
    "fit_leaves",
    "members_of",
    "plain",
    "result_of",
    "use_curve",
    "use_fit",
]

STEEPEST = WHOLE_SCAN.angles[1]
BIN = WHOLE_SCAN.width
DEFAULT_MODEL = "lambert-beckmann"


def channel_in_use(project: Project, scan: str) -> str:
    """Name of the channel that fits use; see `ScanState.channel_in_use`."""
    return project.state.scan(scan).channel_in_use("a curve").name


def fit_leaves(
    project: Project,
    scan: str,
    leaves: Sequence[str],
    model: AnyModel,
    channel: str | None = None,
    progress: Progress = QUIET,
    *,
    method: Method | None = None,
    fixed: Mapping[str, float] | None = None,
) -> FitRecord:
    """Fit a model to leaves (none named: to the whole scan).

    The fit is kept in the project as one step of the history.

    Parameters
    ----------
    method : Method or None
        None: single points of leaves, means per 5° step up to 80° of a whole scan.
    fixed : mapping of str to float, optional
        Parameters that are not fitted.

    Raises
    ------
    BadInput
        Too few points with an angle and an intensity.
    """
    channel, known = channel or channel_in_use(project, scan), find_model(model)
    used = method or usual_method(tuple(leaves))
    result = _fit(project, scan, leaves, channel, known, used, fixed, progress)
    key = next_key(project.state.fits, "fit")
    record = FitRecord(
        key, scan, tuple(leaves), channel, known.name, plain(result), method, dict(fixed or {})
    )
    project.do(PutFit(key, record))
    return record


def fit_again(project: Project, record: FitRecord) -> FitResult:
    """Fit what a record says once more, with the document as it is now; keeps nothing."""
    model = result_of(record).angular_model
    return _fit(
        project, record.scan, record.leaves, record.channel, model, record.method_used,
        record.fixed, QUIET,
    )  # fmt: skip


def _fit(
    project: Project,
    scan: str,
    leaves: Sequence[str],
    channel: str,
    model: AnyModel,
    method: Method,
    fixed: Mapping[str, float] | None,
    progress: Progress,
) -> FitResult:
    measured = gather(project, scan, leaves, channel, progress)
    if len(measured) == 0:
        raise BadInput("There is no point with both an incidence angle and an intensity to fit.")
    return fit_by(method, model, measured.angle, measured.value, fixed)


def result_of(record: FitRecord) -> FitResult:
    """The result of a fit that a document keeps; raises `BadInput` where it is damaged."""
    return FitResult.from_dict(record.result)


def use_fit(project: Project, record: FitRecord) -> None:
    """Make a fit the curve that turns intensity into angles, as one step of the history."""
    names = [project.state.leaves[key].name for key in record.leaves if key in project.state.leaves]
    origin = f"fit of {', '.join(names) if names else 'the whole scan'}"
    use_curve(project, record.scan, curve_of(record, origin))


def curve_of(record: FitRecord, origin: str = "") -> Curve:
    """The curve of a fit, with those of its parameters that are determined."""
    result = result_of(record)
    values = {name: value for name, value in result.values.items() if math.isfinite(value)}
    return Curve(record.model, values, record.channel, origin, result.valid_range, result.formula)


def use_curve(project: Project, scan: str, curve: Curve, drag: str = "") -> None:
    """Put a curve to use; the steps of one slider drag merge into one step."""
    project.set_parameters(scan, drag, curve=curve)


def plain(result: FitResult) -> dict[str, object]:
    """A fit as plain values, as sessions keep it."""
    return dict(result.as_dict())

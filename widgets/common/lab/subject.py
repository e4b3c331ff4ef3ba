"""What the pages of the lab work on: a target, its points and the fit that is shown."""

from __future__ import annotations

from dataclasses import dataclass

from app.core.fitting import FitResult
from app.core.fitting.single import AnyModel
from widgets.common.angular_points import AngularPoints
from widgets.common.curve_choice import Target


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """Frozen, so that a worker may have it."""

    target: Target
    model: AnyModel
    points: AngularPoints
    result: FitResult | None = None

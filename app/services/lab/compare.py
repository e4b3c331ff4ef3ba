"""Models side by side on the same pairs, by information criteria."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.fitting import FitResult
from app.core.fitting.bins import average_bins
from app.core.fitting.selection import Comparison, compare_models
from app.core.phase import MODELS, PhaseModel
from app.core.phase.formula_model import FormulaModel
from app.core.progress import QUIET, Progress
from app.core.units import to_radians
from app.services.lab.method import Method, choose_pairs
from app.services.lab.own_models import AnyModel, find_model, models_at_hand

POINTS = Method()
MANY = 1000
"""Points from which on their number says more than the leaf does."""
BY_SQUARES = "Criteria are of least squares: compared on single points, not as they are fitted."
DEPENDENT = (
    "Neighbouring points of a leaf are no independent measurements: with so many, differences "
    "look surer than they are. Means per step are the fairer comparison."
)
LITTLE = 2.0
"""Difference of a criterion below which there is no preference."""


@dataclass(frozen=True, slots=True)
class ModelRow:
    """One model among others; numbers are None where it could not be fitted.

    Attributes
    ----------
    model, title : str
    n, k : int or None
        Pairs (or means), and fitted parameters.
    rss, rmse, r2, aic, aicc, bic : float or None
    aic_above, aicc_above, bic_above : float or None
        How far the criterion is above the least of all models; below 2 there is no preference.
    weight : float or None
        Akaike weight by AICc.
    best : bool
        It has the least AICc; of exact models the fewest parameters.
    exact : bool
        It runs through all points but for rounding: no criterion ranks it.
    result : FitResult or None
    words : tuple of str
        Warnings of the fit, or why there is none.
    """

    model: str
    title: str
    n: int | None
    k: int | None
    rss: float | None
    rmse: float | None
    r2: float | None
    aic: float | None
    aicc: float | None
    bic: float | None
    aic_above: float | None
    aicc_above: float | None
    bic_above: float | None
    weight: float | None
    best: bool
    exact: bool
    result: FitResult | None
    words: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Numbers and words, without the fit itself."""
        kept = (name for name in self.__dataclass_fields__ if name != "result")
        return {name: getattr(self, name) for name in kept} | {"words": list(self.words)}


@dataclass(frozen=True, slots=True)
class ModelTable:
    """Models in the order in which they were named, and what is to be kept in mind."""

    rows: tuple[ModelRow, ...]
    note: str = ""

    @property
    def best(self) -> ModelRow | None:
        """The best model; None where none could be fitted, or the note tells why none is named."""
        return next((row for row in self.rows if row.best), None)

    def as_rows(self) -> list[dict[str, Any]]:
        """The table as plain values."""
        return [row.as_dict() for row in self.rows]


def compare(
    angle_deg: Floats,
    value: Floats,
    models: Sequence[AnyModel] | None = None,
    method: Method = POINTS,
    progress: Progress = QUIET,
) -> ModelTable:
    """Fit models to the same pairs and set their criteria side by side.

    Parameters
    ----------
    angle_deg, value : (n,) arrays
    models : sequence of str, AngularModel or FormulaDefinition, optional
        None: those of the registry and the user's own.
    method : Method
        Points or means, and which angles; an edge or another loss is compared by squares.
    progress : Progress

    Raises
    ------
    WrongUse
        A model does not exist.
    BadInput
        There is no pair within the method's angles.
    """
    known = _find_all(models)
    angle, chosen, _ = choose_pairs(method, angle_deg, value)
    if not len(angle):
        raise BadInput("There is no pair of angle and value to compare models on.")
    weights = None
    if method.to == "bins":
        means = average_bins("lambert", angle, chosen, float(to_radians(method.width)))
        angle, chosen, weights = means.angle, means.value, means.weights
    rows = compare_models(known, angle, chosen, weights=weights, progress=progress)
    table = tuple(_describe(model, row) for model, row in zip(known, rows, strict=True))
    notes = (_tell_exact(table), _tell_crowded(known, rows), _note(method, len(angle)))
    return ModelTable(table, " ".join(filter(None, notes)))


def _find_all(models: Sequence[AnyModel] | None) -> list[PhaseModel | FormulaModel]:
    if models is None:
        names: Sequence[AnyModel] = (*MODELS, *models_at_hand().keys() - MODELS.keys())
        return [find_model(name) for name in names]
    return [find_model(model) for model in models]


def _describe(model: PhaseModel | FormulaModel, row: Comparison) -> ModelRow:
    r, told = row.result, row.result if not row.exact else None
    return ModelRow(
        model=row.model,
        title=model.title,
        n=r.n if r else None,
        k=r.n - r.spare if r else None,
        rss=r.rss if r else None,
        rmse=r.rmse if r else None,
        r2=r.r2 if r else None,
        aic=told.aic if told else None,
        aicc=told.aicc if told else None,
        bic=told.bic if told else None,
        aic_above=row.aic_above,
        aicc_above=row.aicc_above,
        bic_above=row.bic_above,
        weight=row.weight,
        best=row.best,
        exact=row.exact,
        result=r,
        words=row.words,
    )


def _tell_exact(rows: Sequence[ModelRow]) -> str:
    exact = [row for row in rows if row.exact]
    if not exact:
        return ""
    names, best = "; ".join(row.title for row in exact), next((r for r in exact if r.best), None)
    if len(exact) == 1:
        return f"{names} runs through all points exactly: criteria cannot rank the models."
    simplest = (
        f"{best.title} has the fewest parameters."
        if best
        else "None of these has fewer parameters than all others."
    )
    return f"{names} run through all points exactly: criteria cannot rank the models. {simplest}"


def _tell_crowded(models: Sequence[PhaseModel | FormulaModel], rows: Sequence[Comparison]) -> str:
    crowded = [model.title for model, row in zip(models, rows, strict=True) if row.crowded]
    if not crowded or any(row.exact for row in rows):
        return ""
    return (
        f"Too few pairs for the parameters of {'; '.join(crowded)}. Without AICc of all models"
        " there are no weights and no best."
    )


def _note(method: Method, count: int) -> str:
    notes = [] if method.by_squares else [BY_SQUARES]
    if method.to != "bins" and count >= MANY:
        notes.append(DEPENDENT)
    return " ".join(notes)

"""The workflows WF2 and WF3 as chains of steps, with their marks and their σ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.errors import WrongUse
from app.core.phase.incidence_b import LEAST_BRACKET as LEAST_BRACKET
from app.core.workflows import marks
from app.core.workflows.fraction import keep_diffuse
from app.core.workflows.incidence import compute_bracket, divide_incidence
from app.core.workflows.step import Stepped, begin
from app.core.workflows.subtraction import subtract_specular

RIGHT_ANGLE = np.pi / 2
LAMBERTIAN = {"b": 1.0}
"""The diffuse part of Lambert–Beckmann falls with cos ω: that is b = 1."""
Step = Callable[[Floats, Floats, Mapping[str, float]], Stepped]
Covariance = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True, slots=True)
class Workflow:
    """A chain of steps on a calibrated channel.

    Attributes
    ----------
    name, title, formula, source : str
    steps : tuple of callable
    parameters : tuple of str
        What it needs.
    assumed : mapping of str to float
        Values of those that need not be said.
    model : str
        Angular model whose fit gives the parameters.
    """

    name: str
    title: str
    formula: str
    source: str
    steps: tuple[Step, ...]
    parameters: tuple[str, ...]
    assumed: Mapping[str, float]
    model: str


_ALL = (
    Workflow(
        "wf2",
        "WF2, angle corrected",
        "I / (1 − b·(1 − cos ω))",
        "Junttila et al. 2016, equation 6",
        (divide_incidence,),
        ("b",),
        {},
        "incidence-b",
    ),
    Workflow(
        "wf3",
        "WF3, specular share removed",
        "I·k_d·cos ω / (k_d·cos ω + (1 − k_d)·exp(−tan²ω/m²)/cos⁵ω) / (1 − b·(1 − cos ω))",
        "Junttila et al. 2016, section 2.7",
        (keep_diffuse, divide_incidence),
        ("k_d", "m", "b"),
        LAMBERTIAN,
        "lambert-beckmann",
    ),
    Workflow(
        "wf3_subtracted",
        "WF3 by subtraction",
        "(I − f·(1 − k_d)·exp(−tan²ω/m²)/cos⁵ω) / (1 − b·(1 − cos ω))",
        "Junttila et al. 2016, equation 7, subtracted with the sample's own f",
        (subtract_specular, divide_incidence),
        ("f", "k_d", "m", "b"),
        LAMBERTIAN,
        "lambert-beckmann",
    ),
)
WORKFLOWS: Mapping[str, Workflow] = {workflow.name: workflow for workflow in _ALL}


@dataclass(frozen=True, slots=True)
class Limits:
    """Where a correction is believed.

    Attributes
    ----------
    least_bracket : float
        Points whose 1 − b(1 − cos ω) is smaller are marked, not divided.
    fitted : (float, float)
        Angles that the parameters were fitted to, radians.
    """

    least_bracket: float = LEAST_BRACKET
    fitted: tuple[float, float] = (0.0, RIGHT_ANGLE)


@dataclass(frozen=True, slots=True, eq=False)
class Corrected:
    """Corrected values, why some are missing, and what they depend on.

    Attributes
    ----------
    values : (n,) array
        NaN where the mark is neither good nor negative: leaving negative values out would
        raise every mean.
    marks : (n,) uint8 array
        Indices of `app.core.workflows.marks.WORDS`.
    slopes : Stepped
    """

    values: Floats
    marks: AnyArray
    slopes: Stepped

    def sigma(self, intensity: Floats | float, angle: Floats, covariance: Covariance) -> Floats:
        """Standard deviation of the corrected values, to first order; NaN where they are.

        Parameters
        ----------
        intensity : (n,) array or float
            σ of the values before.
        angle : (n,) array
            σ of the incidence angle, radians.
        covariance : mapping of str to mapping of str to float
            Of the fit's parameters; those that are missing are taken as exact.
        """
        variance = (self.slopes.by_value * intensity) ** 2 + (self.slopes.by_angle * angle) ** 2
        return np.where(np.isnan(self.values), np.nan, np.sqrt(variance + self._of_fit(covariance)))

    def _of_fit(self, covariance: Covariance) -> Floats:
        slopes, total = self.slopes.by_parameter, np.zeros(len(self.values))
        for one, row in covariance.items():
            for other, value in row.items():
                if one in slopes and other in slopes:
                    total = total + value * slopes[one] * slopes[other]
        return np.maximum(total, 0.0)  # rounding


def get_workflow(name: str) -> Workflow:
    """The workflow of that name; raises `WrongUse` with the names there are."""
    if name not in WORKFLOWS:
        raise WrongUse(
            f"There is no workflow {name!r}.",
            f"Workflows: {', '.join(WORKFLOWS)}; WF1 is the calibrated channel itself.",
        )
    return WORKFLOWS[name]


def correct(
    workflow: str,
    intensity: Floats,
    angle: Floats,
    values: Mapping[str, float],
    limits: Limits = Limits(),
) -> Corrected:
    """Correct values for their angle of incidence.

    Parameters
    ----------
    workflow : str
        A name in `WORKFLOWS`.
    intensity : (n,) array
        On a linear scale.
    angle : (n,) array
        Radians.
    values : mapping of str to float
        The workflow's parameters; m may be missing where k_d is 1.
    limits : Limits

    Returns
    -------
    Corrected
    """
    chain = get_workflow(workflow)
    known = dict(chain.assumed) | dict(values)
    with np.errstate(all="ignore"):
        found = begin(intensity)
        for step in chain.steps:
            found = found.then(step(found.value, angle, known))
    why = _mark(found.value, intensity, angle, known["b"], limits)
    usable = (why == marks.GOOD) | (why == marks.NEGATIVE)
    return Corrected(np.where(usable, found.value, np.nan), why, found)


def _mark(value: Floats, intensity: Floats, angle: Floats, b: float, limits: Limits) -> AnyArray:
    low, high = limits.fitted
    with np.errstate(invalid="ignore"):
        negative = (value < 0.0) & (intensity >= 0.0)
    why = np.where(negative, marks.NEGATIVE, marks.GOOD)
    why[~np.isfinite(value)] = marks.NO_CORRECTION  # neither a diffuse nor a specular part
    why[~(compute_bracket(angle, b) >= limits.least_bracket)] = marks.SMALL_BRACKET
    why[~((angle >= low) & (angle <= high))] = marks.BEYOND_FITTED
    why[~np.isfinite(angle)] = marks.NO_ANGLE
    why[~np.isfinite(intensity)] = marks.NO_INTENSITY
    return why.astype(np.uint8)

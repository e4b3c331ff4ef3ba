"""The numbers that a calibration looks for, as one vector: those of the steps, and powers.

A number that can only be positive is sought as its logarithm: it stays positive, and the
intervals of k2, k3, m and k, which are far from symmetric, cover the truth as often as they say.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.radiometry import chain as chains
from app.core.radiometry.linear_response import LinearResponse, Proportional
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.range_curve import RangeCurve
from app.core.radiometry.range_effect import AnalyticRange
from app.core.radiometry.salca import SalcaResponse
from app.core.radiometry.step import Step

FARTHEST = 12.0
"""A logarithm moves no farther than this from its start: nothing overflows on the way."""
POSITIVE: dict[type[Step], tuple[str, ...]] = {
    SalcaResponse: ("m", "c", "k"),
    AnalyticRange: ("k2", "k3"),
    LogResponse: ("a0",),
    LinearResponse: ("a",),
    Proportional: ("gain",),
}


@dataclass(frozen=True, slots=True, eq=False)
class Unknowns:
    """Steps and powers with their start values, and which powers are sought.

    Attributes
    ----------
    steps : tuple of Step
        From light to number, without the power.
    scans : tuple of str
    powers : (s,) array
    sought : (s,) array of bool
        Powers that the fit may change; the others stay as they are.
    """

    steps: tuple[Step, ...]
    scans: tuple[str, ...]
    powers: Floats
    sought: Bools

    def __len__(self) -> int:
        return len(self.natural())

    @property
    def step_names(self) -> tuple[str, ...]:
        """Names of the steps' numbers; one that two steps have says which."""
        plain = [name for step in self.steps for name in step.names]
        return tuple(
            f"{name} ({step.title})" if plain.count(name) > 1 else name
            for step in self.steps
            for name in step.names
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all that is sought, the powers last."""
        scans = zip(self.scans, self.sought, strict=True)
        return (*self.step_names, *(_name_power(scan) for scan, open_ in scans if open_))

    def natural(self) -> Floats:
        """All that is sought, as it is, (p,)."""
        return np.concatenate([chains.values(self.steps), self.powers[self.sought]])

    def positive(self) -> Bools:
        """Which are sought as their logarithm, (p,)."""
        flags = [flag for step in self.steps for flag in _find_positive(step)]
        return np.array([*flags, *[True] * int(self.sought.sum())], bool)

    def vector(self) -> Floats:
        """All that is sought, logarithms where it is positive, (p,)."""
        values = self.natural()
        values[self.positive()] = np.log(values[self.positive()])
        return values

    def stretch(self) -> Floats:
        """Derivative of `natural` by `vector`, (p,)."""
        return np.where(self.positive(), self.natural(), 1.0)

    def at(self, vector: Floats) -> Unknowns:
        """The same with other values, given as a vector."""
        positive, start = self.positive(), self.vector()
        values = vector.copy()
        near = np.clip(values, start - FARTHEST, start + FARTHEST)
        values[positive] = np.exp(near[positive])
        return self.replace(values)

    def replace(self, natural: Floats) -> Unknowns:
        """The same with other values, given as they are."""
        steps = chains.with_values(self.steps, natural)
        powers = self.powers.copy()
        powers[self.sought] = natural[len(chains.names(self.steps)) :]
        return replace(self, steps=steps, powers=powers)


def _name_power(scan: str) -> str:
    return f"power of {scan}" if scan.lower().startswith("scan") else f"power of scan {scan}"


def _find_positive(step: Step) -> list[bool]:
    if isinstance(step, RangeCurve):
        return [step.scale == "multiplicative"] * len(step.names)
    return [name in POSITIVE.get(type(step), ()) for name in step.names]

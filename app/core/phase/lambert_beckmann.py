"""Lambert–Beckmann: a diffuse leaf with a rough, glossy surface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.phase.model import Columns, Freedom, Parameter, PhaseModel, Reference, pile
from app.core.units import to_degrees

SMOOTHEST = 1e-3
ROUGHEST_PHYSICAL = float(np.sqrt(0.4))
# Of the largest value: a part of this size is rounding.
NEGLIGIBLE = 1e-12
# A peak that has fallen this far before the smallest angle cannot be told from no peak.
INVISIBLE = 1e-9
EXTRAPOLATED = 0.1
TRIALS = 241


class LambertBeckmann(PhaseModel):
    """I = f·(k_d·cos ω + (1 − k_d)·e^(−tan²ω/m²)/cos⁵ω).

    The coefficients u = f·k_d and v = f·(1 − k_d) are linear and not negative; only m bends.
    """

    def basis(self, angle: Floats, shape: Any) -> Columns:
        """Columns cos ω and the Beckmann term."""
        t = np.tan(angle) ** 2
        # cos ω from the tangent, which is there already, costs a sixth of the cosine.
        return 1.0 / np.sqrt(1.0 + t), _beckmann(t, shape)

    def basis_by_shape(self, angle: Floats, shape: Any) -> Columns:
        """Columns 0 and the Beckmann term by m."""
        t = np.tan(angle) ** 2
        return np.zeros(np.shape(angle)), _beckmann(t, shape) * (2 * t / shape**3)

    def basis_by_angle(self, angle: Floats, shape: Any) -> Columns:
        """Columns −sin ω and the Beckmann term by ω."""
        tangent = np.tan(angle)
        t = tangent**2
        bend = 2 * tangent * (2.5 - (1 + t) / shape**2)
        return -np.sin(angle), _beckmann(t, shape) * bend

    def search(self, angle: Floats) -> Floats:
        """Even steps of log m, as the term depends on tan ω / m, from the sharpest visible peak."""
        t = np.tan(angle.min(axis=-1)) ** 2
        sharpest = np.sqrt(t / (2.5 * np.log1p(t) - np.log(INVISIBLE)))
        return np.geomspace(np.clip(sharpest, SMOOTHEST, 1.0), 1.0, TRIALS, axis=-1)

    def coefficients(self, values: Mapping[str, Any]) -> Floats:
        """U and v."""
        f = np.asarray(values["f"])
        k_d = np.where(f == 0.0, 0.0, values.get("k_d", np.nan))
        return pile([f * k_d, f * (1 - k_d)])

    def coefficient_slopes(self, values: Mapping[str, Any]) -> Floats:
        """d(u, v) / d(f, k_d)."""
        f, k_d = values["f"], values["k_d"]
        return np.stack([pile([k_d, f]), pile([1 - k_d, -f])], axis=-2)

    def name_values(
        self, coefficients: Floats, shape: Any, fixed: Mapping[str, Any]
    ) -> dict[str, Any]:
        """f, k_d and m; no m without a specular part, no k_d without light."""
        u, v = np.moveaxis(np.where(coefficients < NEGLIGIBLE, 0.0, coefficients), -1, 0)
        with np.errstate(invalid="ignore"):
            values = {"f": u + v, "k_d": u / (u + v), "m": shape} | dict(fixed)
        dull = (values["f"] == 0.0) | (values["k_d"] == 1.0)
        return values if "m" in fixed else values | {"m": np.where(dull, np.nan, shape)}

    def free(self, fixed: Mapping[str, float]) -> Freedom:
        """A fixed f ties u to v; a fixed k_d leaves one direction."""
        f, k_d = fixed.get("f"), fixed.get("k_d")
        if f is not None and k_d is not None:
            return _bound((f * k_d, f * (1 - k_d)), np.empty((2, 0)), np.inf)
        if f is not None:
            return _bound((0.0, f), np.array([[1.0], [-1.0]]), f)
        if k_d is not None:
            return _bound((0.0, 0.0), np.array([[k_d], [1 - k_d]]), np.inf)
        return _bound((0.0, 0.0), np.eye(2), np.inf)

    def remark(
        self,
        values: Mapping[str, float],
        angle: Floats,
        noise: float,
        fixed: Mapping[str, float],
    ) -> tuple[str, ...]:
        """Warns of a peak away from ω = 0, and of one that nobody measured."""
        del noise, fixed
        m, sentences = values["m"], []
        if m > ROUGHEST_PHYSICAL:
            sentences.append(
                f"m is above {ROUGHEST_PHYSICAL:.3f}: the specular term rises away from ω = 0,"
                " which is unphysical."
            )
        smallest = angle.min()
        if _beckmann(np.tan(smallest) ** 2, m) < EXTRAPOLATED:
            sentences.append(
                f"The specular peak lies below the smallest angle, {to_degrees(smallest):.1f}°:"
                " f and k_d are extrapolated."
            )
        return tuple(sentences)


def _beckmann(t: Any, m: Any) -> Any:
    # e^(−t/m²)/cos⁵ω with t = tan²ω; this form neither overflows nor divides by zero at 90°.
    return np.exp(2.5 * np.log1p(t) - t / m**2)


def _bound(offset: tuple[float, float], directions: Floats, upper: float) -> Freedom:
    count = directions.shape[1]
    return Freedom(np.array(offset), directions, np.zeros(count), np.full(count, upper))


# Kaasalainen et al. 2018, tables 3 and 4: k_d and m in channels 1 to 8.
_KAASALAINEN = {
    "ZGem": (
        (0.37, 0.22, 0.42, 0.84, 0.89, 0.88, 0.88, 0.87),
        (0.29, 0.34, 0.29, 0.20, 0.19, 0.18, 0.19, 0.19),
    ),
    "China rose": (
        (0.34, 0.31, 0.37, 0.73, 0.77, 0.76, 0.77, 0.77),
        (0.38, 0.40, 0.37, 0.33, 0.30, 0.31, 0.30, 0.31),
    ),
    "birch": (
        (0.45, 0.50, 0.45, 0.50, 0.89, 0.88, 0.88, 0.85),
        (0.32, 0.30, 0.32, 0.30, 0.19, 0.21, 0.22, 0.27),
    ),
    "pine abaxial": (
        (1.00, 1.00, 0.92, 1.00, 1.00, 1.00, 1.00, 1.00),
        (0.19, 0.31, 0.31, 0.28, 0.24, 0.24, 0.25, 0.25),
    ),
    "pine adaxial": (
        (1.00, 1.00, 0.89, 1.00, 1.00, 1.00, 1.00, 1.00),
        (0.44, 0.44, 0.37, 0.38, 0.32, 0.32, 0.32, 0.32),
    ),
    "rose": (
        (0.66, 0.50, 0.54, 0.84, 0.87, 0.86, 0.86, 0.85),
        (0.33, 0.30, 0.32, 0.22, 0.18, 0.19, 0.19, 0.19),
    ),
    "maple": (
        (0.58, 0.56, 0.50, 0.76, 0.92, 0.93, 0.94, 0.93),
        (0.27, 0.27, 0.30, 0.22, 0.18, 0.18, 0.18, 0.19),
    ),
}
# Junttila et al. 2016: k_d, m.
_JUNTTILA = {
    "lime, FARO 1550 nm": (0.60, 0.49),
    "birch, FARO 1550 nm": (0.45, 0.45),
    "maple, FARO 1550 nm": (0.49, 0.55),
    "spruce, FARO 1550 nm": (0.95, 0.58),
    "pine, FARO 1550 nm": (0.99, 0.58),
    "lime, Leica 690 nm": (0.70, 0.59),
    "birch, Leica 690 nm": (0.78, 0.58),
    "maple, Leica 690 nm": (0.91, 0.55),
    "spruce, Leica 690 nm": (0.99, 0.60),
    "pine, Leica 690 nm": (0.99, 0.60),
}


def _list_references() -> tuple[Reference, ...]:
    kaasalainen = (
        Reference(f"{sample}, channel {i}", {"k_d": k_d, "m": m}, "Kaasalainen 2018, tables 3, 4")
        for sample, rows in _KAASALAINEN.items()
        for i, (k_d, m) in enumerate(zip(*rows, strict=True), start=1)
    )
    junttila = (
        Reference(sample, {"k_d": k_d, "m": m}, "Junttila 2016, equation 7")
        for sample, (k_d, m) in _JUNTTILA.items()
    )
    return (*kaasalainen, *junttila)


MODEL = LambertBeckmann(
    name="lambert-beckmann",
    title="Lambert–Beckmann",
    formula="I = f·(k_d·cos ω + (1 − k_d)·exp(−tan²ω/m²)/cos⁵ω)",
    source="Kaasalainen et al. 2018, section 2.1; Junttila et al. 2016, equation 7",
    parameters=(
        Parameter("f", "value", "value at face-on incidence", (0.1, 1.5), lower=0.0, scales=True),
        Parameter("k_d", "1", "diffuse share", (0.1, 0.95), lower=0.0, upper=1.0),
        Parameter(
            "m", "1", "roughness: 0 smooth, 0.6 rough", (0.1, 0.6), lower=SMOOTHEST, upper=1.0
        ),
    ),
    shape="m",
    extrapolates=True,
    unknown_when={"m": "there is no specular part (k_d is 1 or f is 0)", "k_d": "f is 0"},
    references=_list_references(),
)

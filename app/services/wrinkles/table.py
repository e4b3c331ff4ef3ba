"""Wrinkles of leaves as rows: numbers in degrees, words, and what may be claimed."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats
from app.core.units import to_degrees
from app.core.wrinkling.claim import Calibration
from app.core.wrinkling.leaf import JudgedLeaf
from app.core.wrinkling.offset import Offset, find_factor
from app.core.wrinkling.validity import PARTS, WORDS, name_reasons
from app.services.leaves import Row
from app.services.wrinkles.measure import LeafWrinkles, ScanWrinkles

SIGNIFICANT = 2.0
"""|Δω| over its error from which a point counts as turned away from the plane."""
REASONS = {word: "n_" + word.replace(" ", "_") for word in WORDS.values()}
COLUMNS = (
    "leaf", "name", "channel", "points", "case", "curve",
    "omega_plane_deg", "omega_plane_sigma_deg", "omega_mean_deg",
    "omega_of_mean_intensity_minus_plane_deg", "sigma_median_deg",
    *(f"sigma_{part}_median_deg" for part in PARTS), "significant_share",
    "delta_mean_deg", "delta_median_deg", "delta_sd_deg", "delta_q05_deg", "delta_q25_deg",
    "delta_q75_deg", "delta_q95_deg", "skewness", "modes_deg", "shape",
    "wrinkle_index_deg", "wrinkle_index_low_deg", "wrinkle_index_high_deg", "blocks",
    "offset", "offset_sigma", "offset_kind", "offset_as_factor", "noise",
    "valid", *REASONS.values(), "claim", "refusal",
)  # fmt: skip
"""Of every table, whatever is known: what cannot be told is an empty cell."""


def tabulate(found: ScanWrinkles) -> list[Row]:
    """A row per leaf with all of `COLUMNS`; None where something cannot be told."""
    return [tell_leaf(leaf, found.channel.name) for leaf in found.leaves]


def tell_leaf(found: LeafWrinkles, channel: str) -> Row:
    """All that the table says of one leaf."""
    row: Row = dict.fromkeys(COLUMNS)
    row |= {
        "leaf": found.leaf.key,
        "name": found.leaf.name,
        "channel": channel,
        "points": len(found.points),
    }
    if found.calibration is not None:
        row |= {"case": found.calibration.case, "curve": found.calibration.curve.origin}
    if found.judged is None:
        return row | {"refusal": found.refusal}
    judged = found.judged
    row |= _tell_angles(judged) | _tell_spread(judged) | _tell_index(judged)
    row |= {
        "offset": judged.offset.value,
        "offset_sigma": judged.offset.sigma,
        "offset_kind": judged.offset.kind,
        "offset_as_factor": _as_factor(judged.offset, found.calibration),
        "noise": judged.noise,
    }
    row |= _tell_validity(judged)
    claim = found.calibration.sentence if found.calibration else ""
    return row | {"claim": claim, "refusal": judged.refusal}


def _tell_angles(judged: JudgedLeaf) -> Row:
    valid = judged.angles.valid
    row: Row = {
        "omega_plane_deg": _degrees(judged.plane.incidence),
        "omega_plane_sigma_deg": _degrees(judged.plane.sigma),
        "omega_mean_deg": _degrees(_mean(judged.angles.omega[valid])),
        "omega_of_mean_intensity_minus_plane_deg": _degrees(judged.shift),
        "sigma_median_deg": _degrees(_median(judged.angles.sigma[valid])),
    }
    for part in PARTS:
        row[f"sigma_{part}_median_deg"] = _degrees(_median(judged.angles.parts[part][valid]))
    strong = np.abs(judged.significance[valid]) > SIGNIFICANT
    row["significant_share"] = float(strong.mean()) if len(strong) else None
    return row


def _tell_spread(judged: JudgedLeaf) -> Row:
    spread = judged.spread
    if spread is None:
        return {"shape": judged.shape}
    low, q25, q75, high = spread.quantiles
    return {
        "delta_mean_deg": _degrees(spread.mean),
        "delta_median_deg": _degrees(spread.median),
        "delta_sd_deg": _degrees(spread.sd),
        "delta_q05_deg": _degrees(low),
        "delta_q25_deg": _degrees(q25),
        "delta_q75_deg": _degrees(q75),
        "delta_q95_deg": _degrees(high),
        "skewness": _number(spread.skewness),
        "modes_deg": " ".join(f"{to_degrees(mode):.1f}" for mode in spread.modes),
        "shape": judged.shape,
    }


def _tell_index(judged: JudgedLeaf) -> Row:
    index = judged.index
    if index is None:
        return {}
    return {
        "wrinkle_index_deg": _degrees(index.value),
        "wrinkle_index_low_deg": _degrees(index.low),
        "wrinkle_index_high_deg": _degrees(index.high),
        "blocks": index.blocks,
    }


def _tell_validity(judged: JudgedLeaf) -> Row:
    counts = name_reasons(judged.angles.doubt)
    row: Row = {"valid": counts["valid"]}
    return row | {name: counts[word] for word, name in REASONS.items()}


def _as_factor(offset: Offset, calibration: Calibration | None) -> float | None:
    """How much brighter than the curve a leaf is: a shift of DN is a factor of reflectance."""
    if offset.kind == "factor":
        return offset.value
    per_decade = None if calibration is None else calibration.curve.per_decade
    return None if per_decade is None else find_factor(offset.value, per_decade)


def _mean(values: Floats) -> float:
    return float(values.mean()) if len(values) else np.nan


def _median(values: Floats) -> float:
    return float(np.median(values)) if len(values) else np.nan


def _degrees(radians: float) -> float | None:
    return _number(float(to_degrees(radians)))


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None

"""Whether wrinkled leaves can be told from flat ones by Δω alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.units import to_degrees
from app.core.wrinkling.index import find_index
from app.core.wrinkling.leaf import lay_flat
from app.core.wrinkling.means import average_leaf
from app.services.bench.results import ResultTable, Value
from app.services.bench.wrinkles.cases import Judged
from app.services.bench.wrinkles.scenes import KINDS

STEEPEST = np.pi / 3
Row = dict[str, Value]


def area_under_curve(lower: Floats, higher: Floats) -> float:
    """Probability that one of `higher` is above one of `lower`, ties half; NaN without either."""
    if not len(lower) or not len(higher):
        return float("nan")
    from scipy.stats import rankdata

    ranks = rankdata(np.concatenate([lower, higher]))
    wins = ranks[len(lower) :].sum() - len(higher) * (len(higher) + 1) / 2
    return float(wins / (len(lower) * len(higher)))


def tell_wrinkled(judged: Sequence[Judged]) -> ResultTable:
    """AUC of the wrinkle index and of the plain spread of Δω, case (c); rows by scene."""
    rows: list[Row] = []
    scenes = [*dict.fromkeys(one.truth.scene for one in judged)]
    for scene in (*scenes, "all scenes"):
        some = [one for one in judged if scene in (one.truth.scene, "all scenes")]
        seen = [one for one in some if one.levelled is not None]
        indices = {kind: _indices(seen, kind) for kind in KINDS}
        spreads = {kind: _spreads(seen, kind) for kind in KINDS}
        rows.append({
            "scene": scene,
            **{f"n_{kind}": len(indices[kind]) for kind in KINDS},
            "no_index": sum(_lacks_index(one) for one in seen),
            "refused": len(some) - len(seen),
            "auc_flat": _round(area_under_curve(indices["flat"], indices["wrinkled"])),
            "auc_bent": _round(area_under_curve(indices["bent"], indices["wrinkled"])),
            "auc_flat_by_sd": _round(area_under_curve(spreads["flat"], spreads["wrinkled"])),
            "auc_bent_by_sd": _round(area_under_curve(spreads["bent"], spreads["wrinkled"])),
            **{f"median_{kind}_deg": _median(indices[kind]) for kind in KINDS},
        })  # fmt: skip
    return ResultTable(
        "wrinkles_separation", "Wrinkled against flat leaves, from Δω in case (c)", rows,
        "auc: the wrinkle index; by sd: the plain standard deviation of Δω. A leaf without index "
        "(too few footprints) counts as not wrinkled; refused leaves, whose planes are steeper "
        "than 60°, are left out.",
    )  # fmt: skip


def _lacks_index(one: Judged) -> bool:
    return one.levelled is not None and one.levelled.index is None


def _indices(seen: Sequence[Judged], kind: str) -> Floats:
    return np.array([
        0.0 if one.levelled is None or one.levelled.index is None else one.levelled.index.value
        for one in seen
        if one.truth.kind == kind
    ])  # fmt: skip


def _spreads(seen: Sequence[Judged], kind: str) -> Floats:
    return np.array([
        0.0 if one.levelled is None or one.levelled.spread is None else one.levelled.spread.sd
        for one in seen
        if one.truth.kind == kind
    ])  # fmt: skip


def compare_indices(judged: Sequence[Judged]) -> ResultTable:
    """The index against that of the true angles, seen as finely as the scan sees; by kind."""
    rows: list[Row] = []
    for kind in KINDS:
        pairs = [
            (one.levelled.index, true)
            for one in judged
            if one.truth.kind == kind
            and one.levelled is not None
            and one.levelled.index is not None
            and (true := find_true_index(one)) is not None
        ]
        if not pairs:
            continue
        found = np.array([(i.value, i.low, i.high, true) for i, true in pairs])
        slack = 0.005  # a third of a degree: a flat leaf's own index is never quite 0
        held = (found[:, 1] - slack <= found[:, 3]) & (found[:, 3] <= found[:, 2] + slack)
        rows.append({
            "kind": kind,
            "leaves": len(found),
            "median_found_deg": _median(found[:, 0]),
            "median_true_deg": _median(found[:, 3]),
            "median_ratio": _round(float(np.median(found[:, 0] / np.maximum(found[:, 3], 1e-6)))),
            "interval_holds": _round(float(held.mean())),
        })  # fmt: skip
    return ResultTable(
        "wrinkles_index", "The wrinkle index against that of the true angles", rows,
        "true: the same index of the true angles, averaged over the same footprints. Waves shorter "
        "than the footprint are lost to both. interval: 95 %, and 0.3° to either side.",
    )  # fmt: skip


def find_true_index(one: Judged) -> float | None:
    """The index of the true angles over the footprints of valid full hits; None without one."""
    judged, points = one.levelled, one.truth.points
    if judged is None:
        return None
    means = average_leaf(
        np.cos(one.truth.omega), points.xyz, points.scanner, points.diameter, points.full,
        points.cells, points.lines,
    )  # fmt: skip
    chosen = judged.angles.valid & (one.truth.full if points.full is None else points.full)
    omega = np.where(chosen, np.arccos(np.clip(means.values, -1.0, 1.0)), np.nan)
    flat = lay_flat(points.xyz, judged.plane)
    try:
        return find_index(omega, np.zeros(len(omega)), flat, points.diameter, trials=0).value
    except BadInput:
        return None


def _median(values: Floats) -> float:
    return _round(float(to_degrees(np.median(values)))) if len(values) else float("nan")


def _round(value: float) -> float:
    return float(f"{value:.4g}")

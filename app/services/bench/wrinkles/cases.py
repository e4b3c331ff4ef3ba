"""What may be claimed in each case, held against the true angles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import LeafscopeError
from app.core.fitting import fit
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees, to_radians
from app.core.wrinkling.claim import Calibration
from app.core.wrinkling.curve import KnownCurve, curve_of_fit, curve_of_model
from app.core.wrinkling.leaf import Choices, JudgedLeaf, judge_leaf, pool_noise
from app.core.wrinkling.means import average_leaf, noise_of_means
from app.core.wrinkling.offset import LN10, Offset, scatter_of
from app.core.wrinkling.validity import invert_points
from app.services.bench.results import ResultTable, Value
from app.services.bench.wrinkles.scenes import KINDS, LB, TrueLeaf
from app.services.wrinkles.goniometer import USUAL_MODEL

TABLE_DEG = np.arange(0.0, 86.0, 5.0)
TABLE_NOISE = 0.01
"""Of a goniometer's means, a share of the reflectance."""
SCATTER = 0.08
DRAWS, MOST_POINTS = 32, 200
"""Heights of the species for each leaf, and points of it: case (b) needs many leaves."""
RIGHT = float(to_radians(5.0))
BAND = (float(to_radians(15.0)), float(to_radians(60.0)))
Row = dict[str, Value]


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A leaf with what was found of it; None where it was refused."""

    truth: TrueLeaf
    known: JudgedLeaf | None
    levelled: JudgedLeaf | None


def measure_table(leaf: TrueLeaf, random: np.random.Generator) -> KnownCurve:
    """The curve through a goniometer's table of this very leaf: 18 means with 1 % noise."""
    angle = to_radians(TABLE_DEG)
    noise = TABLE_NOISE * random.standard_normal(len(angle))
    value = leaf.respond(angle)
    value = (
        value * (1 + noise) if leaf.per_decade is None else value + noise * leaf.per_decade / LN10
    )
    return curve_of_fit(fit(USUAL_MODEL[leaf.scale], angle, value), leaf.scale, "goniometer")


def species_curve(leaf: TrueLeaf) -> KnownCurve:
    """The right shape at the wrong height: its offset is to be found."""
    shape = {**leaf.sheen, "f": 1.0}
    return curve_of_model(LB, shape, per_decade=leaf.per_decade)


def judge_all(leaves: Sequence[TrueLeaf], seed: int, progress: Progress = QUIET) -> list[Judged]:
    """Cases (a) and (c) of every leaf."""
    random = np.random.default_rng(seed)
    noise = {
        scene: pool_noise([leaf.points for leaf in leaves if leaf.scene == scene], scale)
        for scene, scale in dict.fromkeys((leaf.scene, leaf.scale) for leaf in leaves)
    }
    found = []
    for place, leaf in enumerate(leaves):
        progress.report(place / len(leaves), leaf.scene)
        pooled = noise[leaf.scene]
        known = _judge(
            leaf,
            Calibration("known", measure_table(leaf, random)),
            Choices(noise=pooled, index=False),
        )
        levelled = _judge(leaf, Calibration("levelled", species_curve(leaf)), Choices(noise=pooled))
        found.append(Judged(leaf, known, levelled))
    return found


def _judge(leaf: TrueLeaf, calibration: Calibration, choices: Choices) -> JudgedLeaf | None:
    try:
        return judge_leaf(leaf.points, calibration, choices)
    except LeafscopeError:
        return None  # counted as missing by whoever asks


def compare_known(judged: Sequence[Judged]) -> ResultTable:
    """Case (a): rows by scene, kind and points."""
    rows = []
    for scene in _scenes(judged):
        for kind in ("all", *KINDS):
            some = [one for one in judged if one.truth.scene == scene and fits(one, kind)]
            for points in ("all points of leaves", "full hits"):
                rows.append(_tell_known(scene, kind, points, some))
    return ResultTable(
        "wrinkles_known", "Case (a): curve and offset from a goniometer table of the leaf", rows,
        "right: |ω_I − ω| ≤ 5°, of valid points. valid: of points whose true angle is 15° to 60°. "
        "A refused leaf's points are not valid.",
    )  # fmt: skip


def fits(one: Judged, kind: str) -> bool:
    """Whether a leaf is of a kind, or any is meant."""
    return kind in ("all", one.truth.kind)


def _scenes(judged: Sequence[Judged]) -> list[str]:
    return list(dict.fromkeys(one.truth.scene for one in judged))


def _tell_known(scene: str, kind: str, points: str, some: Sequence[Judged]) -> Row:
    error, valid, band = [np.empty(0)], [np.empty(0, bool)], [np.empty(0, bool)]
    for one in some:
        chosen = one.truth.full if points == "full hits" else np.ones(len(one.truth.omega), bool)
        omega = one.truth.omega[chosen]
        ok = np.zeros(len(omega), bool) if one.known is None else one.known.angles.valid[chosen]
        away = np.full(len(omega), np.nan)
        if one.known is not None:
            away = np.abs(one.known.angles.omega[chosen] - omega)
        error.append(away)
        valid.append(ok)
        band.append((omega >= BAND[0]) & (omega <= BAND[1]))
    away, ok, inside = np.concatenate(error), np.concatenate(valid), np.concatenate(band)
    return {
        "scene": scene,
        "kind": kind,
        "points": points,
        "leaves": len(some),
        "valid_points": int(ok.sum()),
        "right": _share(away[ok] <= RIGHT),
        "median_error_deg": _round(to_degrees(np.median(away[ok]))) if ok.any() else np.nan,
        "p95_error_deg": _round(to_degrees(np.quantile(away[ok], 0.95))) if ok.any() else np.nan,
        "valid_15_to_60": _share(ok[inside]),
    }


def cover_species(judged: Sequence[Judged]) -> ResultTable:
    """Case (b): how often the 68 % interval holds the true angle; rows by scene and found angle."""
    rows: list[Row] = []
    for scene in _scenes(judged):
        parts = [
            cover_leaf(one.truth, one.known)
            for one in judged
            if one.truth.scene == scene and one.known is not None
        ]
        if not parts:
            continue
        omega, sigma, held, tangent = (
            np.concatenate(column) for column in zip(*parts, strict=True)
        )
        for low, high in ((0.0, 90.0), (0.0, 20.0), (20.0, 30.0), (30.0, 45.0), (45.0, 60.0)):
            inside = (omega >= to_radians(low)) & (omega < to_radians(high))
            middle = np.median(sigma[inside]) if inside.any() else np.nan
            rows.append({
                "scene": scene,
                "omega_found_deg": "all" if high == 90.0 else f"{low:g} to {high:g}",
                "points": int(inside.sum()),
                "covered": _share(held[inside]),
                "covered_by_tangent": _share(tangent[inside]),
                "median_sigma_deg": _round(to_degrees(middle)),
            })  # fmt: skip
    return ResultTable(
        "wrinkles_species", "Case (b): the species' curve, reflectance scattering by 8 %", rows,
        "Share of valid full hits whose true angle lies in the 68 % interval; each leaf at "
        f"{DRAWS} heights, the quantiles of a normal distribution of 8 %, up to {MOST_POINTS} "
        "points of it. by tangent: ω ± σ instead of the interval read on the curve.",
    )  # fmt: skip


def cover_leaf(leaf: TrueLeaf, judged: JudgedLeaf) -> tuple[Floats, Floats, Bools, Bools]:
    """A leaf at all heights: angles found, their σ, held by the interval, held by ω ± σ."""
    from scipy.stats import norm

    curve, spread = species_curve(leaf), scatter_of(SCATTER, leaf.scale, leaf.per_decade)
    values, noise = _means_of(leaf, judged)
    chosen = np.flatnonzero(leaf.full)
    chosen = chosen[:: max(len(chosen) // MOST_POINTS, 1)]
    true, parts = leaf.omega[chosen], []
    for draw in norm.ppf((np.arange(DRAWS) + 0.5) / DRAWS):
        # The species is the leaf divided by what this leaf is brighter than it.
        height = float(np.log10(leaf.sheen["f"] / (1.0 + SCATTER * draw)))
        if leaf.per_decade is None:
            offset = Offset("factor", 10.0**height)
        else:
            offset = Offset("added", leaf.per_decade * height + leaf.zero)
        found = invert_points(values[chosen], noise[chosen], curve, offset, spread)
        kept = found.valid
        held = (found.low <= true) & (true <= found.high)
        tangent = np.abs(found.omega - true) <= found.sigma
        parts.append((found.omega[kept], found.sigma[kept], held[kept], tangent[kept]))
    omega, sigma, held, tangent = (np.concatenate(column) for column in zip(*parts, strict=True))
    return omega, sigma, held, tangent


def _means_of(leaf: TrueLeaf, judged: JudgedLeaf) -> tuple[Floats, Floats]:
    points = leaf.points
    means = average_leaf(
        points.intensity, points.xyz, points.scanner, points.diameter, points.full, points.cells,
        points.lines,
    )  # fmt: skip
    return means.values, noise_of_means(judged.noise, means.values, means.count, leaf.scale)


def compare_levelled(judged: Sequence[Judged]) -> ResultTable:
    """Case (c): Δω inside leaves, each about its own mean; rows by scene and kind."""
    rows: list[Row] = []
    for scene in _scenes(judged):
        for kind in ("all", *KINDS):
            some = [one for one in judged if one.truth.scene == scene and fits(one, kind)]
            away = [_away_inside(one) for one in some if one.levelled is not None]
            error = np.concatenate([np.empty(0), *away])
            rows.append({
                "scene": scene,
                "kind": kind,
                "leaves": len(some),
                "refused": sum(one.levelled is None for one in some),
                "points": len(error),
                "within_5": _share(np.abs(error) <= RIGHT),
                "rms_deg": _round(to_degrees(np.sqrt(np.mean(error**2)))) if len(error) else np.nan,
            })  # fmt: skip
    return ResultTable(
        "wrinkles_levelled", "Case (c): the offset from the leaf's own plane, Δω inside leaves",
        rows, "Errors of ω_I about their median on the leaf, valid full hits: ω itself is not "
        "claimed. Refused: planes beyond 60°, or no offset.",
    )  # fmt: skip


def _away_inside(one: Judged) -> Floats:
    judged = one.levelled
    if judged is None:
        return np.empty(0)
    chosen = judged.angles.valid & one.truth.full
    away = judged.angles.omega[chosen] - one.truth.omega[chosen]
    return np.asarray(away - np.median(away) if len(away) else away, np.float64)


def _share(hits: Bools) -> float:
    return round(float(hits.mean()), 4) if len(hits) else np.nan


def _round(value: float) -> float:
    return float(f"{value:.4g}")

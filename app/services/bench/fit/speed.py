"""Time and misses: many small fits against a loop over curve_fit, and single large ones."""

from __future__ import annotations

import time

import numpy as np

from app.core.arrays import Floats
from app.core.fitting import fit, fit_many
from app.core.progress import QUIET, Progress
from app.services.bench.fit.curves import (
    BECKMANN,
    START,
    STEPS,
    draw_curve,
    fit_with_scipy,
    make_curves,
)
from app.services.bench.results import ResultTable, Value
from app.services.bench.timing import time_in_turns

GROUPS, QUICK_GROUPS = 10_000, 300
JUDGED, QUICK_JUDGED = 600, 40
"""Groups that are also searched from many random starts."""
STARTS = 20
NOISES = (0.0, 0.0035, 0.06)
RELATIVE, ABSOLUTE = 1e-9, 1e-12
"""What a sum of squares may be above another, of it and of Σy²."""
MISS = 1e-6
"""A loop has missed the best curve when its sum of squares is above it by more, of Σy²."""
SIZES = (60, 10_000, 100_000)
REPEATS, QUICK_REPEATS = 9, 3
GOALS = {60: np.nan, 10_000: 1.0, 100_000: np.nan}
MOST_MS = 100.0
BATCH_NOTE = (
    "Lambert–Beckmann, 17 angles of 0 to 80°, f of 0.1 to 1000, a tenth of the leaves without "
    f"gloss. curve_fit: with bounds, values divided by the largest, from f, k_d, m = {START}; its "
    f"loop takes every curve once. judged: curves searched from {STARTS} random starts by "
    "curve_fit too; above_best: of these, where our sum of squares is above the best start's by "
    "more than 1e-9 of it + 1e-12 Σy². missed: the loop's sum of squares is above ours by more "
    "than 1e-6 of Σy². Times with standard deviations on both sides."
)
SINGLE_NOTE = (
    "One leaf, scatter 10 %. curve_fit with bounds starts within 10 % of the truth; excess: its "
    "sum of squares over ours, less 1. Medians of turns."
)


def compare_batch(quick: bool, progress: Progress = QUIET) -> ResultTable:
    """Rows by noise: seconds of both, and how often each fails to find the best curve."""
    groups, judged = (QUICK_GROUPS, QUICK_JUDGED) if quick else (GROUPS, JUDGED)
    rows: list[dict[str, Value]] = []
    fit_many(BECKMANN, STEPS, make_curves(9).value)
    for place, noise in enumerate(NOISES):
        # All 10 000 for the noise of the papers; the others show the misses.
        count = groups if noise == NOISES[-1] else max(groups // 10, 30)
        checked = judged if noise == NOISES[-1] else judged // 5
        part = progress.part(place / len(NOISES), (place + 1) / len(NOISES))
        rows.append(_compare(noise, count, checked, part))
    return ResultTable("fit_batch", "Many fits against a loop", rows, BATCH_NOTE)


def _compare(noise: float, count: int, judged: int, progress: Progress) -> dict[str, Value]:
    value = make_curves(count, 1, noise).value
    ours, rss = _time_batch(value)
    loop, theirs = _time_loop(value, progress.part(0.0, 0.4))
    squares = (value**2).sum(axis=1)
    best = search_widely(value[:judged], progress.part(0.4, 1.0))
    allowed = best * (1 + RELATIVE) + ABSOLUTE * squares[:judged]
    excess = (theirs - rss) / squares
    return {
        "noise_percent": round(100 * noise, 6),
        "fits": count,
        "ours_s": float(f"{ours:.4g}"),
        "curve_fit_s": float(f"{loop:.4g}"),
        "times_faster": float(f"{loop / ours:.4g}"),
        "judged": judged,
        "above_best": int((rss[:judged] > allowed).sum()),
        "missed": int((excess > MISS).sum()),
        "missed_percent": round(100 * float((excess > MISS).mean()), 3),
        "worst_excess": float(f"{excess.max():.3g}"),
    }


def _time_batch(value: Floats) -> tuple[float, Floats]:
    """Median seconds of five turns, and the sums of squares."""
    taken = []
    for _ in range(5):
        start = time.perf_counter()
        batch = fit_many(BECKMANN, STEPS, value)
        _ = batch.sd
        taken.append(time.perf_counter() - start)
    return float(np.median(taken)), batch.rss


def _time_loop(value: Floats, progress: Progress) -> tuple[float, Floats]:
    rss = np.empty(len(value))
    start = time.perf_counter()
    for i, row in enumerate(value):
        if i % 50 == 0:
            progress.report(i / len(value), "Looping over curve_fit")
        rss[i] = fit_with_scipy(STEPS, row)[1]
    return time.perf_counter() - start, rss


def search_widely(value: Floats, progress: Progress = QUIET) -> Floats:
    """Least sums of squares of curve_fit from 20 random starts for each row, (g,)."""
    rng = np.random.default_rng(2)
    best = np.full(len(value), np.inf)
    for i, row in enumerate(value):
        progress.report(i / len(value), f"{STARTS} starts of curve_fit")
        starts = np.column_stack((
            rng.uniform(0.2, 2.0, STARTS), rng.uniform(0.0, 1.0, STARTS),
            np.exp(rng.uniform(np.log(0.02), 0.0, STARTS)),
        ))  # fmt: skip
        best[i] = min(fit_with_scipy(STEPS, row, start)[1] for start in starts)
    return best


def compare_single(quick: bool, progress: Progress = QUIET) -> ResultTable:
    """Rows by number of points: milliseconds of one fit, and of one well-started curve_fit."""
    repeats = QUICK_REPEATS if quick else REPEATS
    rows = []
    for place, count in enumerate(SIZES):
        part = progress.part(place / len(SIZES), (place + 1) / len(SIZES))
        rows.append(_compare_one(count, repeats, part))
    return ResultTable("fit_single", "One fit against one curve_fit", rows, SINGLE_NOTE)


def _compare_one(count: int, repeats: int, progress: Progress) -> dict[str, Value]:
    rng = np.random.default_rng(3)
    angle, true = rng.uniform(0.0, 1.4, count), (640.0, 0.5, 0.3)
    value = draw_curve(angle, *true) * (1 + 0.1 * rng.standard_normal(count))
    scale = np.abs(value).max()
    start = np.array(true) * rng.uniform(0.9, 1.1, 3) / [scale, 1.0, 1.0]
    found = fit(BECKMANN, angle, value)
    theirs = fit_with_scipy(angle, value, start)[1]
    times = time_in_turns(
        {
            "ours": lambda: fit(BECKMANN, angle, value),
            "curve_fit": lambda: fit_with_scipy(angle, value, start),
        },
        repeats,
        progress,
    )
    ours, other = (1e3 * times[name].median for name in ("ours", "curve_fit"))
    return {
        "points": count,
        "ours_ms": float(f"{ours:.4g}"),
        "curve_fit_ms": float(f"{other:.4g}"),
        "of_curve_fit": float(f"{ours / other:.3g}"),
        "curve_fit_excess": float(f"{theirs / found.rss - 1:.3g}"),
    }

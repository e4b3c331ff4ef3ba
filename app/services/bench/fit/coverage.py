"""How often intervals hold the truth, on the printed leaves, kind by kind."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from app.core.arrays import Floats
from app.core.fitting import fit, fit_many
from app.core.fitting.intervals import Kind
from app.core.fitting.profile import profile_intervals
from app.core.progress import QUIET, Progress
from app.services.bench.fit.curves import BECKMANN, NAMES, STEPS, draw_curve
from app.services.bench.results import ResultTable, Value

Leaves = Sequence[tuple[float, float]]
SEEDS, QUICK_SEEDS = 500, 40
PROFILE_SEEDS, QUICK_PROFILE_SEEDS = 8, 1
PAPER, STRONG = 0.0035, 0.06
NOISES = (PAPER, 0.02, STRONG)
PROFILED = (PAPER, STRONG)
"""Noises, added ones, for which profiles are made: they take 0.1 s each."""
SHOWN = "value ± t·sd"
KINDS: dict[str, Kind] = {SHOWN: "plain", "t, within bounds": "within bounds"}
NORMAL = 1.959963984540054
EXACT = 1e-6
COVERAGE_NOTE = (
    "Kaasalainen's 42 leaves with k_d < 1, 17 angles of 0 to 80°, f = 1. added: noise of this "
    "share of f; scaled: of each value, weights 1/value². least, most: of one parameter of one "
    "leaf. known: fits that have an interval: none where a parameter is on its bound. Shown by "
    f"default: {SHOWN}. Profiles: fewer seeds, so that least and most of one leaf say nothing."
)
EXACT_NOTE = (
    "The 56 printed pairs of k_d and m as exact curves of 17 angles. error: largest difference "
    "from the print."
)


def list_printed() -> list[tuple[str, float, float]]:
    """Sample and channel, k_d and m of Kaasalainen's tables."""
    return [
        (r.sample, r.values["k_d"], r.values["m"])
        for r in BECKMANN.references
        if "Kaasalainen" in r.source
    ]


def recover_printed() -> ResultTable:
    """Say of glossy and of matt leaves whether the printed parameters are found again."""
    rows: list[dict[str, Value]] = []
    for name, glossy in (("k_d < 1", True), ("k_d = 1", False)):
        chosen = [(k_d, m) for _, k_d, m in list_printed() if (k_d < 1) == glossy]
        errors, silent = {"k_d": 0.0, "m": 0.0}, 0
        for k_d, m in chosen:
            result = fit(BECKMANN, STEPS, draw_curve(STEPS, 1.0, k_d, m))
            values = result.values
            errors["k_d"] = max(errors["k_d"], abs(values["k_d"] - k_d))
            told = any(w.startswith("m is undetermined") for w in result.warnings)
            silent += int(told and result.parameters["m"].value is None)
            errors["m"] = max(errors["m"], abs(values["m"] - m)) if glossy else np.nan
        right = errors["k_d"] <= EXACT and (
            errors["m"] <= EXACT if glossy else silent == len(chosen)
        )
        rows.append({
            "leaves": name, "count": len(chosen), "k_d_error": errors["k_d"],
            "m_error": errors["m"], "m_not_determined": silent,
            "verdict": "reached" if right else "NOT REACHED",
        })  # fmt: skip
    return ResultTable("fit_printed", "Kaasalainen's tables 3 and 4 again", rows, EXACT_NOTE)


def measure_coverage(quick: bool, progress: Progress = QUIET) -> ResultTable:
    """Rows: noise × kind of interval × parameter, and all pooled."""
    leaves = [(k_d, m) for _, k_d, m in list_printed() if k_d < 1]
    rows: list[dict[str, Value]] = []
    cases = [(noise, scaled) for noise in NOISES for scaled in (False, True)]
    for place, (noise, scaled) in enumerate(cases):
        part = progress.part(place / len(cases), (place + 1) / len(cases))
        rows += _measure(leaves, noise, scaled, quick, part)
    return ResultTable(
        "fit_coverage", "How often 95 % intervals hold the truth", rows, COVERAGE_NOTE
    )


def _measure(
    leaves: Leaves, noise: float, scaled: bool, quick: bool, progress: Progress
) -> Iterator[dict[str, Value]]:
    seeds = QUICK_SEEDS if quick else SEEDS
    hits: dict[str, list[Floats]] = {name: [] for name in ("value ± 1.96·sd", *KINDS)}
    for place, (k_d, m) in enumerate(leaves):
        progress.report(0.2 * place / len(leaves), "Counting intervals")
        true = np.array([1.0, k_d, m])
        value, weights = make_samples(true, noise, scaled, seeds, place)
        batch = fit_many(BECKMANN, STEPS, value, weights)
        reach = NORMAL * batch.sd
        plain = np.stack((batch.values - reach, batch.values + reach), axis=-1)
        hits["value ± 1.96·sd"].append(_hold(plain, true))
        for name, kind in KINDS.items():
            hits[name].append(_hold(batch.intervals(kind=kind), true))
    if not scaled and noise in PROFILED:
        hits["profile"] = list(_profile(leaves, noise, quick, progress.part(0.2, 1.0)))
    for name, found in hits.items():
        yield from _tell(noise, scaled, name, np.array(found))


def make_samples(
    true: Floats, noise: float, scaled: bool, seeds: int, place: int
) -> tuple[Floats, Floats | None]:
    """Noisy curves of one leaf, (seeds, 17), and their weights."""
    curve = draw_curve(STEPS, *true)
    size = curve if scaled else np.ones(len(STEPS))
    drawn = np.random.default_rng([place, 7]).standard_normal((seeds, len(STEPS)))
    return curve + noise * size * drawn, curve**-2.0 if scaled else None


def _profile(leaves: Leaves, noise: float, quick: bool, progress: Progress) -> Iterator[Floats]:
    seeds = QUICK_PROFILE_SEEDS if quick else PROFILE_SEEDS
    for place, (k_d, m) in enumerate(leaves[:: 14 if quick else 1]):
        progress.report(place / len(leaves), "Profiles")
        true = np.array([1.0, k_d, m])
        value, _ = make_samples(true, noise, False, seeds, 1000 + place)
        ends = []
        for row in value:
            found = profile_intervals(BECKMANN, STEPS, row)
            ends.append([(found[name].low, found[name].high) for name in NAMES])
        yield _hold(np.array(ends), true)


def _hold(ends: Floats, true: Floats) -> Floats:
    """1 where an interval holds the truth, 0 where not, NaN where there is none; (seeds, 3)."""
    held = (ends[..., 0] <= true) & (true <= ends[..., 1])
    return np.where(np.isfinite(ends).all(axis=-1), held, np.nan)


def _tell(noise: float, scaled: bool, name: str, hits: Floats) -> Iterator[dict[str, Value]]:
    each = np.nanmean(hits, axis=1)
    parts = [(p, hits[..., i], each[:, i]) for i, p in enumerate(NAMES)]
    for p, held, one in [*parts, ("all", hits, each)]:
        yield {
            "noise_percent": round(100 * noise, 6),
            "noise": "scaled" if scaled else "added",
            "interval": name,
            "parameter": p,
            "fits": int(held.size),
            "covered": round(float(np.nanmean(held)), 4),
            "least": round(float(np.nanmin(one)), 4),
            "most": round(float(np.nanmax(one)), 4),
            "known": round(float(np.isfinite(held).mean()), 4),
        }

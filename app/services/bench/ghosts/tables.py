"""Tables: the scenes, what each method calls ghosts, and where our corrections went."""

from __future__ import annotations

from collections.abc import Sequence

from app.services.bench.ghosts.compare import Outcome, Result
from app.services.bench.results import ResultTable, Value

Row = dict[str, Value]
CALLS_NOTE = (
    "A ghost lies more than 6 mm off every surface that its beam touched, free of noise; 2 to 6 mm "
    "count for neither. At the usual setting of each method; best: of all settings, the one with "
    "the largest F1 on this very scene, which nobody knows beforehand. full_called: of the points "
    "whose footprint lies wholly on one leaf, those called ghosts; good_called: of all points on a "
    "surface. seconds: all after reading; ours and outlier removal with 8 neighbours: the middle "
    "of 3 turns, taken in turn."
)
CORRECTIONS_NOTE = (
    "corrected: of the ghosts whose dominant surface is a leaf with ≥ 50 full hits. within: of all "
    "corrected points, those within 2 σ of their own range noise from the energy-weighted range of "
    "the dominant surface; worse: those farther from it than before. exact: share of the corrected "
    "points at which that range is known free of noise, and the same figures of these alone: "
    "in the files of the other simulator the ranges of leaves hold the noise of the point itself."
)


def tabulate_scenes(outcomes: Sequence[Outcome]) -> ResultTable:
    """What was scanned."""
    rows: list[Row] = []
    for outcome in outcomes:
        facts = outcome.facts
        rows.append({
            "scene": facts.name, "seed": facts.seed, "group": facts.group, "points": facts.points,
            "ghosts_percent": _percent(facts.ghosts), "unsure_percent": _percent(facts.unsure),
            "full_percent": _percent(facts.full), "leaf_ghosts": facts.leaf_ghosts,
            "of_large_leaves": facts.of_large,
        })  # fmt: skip
    return ResultTable("ghosts_scenes", "Scans with known ghosts", rows)


def tabulate_calls(outcomes: Sequence[Outcome]) -> ResultTable:
    """How right the methods are, at their usual and at their best settings."""
    rows = [_tell(outcome, result) for outcome in outcomes for result in outcome.results]
    return ResultTable("ghosts_calls", "Points called ghosts", rows, CALLS_NOTE)


def _tell(outcome: Outcome, result: Result) -> Row:
    usual, best = result.usual, result.best
    return {
        "scene": outcome.facts.name, "seed": outcome.facts.seed, "method": result.family,
        "variant": result.variant, "setting": _round(result.usual_at), "f1": _round(usual.f1),
        "recall": _round(usual.recall), "precision": _round(usual.precision),
        "full_called_percent": _percent(usual.full_called),
        "good_called_percent": _percent(usual.good_called),
        "best_setting": _round(result.best_at), "best_f1": _round(best.f1),
        "best_recall": _round(best.recall), "best_precision": _round(best.precision),
        "best_full_called_percent": _percent(best.full_called),
        "seconds": _round(result.seconds),
    }  # fmt: skip


def tabulate_corrections(outcomes: Sequence[Outcome]) -> ResultTable:
    """Where our corrections went."""
    rows: list[Row] = []
    for outcome in outcomes:
        found = outcome.corrections
        rows.append({
            "scene": outcome.facts.name, "seed": outcome.facts.seed, "points": found.count,
            "corrected_percent": _percent(found.share), "within_percent": _percent(found.within),
            "worse_percent": _percent(found.worse), "exact_percent": _percent(found.exact),
            "exact_within_percent": _percent(found.exact_within),
            "exact_worse_percent": _percent(found.exact_worse),
        })  # fmt: skip
    return ResultTable("ghosts_corrections", "Ghosts put back", rows, CORRECTIONS_NOTE)


def _percent(share: float) -> float:
    return round(100.0 * float(share), 3)


def _round(value: float) -> float:
    return float(f"{value:.4g}")

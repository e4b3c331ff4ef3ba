"""What must not change a verdict on ghost points, and what must be refused in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import LeafscopeError
from app.core.footprint import BeamShape
from app.core.ghosts import THRESHOLD, correct_ghosts, score_ghosts
from app.core.neighbours.steps import Cells
from app.services.bench.results import ResultTable, Value

NAME = "stability_ghosts"
SIDE, STEP = 100, 3e-4
NEAR, FAR = 2.0, 2.5
RIM = 3.0
"""Cells over which a beam goes from leaf to wall."""
SCALES = (1e-12, 1e-6, 1e6, 1e12)
FEW = 0.002
"""Share of points whose verdict may turn where ranges are rounded otherwise."""
NOTE = (
    "A round leaf at 2 m before a wall at 2.5 m. changed: share of the points whose verdict is not "
    "that of the unchanged scan, or not the one that is told. refused: an error that says why. "
    "A ghost is one by millimetres: scaled scans have other ghosts, but each point a verdict."
)


@dataclass(frozen=True, slots=True, eq=False)
class GhostScan:
    """Points in rows and columns, the scanner, and the verdict that they should get."""

    xyz: Floats
    cells: Cells
    scanner: Floats
    wanted: Bools
    beam: BeamShape | None = None


@dataclass(frozen=True, slots=True)
class Case:
    """A change of the scan; `limit` None: it must be refused."""

    name: str
    change: Callable[[GhostScan], GhostScan]
    limit: float | None = 0.0


def make_scan(noise: float = 3e-4) -> GhostScan:
    """The unchanged scan; what is wanted are its own verdicts."""
    row, column = (a.ravel() for a in np.mgrid[:SIDE, :SIDE])
    up, side = (row - SIDE / 2) * STEP, (column - SIDE / 2) * STEP
    beams = np.stack([np.ones(len(row)), side, up], axis=1)
    share = np.clip((30.0 - np.hypot(row - SIDE / 2, column - SIDE / 2)) / RIM + 0.5, 0.0, 1.0)
    away = share * NEAR * (1.0 - 0.5 * side) + (1.0 - share) * FAR
    away = away + np.random.default_rng(1).normal(0.0, noise, len(row))
    scan = GhostScan(
        beams * away[:, None], Cells(SIDE, SIDE, row, column), np.zeros(3), np.zeros(len(row), bool)
    )
    return replace(scan, wanted=judge(scan))


def judge(scan: GhostScan) -> Bools:
    """Verdicts of a scan; its ghosts are corrected too, which must not fail either.

    Raises
    ------
    LeafscopeError
        The scan is refused.
    """
    told = score_ghosts(scan.xyz, scan.scanner, None, scan.cells, beam=scan.beam)
    score, silent = told.score, np.isnan(told.score)
    seen = np.isfinite(scan.xyz).all(axis=1) & (scan.xyz != scan.scanner).any(axis=1)
    # The density says nothing where beams lie too far apart.
    lost = silent & seen & (told.method == "scan grid")
    if lost.any() or not silent[~seen].all() or ((score < 0.0) | (score > 1.0)).any():
        raise ArithmeticError("a score is missing, one too many, or none")
    ghost: Bools = score >= THRESHOLD
    found = correct_ghosts(
        scan.xyz, scan.scanner, np.flatnonzero(ghost), score, scan.cells, beam=scan.beam
    )
    if not np.isfinite(found.moved[found.corrected]).all():
        raise ArithmeticError("a corrected point is nowhere")
    return ghost


def list_cases() -> list[Case]:
    """All of them."""
    return [
        Case("unchanged", lambda scan: scan),
        Case("points in another order", _shuffle),
        Case("turned about the scanner", _turn, FEW),
        Case("moved by 1e6 m", lambda scan: _move(scan, 1e6), FEW),
        Case("no noise at all: ranges tie", _silence, 0.01),
        Case("a tenth of the points not finite", _spoil, 0.0),
        *(Case(f"scaled by {scale:g}", partial(_scale, scale=scale)) for scale in SCALES),
        Case("no point", lambda scan: _take(scan, 0)),
        Case("one point", lambda scan: _take(scan, 1)),
        Case("all not finite", lambda scan: _fill(scan, np.nan)),
        Case("all at the scanner", lambda scan: _fill(scan, 0.0)),
        Case("all at one place", lambda scan: _fill(scan, 1.0)),
        Case("a beam of no width", lambda scan: replace(scan, beam=BeamShape(0.0, 0.0)), 1.0),
        Case("a beam of 1 m", lambda scan: replace(scan, beam=BeamShape(1.0, 0.0)), 1.0),
        Case("a beam of negative width", _spoil_beam, None),
        Case("rows beyond the grid", _leave_grid, None),
    ]


def check_ghosts() -> ResultTable:
    """A row for each case."""
    scan = make_scan()
    rows = [judge_case(case, scan) for case in list_cases()]
    return ResultTable(NAME, "What must not change a verdict on ghosts", rows, NOTE)


def judge_case(
    case: Case, scan: GhostScan, way: Callable[[GhostScan], Bools] = judge
) -> dict[str, Value]:
    """Run a case, and say whether what comes is right or refused."""
    changed, words = np.nan, ""
    try:
        given = case.change(scan)
        found = way(given)
    except LeafscopeError as refusal:
        verdict, words = ("refused" if case.limit is None else "FAILS"), str(refusal)
    except ArithmeticError as fault:
        verdict, words = "FAILS", str(fault)
    else:
        changed = float(np.mean(found != given.wanted)) if len(found) else 0.0
        right = case.limit is not None and changed <= case.limit
        verdict = "right" if right else "FAILS"
    return {
        "case": case.name,
        "limit": np.nan if case.limit is None else case.limit,
        "changed": float(f"{changed:.3g}"),
        "verdict": verdict,
        "words": words,
    }


def _shuffle(scan: GhostScan) -> GhostScan:
    order = np.random.default_rng(2).permutation(len(scan.xyz))
    cells = Cells(SIDE, SIDE, scan.cells.row[order], scan.cells.column[order])
    return replace(scan, xyz=scan.xyz[order], cells=cells, wanted=scan.wanted[order])


def _turn(scan: GhostScan) -> GhostScan:
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    return replace(scan, xyz=scan.xyz @ turn.T)


def _move(scan: GhostScan, metres: float) -> GhostScan:
    return replace(scan, xyz=scan.xyz + metres, scanner=scan.scanner + metres)


def _silence(scan: GhostScan) -> GhostScan:
    return replace(make_scan(0.0), wanted=scan.wanted)


def _spoil(scan: GhostScan) -> GhostScan:
    """Beams without a point change what is around; the verdict of a scan so spoilt is taken."""
    spoilt = scan.xyz.copy()
    spoilt[::10] = np.nan
    dropped = np.isfinite(spoilt).all(axis=1)
    cells = Cells(SIDE, SIDE, scan.cells.row[dropped], scan.cells.column[dropped])
    wanted = np.zeros(len(spoilt), bool)
    wanted[dropped] = judge(replace(scan, xyz=spoilt[dropped], cells=cells))
    return replace(scan, xyz=spoilt, wanted=wanted)


def _scale(scan: GhostScan, scale: float) -> GhostScan:
    scaled = replace(scan, xyz=scan.xyz * scale)
    return replace(scaled, wanted=judge(scaled))


def _take(scan: GhostScan, count: int) -> GhostScan:
    cells = Cells(SIDE, SIDE, scan.cells.row[:count], scan.cells.column[:count])
    return replace(scan, xyz=scan.xyz[:count], cells=cells, wanted=np.zeros(count, bool))


def _fill(scan: GhostScan, value: float) -> GhostScan:
    return replace(scan, xyz=np.full_like(scan.xyz, value), wanted=np.zeros(len(scan.xyz), bool))


def _spoil_beam(scan: GhostScan) -> GhostScan:
    return replace(scan, beam=BeamShape(-0.001, 0.0))


def _leave_grid(scan: GhostScan) -> GhostScan:
    cells = Cells(SIDE, SIDE, scan.cells.row + SIDE, scan.cells.column)
    return replace(scan, cells=cells)

"""What must not change an area, and what must be refused in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput
from app.core.mesh import lay_out, mesh_leaf
from app.core.neighbours.steps import Cells, UnusableGrid
from app.services.bench.results import ResultTable, Value

NAME = "stability_mesh"
SIDE, STEP, RANGE = 48, 3e-4, 2.0
TILT = np.deg2rad(40.0)
EXACT, DISCRETE = 1e-9, 0.02
NOTE = (
    "A square of 40 cells on a plane at 40° before nothing, without noise and without a beam. "
    "error: of its area, relative; of a changed scan against the unchanged one where the limit is "
    "1e-9. refused: an error that says why."
)


@dataclass(frozen=True, slots=True)
class Case:
    """Points and cells of a leaf; `scale` is what its area must grow by, None: be refused."""

    name: str
    xyz: Floats
    cells: Cells
    scale: float | None
    limit: float = EXACT


def make_square() -> tuple[Floats, Cells]:
    """Points of the square, in rows and columns."""
    row, column = (a.ravel() for a in np.mgrid[4:44, 4:44])
    up, side = (SIDE / 2 - row) * STEP, (SIDE / 2 - column) * STEP
    beams = np.stack([np.ones(len(row)), side, up], axis=1)
    depth = RANGE / (1.0 + side * np.tan(TILT))
    return beams * depth[:, None], Cells(SIDE, SIDE, row, column)


def true_area() -> float:
    """Area of the square, closed form: cells of the tangent plane, mapped to the leaf's."""
    edge = 20 * STEP
    low, high = (RANGE / (1 + s * np.tan(TILT)) for s in (edge + STEP / 2, -edge + STEP / 2))
    # ∫ depth³ / (depth₀ · cos) over the side, times the height: the plane is x + y tan = depth₀.
    factor = (
        RANGE**2 / np.cos(TILT) / (2 * np.tan(TILT)) * ((high / RANGE) ** 2 - (low / RANGE) ** 2)
    )
    return float(factor * 40 * STEP)


def measure(xyz: Floats, cells: Cells, members: Ints | None = None) -> float:
    """Area of a leaf of all points, or of some."""
    layout = lay_out(xyz, np.zeros(3), cells)
    return mesh_leaf(layout, np.arange(len(xyz)) if members is None else members).area.value


def list_cases() -> list[Case]:
    """All of them."""
    xyz, cells = make_square()
    order = np.random.default_rng(4).permutation(len(xyz))
    shuffled = Cells(SIDE, SIDE, cells.row[order], cells.column[order])
    twice = Cells(SIDE, SIDE, np.repeat(cells.row, 2), np.repeat(cells.column, 2))
    spoilt = xyz.copy()
    spoilt[777] = np.nan
    few = Cells(SIDE, SIDE, cells.row[:5], cells.column[:5])
    line = np.flatnonzero(cells.row == 20)
    on_line = Cells(SIDE, SIDE, cells.row[line], cells.column[line])
    outside = Cells(SIDE, SIDE, cells.row + SIDE, cells.column)
    one = Cells(SIDE, SIDE, cells.row[:1], cells.column[:1])
    none = Cells(SIDE, SIDE, cells.row[:0], cells.column[:0])
    return [
        Case("unchanged", xyz, cells, 1.0, DISCRETE),
        *(Case(f"scaled by {s:g}", xyz * s, cells, s * s) for s in (1e-12, 1e-6, 1e6, 1e12)),
        Case("points in another order", xyz[order], shuffled, 1.0),
        Case("each point twice", np.repeat(xyz, 2, axis=0), twice, 1.0),
        Case("one point not finite: its cell is filled", spoilt, cells, 1.0, 1e-6),
        Case("no point", xyz[:0], none, None),
        Case("one point", xyz[:1], one, None),
        Case("five points", xyz[:5], few, None),
        Case("one row of points", xyz[line], on_line, None),
        Case("all not finite", np.full_like(xyz, np.nan), cells, None),
        Case("all at the scanner", np.zeros_like(xyz), cells, None),
        Case("all at one place", np.ones_like(xyz), cells, None),
        Case("rows beyond the grid", xyz, outside, None),
    ]


def check_meshes() -> ResultTable:
    """A row for each case."""
    xyz, cells = make_square()
    usual = measure(xyz, cells)
    rows = [judge_case(case, usual) for case in list_cases()]
    return ResultTable(NAME, "What must not change an area", rows, NOTE)


def judge_case(
    case: Case, usual: float, way: Callable[[Floats, Cells], float] = measure
) -> dict[str, Value]:
    """Measure a case, and say whether what comes is right or refused."""
    error, words = np.nan, ""
    try:
        area = way(case.xyz, case.cells)
    except (BadInput, UnusableGrid) as refusal:
        verdict, words = ("refused" if case.scale is None else "FAILS"), str(refusal)
    else:
        right = true_area() if case.limit == DISCRETE else usual
        error = np.inf if case.scale is None else abs(area / (right * case.scale) - 1.0)
        verdict = "right" if error <= case.limit else "FAILS"
    return {
        "case": case.name, "limit": case.limit, "error": float(f"{error:.3g}"),
        "verdict": verdict, "words": words,
    }  # fmt: skip

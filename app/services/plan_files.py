"""Plans as files: a table per range and angle as CSV, everything as JSON."""

from __future__ import annotations

import csv
import io
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from app.core.errors import WrongUse
from app.core.units import to_mm
from app.formats.atomic import atomic_path, refuse_target
from app.services.plan_texts import list_assumptions, tell_range
from app.services.planning import SHARES, Plan, beam_facts

COLUMNS = (
    "range_m", "omega_deg", "footprint_mm", "footprint_share_of_width", "points", "full_hits",
    "ghost_share", "usable", "largest_omega_deg", "bound_by",
)  # fmt: skip
ENDINGS = (".csv", ".json")


def write_plan(plan: Plan, path: Path, overwrite: bool = False) -> None:
    """Write a plan as .csv (a row per range and angle) or .json (everything).

    Raises
    ------
    WrongUse
        Another ending.
    BadInput
        The file cannot be written.
    """
    check_ending(path)
    refuse_target(path, overwrite)
    as_json = path.suffix.lower() == ".json"
    text = json.dumps(as_dict(plan), indent=2, allow_nan=False) + "\n" if as_json else as_csv(plan)
    with atomic_path(path, overwrite) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")


def check_ending(path: Path) -> None:
    """Raise `WrongUse` for a file that cannot be a table."""
    if path.suffix.lower() not in ENDINGS:
        raise WrongUse(
            f"{path.name} is no table that can be written.", f"Endings: {', '.join(ENDINGS)}."
        )


def as_csv(plan: Plan) -> str:
    """A row per range and angle."""
    text = io.StringIO()
    lines = csv.DictWriter(text, COLUMNS, lineterminator="\r\n")
    lines.writeheader()
    for row in list_rows(plan):
        lines.writerow({name: _cell(value) for name, value in row.items()})
    return text.getvalue()


def list_rows(plan: Plan) -> list[dict[str, Any]]:
    """Rows for each range and angle; None where there is no number."""
    found = []
    for i, whole in enumerate(plan.rows):
        for j, angle in enumerate(plan.order.angles_deg):
            usable = whole.largest_deg is not None and angle <= whole.largest_deg
            numbers = (
                to_mm(plan.seen.footprint[i, j]), plan.share[i, j], plan.seen.points[i, j],
                plan.seen.full_hits[i, j], plan.seen.ghosts[i, j],
            )  # fmt: skip
            values = (
                whole.range_m, angle, *map(_known, numbers), usable, whole.largest_deg, whole.bound
            )  # fmt: skip
            found.append(dict(zip(COLUMNS, values, strict=True)))
    return found


def as_dict(plan: Plan) -> dict[str, Any]:
    """The JSON answer of ``leafscope plan``."""
    limits = plan.order.limits
    reached = [
        {f"{share:.0%}": _known(angle) for share, angle in zip(SHARES, row, strict=True)}
        for row in plan.reached_deg
    ]
    return {
        **beam_facts(plan.order),
        "limits": {
            "footprint_share_of_width": limits.footprint,
            "full_hits": limits.full_hits,
            "ghost_share": limits.ghosts,
        },
        "ranges": [
            {**asdict(row), "footprint_reaches_deg": angles, "sentence": tell_range(row)}
            for row, angles in zip(plan.rows, reached, strict=True)
        ],
        "rows": list_rows(plan),
        "assumptions": list(list_assumptions(plan)),
    }


def _known(value: Any) -> float | None:
    number = float(value)
    return number if math.isfinite(number) else None


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)

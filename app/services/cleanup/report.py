"""What a clean-up of a file did, as plain numbers and sentences."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from app.core.ghosts import BEAM
from app.core.ghosts import WORDS as REASONS
from app.model.ghost_fields import ASSUMED
from app.model.parameters import Beam
from app.model.project import Project
from app.services.beams import describe_beam
from app.services.channel_doubts import doubt_channel
from app.services.cleanup.areas import AreaChange
from app.services.cleanup.plan import Plan
from app.services.cleanup.statistics import Statistics

SUMMED = ("points", "ghosts", "corrected", "deleted", "kept", "left_marked")
NO_LEAVES = (
    "The scan has no leaves to count by: clean a session that has some, name a field of labels "
    "with --label-field, or have them found with --find-leaves."
)
WEAKER = (
    "Without rows and columns the score is the weaker one of density: it takes thin and steep "
    "parts for ghosts, knows nothing where beams lie far apart, and nothing can be corrected."
)


def describe(
    project: Project, plan: Plan, found: Statistics, areas: Sequence[AreaChange]
) -> dict[str, Any]:
    """One scan: settings, counts, leaves with their areas, and notes."""
    state = project.state.scan(plan.scan)
    told = found.as_json()
    for reason in told["reasons"].values():
        reason.pop("open")
    told.pop("open")
    for leaf, area in zip(told["leaves"], areas, strict=True):
        leaf |= {"area_before_cm2": area.before, "area_after_cm2": area.after}
    notes = [WEAKER] if plan.reasons is None else []
    notes += [doubt] if (doubt := doubt_channel(state.scan)) else []
    beam = state.parameters.beam or Beam(BEAM.radius, BEAM.half_divergence, ASSUMED)
    return {
        "scan": state.scan.name,
        "method": plan.method,
        "beam": describe_beam(beam),
        "threshold": plan.threshold,
        "sure": plan.sure,
        **told,
        "no_leaves": None if told["leaves"] else NO_LEAVES,
        "notes": notes,
    }


def add_up(scans: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """All scans of a file together."""
    moved = [scan["shift_median_mm"] for scan in scans if scan["shift_median_mm"] is not None]
    return {
        "score_from": _join(scan["method"] for scan in scans),
        "beam": _join(scan["beam"] for scan in scans),
        "threshold": scans[0]["threshold"],
        "sure": scans[0]["sure"],
        **{name: sum(scan[name] for scan in scans) for name in SUMMED},
        "shift_median_mm": moved[0] if len(scans) == 1 and moved else None,
        "reason_numbers": {str(int(number)): word for number, word in REASONS.items()},
        "notes": list(dict.fromkeys(note for scan in scans for note in scan["notes"])),
        "scans": list(scans),
    }


def _join(texts: Any) -> str:
    return "; ".join(dict.fromkeys(texts))

"""The command that cleans a scan of ghost points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from cyclopts import Parameter

from app.cli.commands import (
    DEFAULT_FOOTPRINT,
    DEFAULT_PLANES,
    DEFAULT_READING,
    Footprint,
    Json,
    Overwrite,
    Reading,
    opening,
    parameters_of,
)
from app.cli.console import watch
from app.core.errors import WrongUse

MOST_LEAVES = 20
"""That are printed; the report has all."""


@Parameter(name="*")
@dataclass(frozen=True)
class Strictness:
    """How strict the search is, and what becomes of the doubtful."""

    setting: Literal["careful", "normal", "strict"] | None = None
    "careful: few good points lost (0.8); normal (default): 0.5; strict: few ghosts stay (0.2)."
    threshold: float | None = None
    "Score from which on a point is a ghost, above 0 and up to 1, instead of the setting's."
    sure: float | None = None
    "Confidence from which a ghost is corrected, 0 to 1 (default: where the method is sure)."
    uncertain: Literal["delete", "mark"] | None = None
    "What becomes, in mode auto, of ghosts that cannot be corrected: delete, or mark (default: "
    "delete; mark where the scan has no rows and columns, since the score is a weaker one there)."


@Parameter(name="*")
@dataclass(frozen=True)
class CountedLeaves:
    """Leaves by which changes are counted; a session has its own."""

    label_field: str | None = None
    "Field whose whole numbers from 0 on name the leaves, to count changes by."
    find_leaves: bool = False
    "Find leaves by connectivity, to count changes by."


DEFAULT_STRICTNESS, NO_LEAVES = Strictness(), CountedLeaves()


def clean(
    file: Path,
    /,
    *,
    mode: Literal["mark", "delete", "correct", "auto"],
    out: Path,
    how: Strictness = DEFAULT_STRICTNESS,
    leaves: CountedLeaves = NO_LEAVES,
    report: Path | None = None,
    beam: Footprint = DEFAULT_FOOTPRINT,
    reading: Reading = DEFAULT_READING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Find ghost points and mark, delete or correct them.

    Parameters
    ----------
    file
        A scan, or a session: what you answered there is done, what you keep is kept.
    mode
        mark: keep all points and write the fields ghost, ghost_score, ghost_reason and
        ghost_confidence; delete: leave ghosts out; correct: put them back on their surface where
        that is sure, and mark the others; auto: the same, and delete the others.
    out
        File to write. After correct and auto it holds for each point how far it was moved
        (ghost_moved, mm along the beam; ghost_moved_x, _y, _z, metres: take them off again to
        have what was measured) and how sure that is (ghost_moved_confidence).
    report
        JSON file with settings and counts: by answer, by reason, by leaf with its area, and how
        far points were moved.
    """
    from app.cli.printing import print_json, write_json
    from app.core.ghosts import SURE
    from app.formats.atomic import is_same_file, refuse_target
    from app.services.cleanup.answers import SETTINGS
    from app.services.cleanup.files import CleanRequest, clean_file

    if report is not None:
        if is_same_file(report, out):
            raise WrongUse(f"{out} cannot be both the result and the report.")
        refuse_target(report, overwrite, sources=[file])
    _refuse_contradictions(mode, how, leaves)
    threshold = SETTINGS[how.setting] if how.setting is not None else how.threshold
    request = CleanRequest(
        mode,
        SURE if how.sure is None else how.sure,
        how.uncertain,
        leaves.label_field,
        leaves.find_leaves,
        parameters_of(DEFAULT_PLANES, beam, threshold),
    )
    found = clean_file(opening(file, reading), out, request, overwrite, watch())
    found["setting"] = _name_setting(found["threshold"])
    if report is not None:
        write_json(found, report, overwrite)
    if json:
        print_json(found)
    else:
        _print(found, out, report is not None)


def _name_setting(threshold: float) -> str:
    from app.services.cleanup.answers import SETTINGS

    return next((name for name, value in SETTINGS.items() if value == threshold), "own")


def _refuse_contradictions(mode: str, how: Strictness, leaves: CountedLeaves) -> None:
    """Options that would have no say are refused, not passed over."""
    if how.setting is not None and how.threshold is not None:
        raise WrongUse("--setting and --threshold both name a threshold.", "Give one of them.")
    if how.sure is not None and mode not in ("correct", "auto"):
        raise WrongUse(f"--sure is about corrections, and mode {mode} makes none.")
    if how.uncertain is not None and mode != "auto":
        raise WrongUse(f"--uncertain belongs to mode auto, not to mode {mode}.")
    if leaves.label_field is not None and leaves.find_leaves:
        raise WrongUse("Leaves come from --label-field or from --find-leaves, not from both.")


def _print(found: Mapping[str, Any], out: Path, reported: bool) -> None:
    from app.cli.printing import print_warnings, say

    share = found["ghosts"] / max(found["points"], 1)
    say(f"{found['ghosts']:,} ghosts among {found['points']:,} points ({share:.2%})")
    say(f"score: {found['score_from']}; threshold {found['threshold']:g} ({found['setting']})")
    say(f"beam: {found['beam']}")
    for name in ("corrected", "deleted", "kept", "left_marked"):
        if found[name]:
            say(f"{name.replace('_', ' ')}: {found[name]:,}")
    if found["shift_median_mm"] is not None:
        say(f"corrected ghosts moved by {found['shift_median_mm']:.1f} mm (median)")
    for scan in found["scans"]:
        for reason, counts in scan["reasons"].items():
            say(f"{reason}: {sum(counts.values()):,}")
    leaves = [leaf for scan in found["scans"] for leaf in scan["leaves"]]
    changed = [leaf for leaf in leaves if leaf["corrected"] + leaf["deleted"]]
    for leaf in changed[:MOST_LEAVES]:
        say(_describe_leaf(leaf))
    if leaves:
        rest = max(len(changed) - MOST_LEAVES, 0)
        say(f"{len(leaves)} leaves, {len(changed)} changed{f', {rest} more' if rest else ''}")
    elif reported:
        say(f"by leaf: {found['scans'][0]['no_leaves']}")
    print_warnings(found["notes"])
    say(f"{out} written.")


def _describe_leaf(leaf: Mapping[str, Any]) -> str:
    before, after = leaf["area_before_cm2"], leaf["area_after_cm2"]
    areas = "no mesh" if before is None or after is None else f"{before:.2f} → {after:.2f} cm²"
    return (
        f"{leaf['name']}: {leaf['before']:,} → {leaf['after']:,} points, {areas}, "
        f"{leaf['corrected']:,} corrected, {leaf['deleted']:,} deleted"
    )

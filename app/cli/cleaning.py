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


@Parameter(name="*")
@dataclass(frozen=True)
class Strictness:
    """How strict the search is, and what becomes of the doubtful."""

    setting: Literal["careful", "normal", "strict"] | None = None
    "careful: few good points lost (0.8); normal (default): 0.5; strict: few ghosts stay (0.2)."
    threshold: float | None = None
    "Score from which a point is a ghost, 0 to 1, instead of the setting's."
    sure: float | None = None
    "Confidence from which a ghost is corrected, 0 to 1 (default: where the method is sure)."
    uncertain: Literal["delete", "mark"] | None = None
    "What becomes, in mode auto, of ghosts that cannot be corrected: delete (default), or mark."


DEFAULT_STRICTNESS = Strictness()


def clean(
    file: Path,
    /,
    *,
    mode: Literal["mark", "delete", "correct", "auto"],
    out: Path,
    how: Strictness = DEFAULT_STRICTNESS,
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
        A scan.
    mode
        mark: keep all points and write the fields ghost, ghost_score, ghost_reason and
        ghost_confidence; delete: leave ghosts out; correct: put them back on their surface where
        that is sure, and mark the others; auto: the same, and delete the others.
    out
        File to write.
    report
        JSON file with settings and counts: by answer, by reason, by leaf, and how far points
        were moved.
    """
    from app.cli.printing import print_json, write_json
    from app.core.ghosts import SURE
    from app.formats.atomic import is_same_file, refuse_target
    from app.services.cleanup.answers import SETTINGS
    from app.services.cleanup.files import clean_file

    if report is not None:
        if is_same_file(report, out):
            raise WrongUse(f"{out} cannot be both the result and the report.")
        refuse_target(report, overwrite, sources=[file])
    _refuse_contradictions(mode, how)
    setting = how.setting or "normal"
    threshold = SETTINGS[setting] if how.threshold is None else how.threshold
    found = clean_file(
        opening(file, reading),
        mode,
        out,
        parameters_of(DEFAULT_PLANES, beam, threshold),
        overwrite,
        watch(),
        SURE if how.sure is None else how.sure,
        how.uncertain or "delete",
    )
    found["setting"] = setting if how.threshold is None else "threshold"
    if report is not None:
        write_json(found, report, overwrite)
    if json:
        print_json(found)
    else:
        _print(found, out)


def _refuse_contradictions(mode: str, how: Strictness) -> None:
    """Options that would have no say are refused, not passed over."""
    if how.setting is not None and how.threshold is not None:
        raise WrongUse("--setting and --threshold both name a threshold.", "Give one of them.")
    if how.sure is not None and mode not in ("correct", "auto"):
        raise WrongUse(f"--sure is about corrections, and mode {mode} makes none.")
    if how.uncertain is not None and mode != "auto":
        raise WrongUse(f"--uncertain belongs to mode auto, not to mode {mode}.")


def _print(found: Mapping[str, Any], out: Path) -> None:
    from app.cli.printing import say

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
    say(f"{out} written.")

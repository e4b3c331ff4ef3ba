"""The command that corrects for the angle of incidence; `app.cli.commands` knows it by name."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from app.cli.commands import (
    DEFAULT_PLANES,
    DEFAULT_READING,
    Json,
    Overwrite,
    Planes,
    Reading,
    opening,
    parameters_of,
)
from app.cli.console import watch
from app.cli.printing import count_of, print_json, print_warnings, say

if TYPE_CHECKING:
    from app.services.workflow_table import WorkflowTable


def correct(
    file: Path,
    /,
    *,
    out: Path,
    channel: tuple[str, ...] = (),
    workflow: tuple[str, ...] = ("wf2", "wf3"),
    fit: Literal["all", "leaf", "none"] = "all",
    least_bracket: float = 0.25,
    label_field: str | None = None,
    planes: Planes = DEFAULT_PLANES,
    reading: Reading = DEFAULT_READING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Correct leaves for their angle of incidence: workflows WF1, WF2 and WF3 side by side.

    Parameters
    ----------
    file
        A scan.
    out
        CSV file to write, a row per leaf and channel.
    channel
        Channel to correct (may be repeated); all of them where none is named.
    workflow
        wf2 (angle), wf3 (specular share removed, then angle) or wf3_subtracted (may be repeated).
    fit
        all: one fit for all leaves of the scan, as for a species; leaf: each on its own, for
        leaves that hold many angles; none: what --correct says.
    least_bracket
        Points whose 1 − b(1 − cos ω) is smaller are marked and not corrected.
    label_field
        Field whose whole numbers from 0 on name the leaves; without it leaves are found by
        connectivity.
    """
    from app.services.workflow_table import Wanted, tabulate_workflows

    found = tabulate_workflows(
        opening(file, reading),
        out,
        Wanted(channel, workflow, None if fit == "none" else fit, least_bracket),
        label_field=label_field,
        parameters=parameters_of(planes),
        overwrite=overwrite,
        progress=watch(),
    )
    _print(found, out, json)


def _print(found: WorkflowTable, out: Path, as_json: bool) -> None:
    if as_json:
        print_json(found.as_dict())
        return
    for row in found.rows:
        parts = [f"{row['name']}, {row['channel']}"]
        for key in row:
            workflow, _, what = key.rpartition("_")
            if what == "mean":
                parts.append(f"{workflow} {_show(row[key])} ± {_show(row[f'{workflow}_sd'])}")
                marked = row[f"{workflow}_marked"]
                parts[-1] += f" ({marked} marked)" if marked else ""
        say("  ".join(parts))
    print_warnings(found.warnings)
    say(f"{count_of(len(found.rows), 'row', 'rows')}; {out} written.")


def _show(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else "–"

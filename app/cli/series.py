"""The command that carries leaves through a series; `app.cli.commands` knows it by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from app.cli.commands import (
    DEFAULT_FOOTPRINT,
    DEFAULT_PLANES,
    DEFAULT_READING,
    Footprint,
    Json,
    Overwrite,
    Planes,
    Reading,
    opening,
    parameters_of,
)
from app.cli.console import watch
from app.cli.printing import count_of, print_json, print_warnings, say
from app.core.errors import BadInput
from app.core.units import MM_PER_M

if TYPE_CHECKING:
    from app.core.carry import Tolerance


@Parameter(name="*")
@dataclass(frozen=True)
class Carrying:
    """How far a leaf may be from where it is looked for, millimetres."""

    along: float = 5.0
    "In range, mm (default 5), beside four times the leaf's own thickness."
    across: float = 0.0
    "At right angles to the beam, mm (default 0), beside half a step between beams."
    movement: float = 10.0
    "In any direction, mm (default 10), for leaves that stand free: drooping, wind, an inexact \
holder."


@Parameter(name="*")
@dataclass(frozen=True)
class Holder:
    """What is different from scan to scan."""

    angle_from: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    "Angles of the holder, degrees: name, a pattern of names such as leaf_{angle}.laz, a CSV with \
columns file and angle, or numbers with commas between (default: name)."
    time_from: str | None = None
    "Times: as angle_from, with {hours} or {time}; hours, or times as 2024-05-01T10:30."
    axis: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    "Axis of the holder: X,Y,Z,DX,DY,DZ (a point and a direction), or fit (default: fit where \
angles change)."
    same_pose: bool = False
    "Nothing turns: leaves are looked for where they were."


USUALLY, AS_NAMED = Carrying(), Holder()


def series(
    scans: tuple[Path, ...] = (),
    /,
    *,
    leaves: str,
    out: Path,
    holder: Holder = AS_NAMED,
    reference: Path | None = None,
    label_field: str | None = None,
    full_hits: bool = False,
    carrying: Carrying = USUALLY,
    planes: Planes = DEFAULT_PLANES,
    beam: Footprint = DEFAULT_FOOTPRINT,
    reading: Reading = DEFAULT_READING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Carry the leaves of one scan to others, and measure them over angle or time.

    Parameters
    ----------
    scans
        Scans, or a folder of scans; none: those of the series in the session.
    leaves
        Where the leaves are: a .leafscope session, a scan with a label field, or find.
    out
        CSV file to write, a row per leaf and scan.
    reference
        With --leaves find: the scan in which leaves are found (default: nearest to angle 0).
    label_field
        Field of whole numbers from 0 on that names the leaves of a scan.
    full_hits
        Leave out points that the beam hits in part (needs rows, columns and the instrument).
    """
    from app.services.series.order import SeriesOrder
    from app.services.series.tabulate import tabulate_series

    order = SeriesOrder(
        files=scans,
        leaves=leaves,
        angle_from=holder.angle_from,
        time_from=holder.time_from,
        axis=holder.axis,
        same_pose=holder.same_pose,
        reference=reference,
        label_field=label_field,
        tolerance=_tolerance(carrying),
        opening=opening(Path(), reading),
        parameters=parameters_of(planes, beam),
        full_hits=full_hits,
    )
    table = tabulate_series(order, out, overwrite, watch())
    _print(table.as_dict() | {"table": str(out)}, json)
    if table.unread:
        raise BadInput(
            f"{len(table.unread)} of {len(table.understood.entries)} scans could not be used; "
            f"their rows in {out} are empty.",
            "Mend or leave them out, and run it again.",
        )


def _tolerance(carrying: Carrying) -> Tolerance:
    from app.core.carry import Tolerance

    lengths = (carrying.along, carrying.across, carrying.movement)
    return Tolerance(*(length / MM_PER_M for length in lengths))


def _print(found: Mapping[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(found)
        return
    say(f"{count_of(found['scans'], 'scan', 'scans')}: {found['understood']}")
    if found["axis"] is not None:
        say(_describe_axis(found["axis"]))
    counts = found["verdicts"]
    told = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
    for row in found["rows"]:
        if row["verdict"] in ("check", "vanished"):
            say(f"{row['verdict']}: {row['name']} in {row['file']}. {row['reason']}")
    print_warnings(found["warnings"])
    say(f"{count_of(len(found['rows']), 'row', 'rows')} ({told}); {found['table']} written.")


def _describe_axis(axis: Mapping[str, Any]) -> str:
    point, direction = (
        ", ".join(f"{value:.4g}" for value in axis[name]) for name in ("point", "direction")
    )
    line = f"axis: through {point}, along {direction} ({axis['origin']})"
    if axis["tilt_rms_deg"] is not None:
        line += f"; planes differ by {axis['tilt_rms_deg']:.2g}° and {axis['offset_rms_mm']:.2g} mm"
    return line

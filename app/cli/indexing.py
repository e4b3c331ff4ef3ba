"""The commands about indices; `app.cli.commands` knows them by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cyclopts import Parameter

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
from app.core.errors import WrongUse

if TYPE_CHECKING:
    from app.services.index_angle import IndexAngles


@Parameter(name="*")
@dataclass(frozen=True)
class Leaves:
    """Which values belong to one leaf."""

    angle: str | None = None
    "Tables: column of the holder angle, degrees; then --channel NAME=NM names the columns."
    group: tuple[str, ...] = ()
    "Tables: column that tells leaves apart (may be repeated)."
    together: bool = False
    "Scans: all leaves as one, for flat leaves hold one angle each."
    label_field: str | None = None
    "Scans: field whose whole numbers from 0 on name the leaves; else found by connectivity."


EACH_LEAF = Leaves()


def index_angle(
    file: Path,
    /,
    *,
    index: str,
    out: Path,
    curve: Path | None = None,
    model: str | None = None,
    leaves: Leaves = EACH_LEAF,
    planes: Planes = DEFAULT_PLANES,
    reading: Reading = DEFAULT_READING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Compare an index at all angles: its curve, its range, and whether that exceeds the noise.

    Parameters
    ----------
    file
        A scan, or with --angle a CSV table of leaves, holder angles and channels.
    index
        ndi, ndvi, wi, lri, nldi, one of these with _wf2 or _wf3, or a formula such as
        "(r1063 - r1545) / (r1063 + r1545)".
    out
        CSV file to write, a row per leaf.
    curve
        CSV file for the curves, a row per angle.
    model
        Curve fitted to each channel: fourier-2 for scans and cosine for tables, if not said.
    """
    from app.formats.atomic import refuse_targets
    from app.services import index_angle_files as service
    from app.services.index_angle import write_index_angles

    refuse_targets(filter(None, (out, curve)), overwrite, [file])
    if leaves.angle is not None:
        found = _read_angles(file, index, leaves, reading, model or service.OF_TABLE)
    else:
        found = service.index_angle_of_file(
            opening(file, reading),
            index,
            label_field=leaves.label_field,
            together=leaves.together,
            model=model or service.OF_SCAN,
            parameters=parameters_of(planes),
            progress=watch(),
        )
    write_index_angles(found, out, curve, overwrite)
    _print_angles(found, out, json)


def _read_angles(
    file: Path, index: str, leaves: Leaves, reading: Reading, model: str
) -> IndexAngles:
    from app.services.index_angle_files import index_angle_of_table

    if not reading.channel:
        raise WrongUse("Name the columns of the channels: --channel NAME=NM.")
    return index_angle_of_table(
        file, index, leaves.angle or "", reading.channel, group=leaves.group, model=model
    )


def _print_angles(found: IndexAngles, out: Path, as_json: bool) -> None:
    if as_json:
        print_json(found.as_dict())
        return
    for pick in found.index.picks:
        say(pick.words)
    for name, row in zip(found.names, found.rows, strict=True):
        beyond = "exceeds" if row.get("A_exceeds_noise") else "does not exceed"
        say(
            f"{name}: {found.index.name} {_show(row['measured_min'])} to "
            f"{_show(row['measured_max'])}, mean {_show(row.get('index_mean'))}, amplitude "
            f"{_show(row.get('A'))} ({beyond} noise, which gives {_show(row.get('A_from_noise'))})"
        )
    print_warnings(found.warnings)
    say(f"{count_of(len(found.rows), 'row', 'rows')}; {out} written.")


def synthetic_footprint(
    file: Path,
    /,
    *,
    index: str,
    out: Path,
    size: tuple[float, ...] = (),
    error: float = 0.02,
    label_field: str | None = None,
    reading: Reading = DEFAULT_READING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Average channels over footprints of several sizes: how the spread of an index falls.

    Parameters
    ----------
    file
        A scan.
    index
        A named index or a formula; see index-angle.
    out
        CSV file to write, a row per size.
    size
        Diameter across the beam, mm (may be repeated).
    error
        Spread (standard deviation) that is to be reached.
    label_field
        Only points of leaves that this field names count.
    """
    from app.core.units import MM_PER_M
    from app.services.synthetic_footprints import DIAMETERS, tabulate_spread

    sizes = tuple(each / MM_PER_M for each in size) or DIAMETERS
    found = tabulate_spread(
        opening(file, reading),
        out,
        index,
        sizes,
        label_field=label_field,
        error=error,
        overwrite=overwrite,
        progress=watch(),
    )
    if json:
        print_json(found.as_dict())
        return
    for pick in found.index.picks:
        say(pick.words)
    for row in found.rows:
        points = f"{row['points']:g} points" if row["points"] is not None else "no points"
        say(f"{row['diameter_mm']:g} mm: sd {_show(row['sd'])}, {points}")
    if found.reached_mm is None:
        say(f"an error of {error:g} is not reached")
    else:
        say(f"an error of {error:g} is reached from {found.reached_mm:.4g} mm on")
    say(f"{out} written.")


def _show(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else "–"

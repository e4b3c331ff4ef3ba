"""The command that compares scans of the same samples; `app.cli.commands` knows it by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from app.cli.commands import Json, Overwrite
from app.cli.console import watch
from app.cli.printing import count_of, print_json, print_warnings, say
from app.core.errors import WrongUse
from app.core.units import MM_PER_M

if TYPE_CHECKING:
    from app.core.radiometry.profile import Profile
    from app.services.opening import Opening
    from app.services.samples import SampleTable


@Parameter(name="*")
@dataclass(frozen=True)
class Scans:
    """How the scans are understood; each option may be repeated, in the order of the scans."""

    channel: tuple[str, ...] = ()
    "Name a channel by hand, [SCAN:]NAME=WAVELENGTH:KIND; SCAN is its number, from 1."
    profile: tuple[str, ...] = ()
    "Calibrate by profiles, one for each scan in their order; none for none."
    full_hits: bool = False
    "Leave out points that the beam hits in part (needs rows, columns and the instrument)."


AS_THEY_ARE = Scans()


def sample(
    scans: tuple[Path, ...],
    /,
    *,
    out: Path,
    index: tuple[str, ...] = (),
    label_field: str | None = None,
    leaves: bool = False,
    pair_within: Annotated[float | None, Parameter(show_default=False)] = None,
    reading: Scans = AS_THEY_ARE,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Means of samples that one or more instruments scanned, and indices of the means.

    Parameters
    ----------
    scans
        Scans of the same samples.
    out
        CSV file to write, a row per sample.
    index
        ndi, ndvi, wi, lri or nldi (may be repeated).
    label_field
        Field whose whole numbers from 0 on name the samples, the same in all scans.
    leaves
        Find the leaves of each scan and match them by place. Without either, each scan is one
        sample as a whole.
    pair_within
        Also pair nearest points of two scans, within so many millimetres.
    """
    from app.services.samples import Wanted, tabulate_files

    within = None if pair_within is None else pair_within / MM_PER_M
    table = tabulate_files(
        _openings(scans, reading),
        out,
        Wanted(index, reading.full_hits, within),
        label_field=label_field,
        by_leaf=leaves,
        overwrite=overwrite,
        progress=watch(),
    )
    _print(table, index, out, json)


def _openings(scans: Sequence[Path], reading: Scans) -> list[Opening]:
    """What a service is told about each file."""
    from app.services.opening import Opening

    if reading.profile and len(reading.profile) != len(scans):
        raise WrongUse(
            f"There are {len(scans)} scans and {len(reading.profile)} profiles.",
            "Give one --profile for each scan, in their order; none for none.",
        )
    profiles = [_find(name) for name in reading.profile] or [None] * len(scans)
    return [
        Opening(path, channels=_channels_of(number, len(scans), reading.channel), profile=profile)
        for number, (path, profile) in enumerate(zip(scans, profiles, strict=True), 1)
    ]


def _find(name: str) -> Profile | None:
    from app.services.profiles import find_profile

    return None if name == "none" else find_profile(name)


def _channels_of(number: int, total: int, texts: Sequence[str]) -> tuple[str, ...]:
    """The channels that are named for one scan; those without a number are for all."""
    found = []
    for text in texts:
        scan, colon, rest = text.partition(":")
        if not (colon and scan.isdecimal() and "=" in rest):
            found.append(text)
        elif not 1 <= int(scan) <= total:
            raise WrongUse(f"{text!r} names a channel of scan {scan}; there are {total} scans.")
        elif int(scan) == number:
            found.append(rest)
    return tuple(found)


def _print(table: SampleTable, index: Sequence[str], out: Path, as_json: bool) -> None:
    if as_json:
        print_json(table.as_dict())
        return
    for row in table.rows:
        values = (f"{name} {_show(row[f'{name}_of_means'])}" for name in index)
        say("  ".join((str(row["sample"]), *values)))
    for name, pairs in table.pairs.items():
        matched = pairs["matched_shares"].items()
        shares = ", ".join(f"{share:.1%} of the points of {scan}" for scan, share in matched)
        say(f"{name}: {pairs['pairs']:,} pairs of points, {shares}")
    print_warnings(table.warnings)
    say(f"{count_of(len(table.rows), 'sample', 'samples')}; {out} written.")


def _show(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else "–"

"""The command that measures wrinkles; `app.cli.commands` knows it by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

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
from app.core.errors import WrongUse

if TYPE_CHECKING:
    from app.services.wrinkles.request import Source, WrinkleRequest
    from app.services.wrinkles.run import WrinkleReport


@Parameter(name="*")
@dataclass(frozen=True)
class CurveOf:
    """Where the curve comes from, and what is added to it."""

    curve: Path | None = None
    "Curve from a goniometer table: CSV with columns angle (degrees) and value."
    species: str | None = None
    "Curve published for a species, e.g. maple; without both, one through all leaves of the scan."
    own: Annotated[bool, Parameter(negative="")] = False
    "A curve of each leaf's own: only leaves that bend by 10° or more have one."
    reflectance: float | None = None
    "With --species: its reflectance at ω = 0; without it, the median of the scan's leaves."
    scatter: float | None = None
    "With --species: how reflectance scatters from leaf to leaf, a share (default 0.08)."
    model: str | None = None
    "Model of the curve (default lambert-beckmann, polynomial-4 for DN)."
    offset: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    "With --curve or --species: fit (each leaf's mean is its plane's), DN added, or a factor."
    wavelength: str | None = None
    "Name of the channel to read (default the first)."


@Parameter(name="*")
@dataclass(frozen=True)
class Validity:
    """What is valid."""

    steepest: float = 60.0
    "Angles beyond so many degrees are not valid (default 60)."
    largest_sigma: float = 15.0
    "Angles less certain than so many degrees are not valid (default 15)."
    noise: float | None = None
    "Noise of one value: a share of it, or DN of a logarithmic scale; measured where not given."
    saturated: float | None = None
    "Values from here on are saturated; the instrument's own end where it is known."
    means: Literal["on", "off"] = "on"
    "Average over the beam's footprint before reading the curve (default on)."


ANY_CURVE, USUAL_VALIDITY = CurveOf(), Validity()


def wrinkles(
    scan: Path,
    /,
    *,
    out: Path,
    label_field: Annotated[str | None, Parameter(name=("--label-field", "--leaves"))] = None,
    map: Path | None = None,
    curve: Annotated[CurveOf, Parameter(name="*")] = ANY_CURVE,
    validity: Annotated[Validity, Parameter(name="*")] = USUAL_VALIDITY,
    planes: Planes = DEFAULT_PLANES,
    beam: Footprint = DEFAULT_FOOTPRINT,
    reading: Reading = DEFAULT_READING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Wrinkles of leaves: angles from intensity against each leaf's plane, a row per leaf.

    With nothing but the scan, one curve is fitted to all its leaves, each leaf's mean is set to
    its plane, and differences inside the leaf (Δω) are claimed. --curve and --species claim more.

    Parameters
    ----------
    scan
        A scan.
    out
        Table to write, .csv or .json.
    label_field
        Field whose whole numbers from 0 on name the leaves; without it leaves are found by
        connectivity.
    map
        Picture to draw (.png, .svg, .pdf): up to six leaves from the scanner, from the side, and
        the distribution of Δω.
    """
    from app.services.wrinkles.run import tabulate_wrinkles

    request = _request(curve, validity, beam)
    parameters = parameters_of(planes, beam)
    report = tabulate_wrinkles(
        opening(scan, reading), out, request, label_field, parameters, map, overwrite, watch()
    )
    _print(report, json)


def _request(curve: CurveOf, validity: Validity, beam: Footprint) -> WrinkleRequest:
    from app.core.units import to_radians
    from app.core.wrinkling.leaf import Choices
    from app.core.wrinkling.validity import Limits
    from app.services.wrinkles.request import WrinkleRequest

    limits = Limits(float(to_radians(validity.steepest)), float(to_radians(validity.largest_sigma)))
    choices = Choices(validity.means == "on", validity.noise, limits)
    return WrinkleRequest(
        _source(curve), _offset(curve.offset), curve.wavelength, beam.instrument,
        validity.saturated, choices,
    )  # fmt: skip


def _source(curve: CurveOf) -> Source:
    from app.services.wrinkles.request import (
        SCATTER,
        OwnCurve,
        ScanCurve,
        SpeciesSource,
        TableCurve,
    )

    if (curve.curve is not None) + (curve.species is not None) + curve.own > 1:
        raise WrongUse("The curve comes from one of --curve, --species and --own.")
    if curve.species is None and (curve.reflectance is not None or curve.scatter is not None):
        raise WrongUse("--reflectance and --scatter belong to --species.")
    if curve.curve is not None:
        return TableCurve(curve.curve, curve.model)
    if curve.species is not None:
        if curve.model is not None:
            raise WrongUse("Curves of species are of Lambert–Beckmann; leave --model out.")
        scatter = SCATTER if curve.scatter is None else curve.scatter
        return SpeciesSource(curve.species, curve.reflectance, scatter)
    return OwnCurve(curve.model) if curve.own else ScanCurve(curve.model)


def _offset(text: str | None) -> Literal["fit"] | float | None:
    if text is None or text == "fit":
        return None if text is None else "fit"
    try:
        return float(text)
    except ValueError:
        raise WrongUse(f"--offset takes fit or a number, not {text!r}.") from None


def _print(report: WrinkleReport, as_json: bool) -> None:
    from app.cli.printing import count_of, print_json, print_warnings, say

    if as_json:
        print_json(report.as_dict())
        return
    for row in report.rows:
        index = row.get("wrinkle_index_deg")
        if index is None:
            say(f"{row['name']}  {row['refusal']}")
            continue
        say(
            f"{row['name']}  ω {row['omega_plane_deg']:.1f}°  wrinkle index {index:.1f}° "
            f"({row['wrinkle_index_low_deg']:.1f} to {row['wrinkle_index_high_deg']:.1f})  "
            f"{row['shape']}  {row['valid']} of {row['points']} points valid"
        )
    for claim in dict.fromkeys(row["claim"] for row in report.rows if row.get("claim")):
        say(str(claim))
    print_warnings(report.warnings)
    files = " and ".join(str(path) for path in report.written)
    say(f"{count_of(len(report.rows), 'leaf', 'leaves')}; {files} written.")

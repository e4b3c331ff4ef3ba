"""The command that plans a scan; `app.cli.commands` knows it by name."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from app.cli.commands import Json, Overwrite
from app.cli.printing import print_json, say
from app.core.errors import WrongUse

if TYPE_CHECKING:
    from app.services.planning import Plan, PlanOrder, Tool


@Parameter(name="*")
@dataclass(frozen=True)
class Scanner:
    """The instrument, or a beam of one's own."""

    instrument: str | None = None
    "A name (see simulate --list) or a TOML file."
    step: float | None = None
    "Step between beams, degrees (default: the instrument's)."
    exit_diameter: float | None = None
    "Own beam: its diameter where it leaves the scanner, mm."
    half_divergence: float | None = None
    "Own beam: HALF of the full divergence, degrees."
    ranging: Literal["phase-shift", "pulsed"] | None = None
    "Own beam: how it measures ranges (default phase-shift)."
    pulse_length: float | None = None
    "Own beam, pulsed: length of the pulse as range, c·τ/2, metres."


@Parameter(name="*")
@dataclass(frozen=True)
class Usable:
    """What counts as usable."""

    most_footprint: float = 45.0
    "Most of the leaf's width that the footprint may be long, percent (default 45)."
    full_hits: float = 50.0
    "Fewest beams that fall wholly on the leaf (default 50)."
    most_ghosts: float = 40.0
    "Largest share of ghosts among the leaf's points, percent (default 40)."


NOBODY, USUAL = Scanner(), Usable()


def plan(
    *,
    leaf: Annotated[str, Parameter(allow_leading_hyphen=True)],
    distance: Annotated[str, Parameter(name="--range", allow_leading_hyphen=True)] = "2:20",
    omega: Annotated[str, Parameter(allow_leading_hyphen=True)] = "0:85",
    behind: Annotated[str, Parameter(allow_leading_hyphen=True)] = "1",
    contrast: float = 1.0,
    scanner: Scanner = NOBODY,
    usable: Usable = USUAL,
    out: Path | None = None,
    figure: Path | None = None,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Plan a scan: footprint, points, ghosts and the largest usable angle on a leaf.

    Parameters
    ----------
    leaf
        Length and width of the leaf, mm: 80x45. The longer side is the length in either order.
    distance
        Ranges, metres: LOW:HIGH, LOW:HIGH:STEP or one (default 2:20).
    omega
        Angles of incidence, degrees: LOW:HIGH, LOW:HIGH:STEP or one (default 0:85).
    behind
        Metres from the leaf to what stands behind it, or none (default 1); it makes ghosts.
    contrast
        Reflectance of what stands behind over the leaf's (default 1).
    out
        Table to write, .csv (a row per range and angle) or .json.
    figure
        Figure to write, .png, .svg or .pdf.
    """
    from app.services.planning import make_plan

    _refuse(out, figure, overwrite)
    found = make_plan(_order(leaf, distance, omega, behind, contrast, scanner, usable))
    _write(found, out, figure, overwrite)
    _print(found, [path for path in (out, figure) if path is not None], json)


def _order(
    leaf: str,
    distance: str,
    omega: str,
    behind: str,
    contrast: float,
    scanner: Scanner,
    usable: Usable,
) -> PlanOrder:
    from app.core.planning import Limits
    from app.services.plan_texts import parse_leaf, parse_span
    from app.services.planning import PlanOrder

    length, width = parse_leaf(leaf)
    return PlanOrder(
        _find_tool(scanner),
        length,
        width,
        parse_span(distance, "--range"),
        parse_span(omega, "--omega"),
        _parse_behind(behind),
        contrast,
        Limits(usable.most_footprint / 100.0, usable.full_hits, usable.most_ghosts / 100.0),
    )


def _find_tool(scanner: Scanner) -> Tool:
    from app.services.beams import typed_beam
    from app.services.planning import tool_of, typed_tool

    numbers = (scanner.exit_diameter, scanner.half_divergence)
    if scanner.instrument is not None:
        own = (*numbers, scanner.ranging, scanner.pulse_length)
        if any(each is not None for each in own):
            raise WrongUse(
                "An instrument brings its own beam and ranging: leave --exit-diameter, "
                "--half-divergence, --ranging and --pulse-length out, or --instrument."
            )
        return tool_of(scanner.instrument, scanner.step)
    if scanner.exit_diameter is None or scanner.half_divergence is None or scanner.step is None:
        raise WrongUse(
            "A plan needs --instrument, or --exit-diameter (mm), --half-divergence and --step "
            "(degrees)."
        )
    pulsed = scanner.ranging == "pulsed"
    if pulsed != (scanner.pulse_length is not None):
        raise WrongUse(
            "--ranging pulsed and --pulse-length (metres) belong together.", "Give both or neither."
        )
    beam = typed_beam(scanner.exit_diameter, scanner.half_divergence)
    return typed_tool(beam, scanner.step, scanner.pulse_length)


def _parse_behind(text: str) -> float | None:
    if text.strip().lower() == "none":
        return None
    try:
        metres = float(text)
    except ValueError:
        metres = math.nan
    if not 0.0 < metres < math.inf:
        raise WrongUse(
            f"--behind takes metres above 0, or none where nothing stands, not {text!r}."
        )
    return metres


def _refuse(out: Path | None, figure: Path | None, overwrite: bool) -> None:
    """Raise before the work where its files could not be written."""
    from app.formats.atomic import refuse_targets
    from app.services.lab.figure import figure_kind
    from app.services.plan_files import check_ending

    if out is not None:
        check_ending(out)
    if figure is not None:
        figure_kind(figure)
    refuse_targets(filter(None, (out, figure)), overwrite)


def _write(found: Plan, out: Path | None, figure: Path | None, overwrite: bool) -> None:
    from app.services.plan_figure import draw_plan
    from app.services.plan_files import write_plan

    if out is not None:
        write_plan(found, out, overwrite)
    if figure is not None:
        draw_plan(found, figure, overwrite)


def _print(found: Plan, written: list[Path], as_json: bool) -> None:
    from app.services.plan_files import as_dict
    from app.services.plan_texts import (
        describe_leaf,
        describe_tool_line,
        list_assumptions,
        tell_limits,
        tell_range,
    )

    if as_json:
        print_json(as_dict(found))
        return
    say(f"{describe_tool_line(found)}; {describe_leaf(found)}")
    for row in found.rows:
        say(tell_range(row))
    say(tell_limits(found))
    for line in list_assumptions(found):
        say(line)
    for path in written:
        say(f"{path} written.")

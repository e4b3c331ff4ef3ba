"""The commands that fit curves; `app.cli.commands` knows them by name."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

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
from app.core.errors import WrongUse

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.core.phase.formula_model import FormulaDefinition
    from app.model.fit_method import Method
    from app.services.lab.orders import FitOrder, LabReport, PairGroup


@Parameter(name="*")
@dataclass(frozen=True)
class Fitting:
    """What is fitted, and how."""

    model: str | None = None
    "lambert, lambert-beckmann, lommel-seeliger, incidence-b, cosine, fourier-2, polynomial-4, or \
a model of your own by its name."
    formula_model: Path | None = None
    "A model of your own from a TOML file, instead of --model."
    on: Literal["points", "bins", "edge"] = "points"
    "points: single points (default); bins: means per step of the angle; edge: the upper edge."
    quantile: float | None = None
    "With --on edge: share of the points below the curve (default 0.95)."
    bin_width: float = 5.0
    "Of a step of the angle, degrees (default 5)."
    loss: Literal["squares", "huber", "tukey"] = "squares"
    "Of single points: squares (default), or huber or tukey against outliers."
    angles: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    "Fit only angles from LOW up to HIGH, degrees, LOW,HIGH."
    fix: tuple[str, ...] = ()
    "Hold a parameter, NAME=VALUE, e.g. m=0.3 (may be repeated)."
    compare: bool = False
    "Set all models side by side, with AIC, AICc and BIC."


@Parameter(name="*")
@dataclass(frozen=True)
class Writing:
    """Files beside what is printed."""

    table: Path | None = None
    "Write the fits as .csv, .tsv, .tex (booktabs) or .json."
    wide: bool = False
    "Lay the table out as Kaasalainen does: a block per parameter, samples × channels."
    figure: Path | None = None
    "Draw points, means and curves as .png, .svg or .pdf."


PLAIN, NOTHING = Fitting(), Writing()


def fit(
    table: Path,
    /,
    *,
    x: str,
    y: str,
    group: tuple[str, ...] = (),
    fitting: Fitting = PLAIN,
    profile: Annotated[bool, Parameter(name=("--profile", "--profile-intervals"))] = False,
    bootstrap: str | None = None,
    trials: int = 1000,
    writing: Annotated[Writing, Parameter(name="*")] = NOTHING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Fit an angular model to a table of angles (degrees) and values.

    Parameters
    ----------
    table
        CSV file.
    x
        Column with the angle of incidence, degrees.
    y
        Column with the value.
    group
        Column to fit apart by (may be repeated).
    profile
        Profile intervals: how far each parameter can go while the others follow.
    bootstrap
        Column that tells leaves apart: intervals from leaves drawn with replacement.
    trials
        Draws of a bootstrap (default 1000).
    """
    from app.services.lab.sources import groups_of_table

    order = _order(fitting, profile, trials if bootstrap is not None else None)
    _refuse(writing, order, overwrite, table, fitting)
    groups = groups_of_table(table, x, y, group, bootstrap)
    _finish(groups, order, writing, (y, f"{x} (°)"), json, overwrite)


def fit_scan(
    scan: Path,
    /,
    *,
    channel: tuple[str, ...] = (),
    leaves: Literal["each", "together", "scan"] = "each",
    label_field: str | None = None,
    fitting: Fitting = PLAIN,
    profile_intervals: bool = False,
    bootstrap: bool = False,
    trials: int = 1000,
    out: Path | None = None,
    writing: Annotated[Writing, Parameter(name="*")] = NOTHING,
    planes: Planes = DEFAULT_PLANES,
    reading: Reading = DEFAULT_READING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Fit a model to the leaves of a scan in each of its channels.

    Parameters
    ----------
    scan
        A scan.
    channel
        Channel to fit (may be repeated), all that are not corrected where none is named; or
        NAME=WAVELENGTH:KIND to name one by hand.
    leaves
        each: every leaf is a sample; together: all leaves are one; scan: all of its points.
    label_field
        Field whose whole numbers from 0 on name the leaves; without it leaves are found by
        connectivity.
    profile_intervals
        How far each parameter can go while the others follow.
    bootstrap
        With --leaves together: intervals from leaves drawn with replacement.
    trials
        Draws of a bootstrap (default 1000).
    out
        Table to write, as --table.
    """
    from app.services.lab.sources import ScanOrder, pairs_of_scan

    if out is not None:
        if writing.table is not None:
            raise WrongUse("--out and --table are the same; give one.")
        writing = replace(writing, table=out)
    if bootstrap and leaves != "together":
        raise WrongUse("A bootstrap draws leaves that are fitted together: --leaves together.")
    order = _order(fitting, profile_intervals, trials if bootstrap else None)
    _refuse(writing, order, overwrite, scan, fitting)
    named = tuple(text for text in channel if "=" in text)
    chosen = tuple(text for text in channel if "=" not in text)
    found = pairs_of_scan(
        opening(scan, replace(reading, channel=named)),
        ScanOrder(chosen, leaves, label_field, parameters_of(planes)),
        watch(),
    )
    _finish(found.groups, order, writing, (found.value_title, ""), json, overwrite)


def _order(fitting: Fitting, profile: bool, trials: int | None) -> FitOrder:
    """What is to be done, checked before anything is read."""
    from app.services.lab.orders import FitOrder

    return FitOrder(
        _find_model(fitting), _method(fitting), fitting.compare, profile, trials,
        _parse_fixed(fitting.fix),
    )  # fmt: skip


def _find_model(fitting: Fitting) -> str | FormulaDefinition | None:
    from app.services.lab.own_models import find_model, read_model

    if fitting.formula_model is not None:
        if fitting.model is not None:
            raise WrongUse("The model is named by --model or --formula-model, not by both.")
        return read_model(fitting.formula_model)
    if fitting.model is not None:
        find_model(fitting.model)
    return fitting.model


def _method(fitting: Fitting) -> Method:
    from app.model.fit_method import Method

    if fitting.quantile is not None and fitting.on != "edge":
        raise WrongUse("--quantile belongs to --on edge.")
    low, high = _parse_angles(fitting.angles)
    quantile = 0.95 if fitting.quantile is None else fitting.quantile
    return Method(fitting.on, fitting.loss, quantile, fitting.bin_width, (low, high))


def _parse_angles(text: str | None) -> tuple[float, float]:
    try:
        low, high = (0.0, 90.0) if text is None else map(float, text.split(","))
    except ValueError:
        raise WrongUse(f"--angles takes two numbers in degrees, LOW,HIGH, not {text!r}.") from None
    return low, high


def _parse_fixed(texts: Sequence[str]) -> dict[str, float]:
    found = {}
    for text in texts:
        name, _, number = text.partition("=")
        try:
            found[name.strip()] = float(number)
        except ValueError:
            raise WrongUse(f"--fix takes NAME=VALUE, e.g. m=0.3, not {text!r}.") from None
    return found


def _refuse(
    writing: Writing, order: FitOrder, overwrite: bool, source: Path, fitting: Fitting
) -> None:
    """Raise before the work where its files could not be written."""
    from app.formats.atomic import refuse_targets
    from app.services.lab.figure import figure_kind
    from app.services.lab.table_files import kind_of

    if writing.table is not None:
        kind_of(writing.table)
        if order.model is None:
            raise WrongUse("A table holds fits of one model; say which by --model.")
    elif writing.wide:
        raise WrongUse("--wide is the layout of a --table; give one.")
    if writing.figure is not None:
        figure_kind(writing.figure)
    targets = filter(None, (writing.table, writing.figure))
    refuse_targets(targets, overwrite, filter(None, (source, fitting.formula_model)))


def _finish(
    groups: Sequence[PairGroup],
    order: FitOrder,
    writing: Writing,
    titles: tuple[str, str],
    as_json: bool,
    overwrite: bool,
) -> None:
    """Fit, write the files, and print."""
    from app.cli.printing_fits import print_lab
    from app.services.lab.orders import carry_out

    report = carry_out(groups, order, watch())
    written = _write(groups, report, writing, titles, overwrite)
    print_lab(report, written, as_json)


def _write(
    groups: Sequence[PairGroup],
    report: LabReport,
    writing: Writing,
    titles: tuple[str, str],
    overwrite: bool,
) -> list[Path]:
    from app.services.lab.figure import ANGLE, draw_figure
    from app.services.lab.figure_order import order_figure
    from app.services.lab.table_files import write_fits

    if writing.table is not None:
        write_fits(report.fits, writing.table, writing.wide, overwrite)
    if writing.figure is not None:
        figure = order_figure(groups, report.fits, titles[0], titles[1] or ANGLE)
        draw_figure(figure, writing.figure, overwrite)
    return [path for path in (writing.table, writing.figure) if path is not None]

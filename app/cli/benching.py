"""``leafscope bench``: measurements that anyone can make again, one command each."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from cyclopts import App, Parameter

from app.cli.commands import Json, Overwrite
from app.cli.console import LINE, watch

if TYPE_CHECKING:
    from app.services.bench.results import Bench, ResultTable, Value

WIDEST = 1000
"""Characters of a line of a table, where the output is no terminal."""

bench = App(
    name="bench",
    default_parameter=Parameter(negative=(), show_default=False),
    help="Measure how right and how fast Leafscope is.",
)


@bench.command
def simulate(
    *,
    out: Path | None = None,
    quick: bool = False,
    truth: Path | None = None,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Check the virtual scanner against closed forms, and time it.

    Parameters
    ----------
    out
        Folder for the tables as CSV and JSON, and for the picture.
    quick
        Fewer beams, angles, leaves and seeds: a few seconds.
    truth
        Folder with another simulator's scans (phase_shift, pulsed) to compare with.
    """
    from app.services.bench.simulate.run import bench_simulate, refuse_bench_simulate

    if out is not None:
        refuse_bench_simulate(out, truth, overwrite)
    finish(bench_simulate(quick, truth, watch()), out, json, overwrite)


@bench.command
def incidence(
    *,
    peers: bool = False,
    out: Path | None = None,
    radius: float = 0.004,
    quick: bool = False,
    truth: Path | None = None,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Measure time and error of the angles of incidence, method by method.

    Parameters
    ----------
    peers
        Take Open3D, CloudCompare and SciPy in, where they are installed: about ten minutes.
    out
        Folder for the tables as CSV and JSON, and for the picture.
    radius
        Metres, given to all methods.
    quick
        Small scans and few radii: half a minute.
    truth
        Folder with another simulator's scans (phase_shift, pulsed) to take in too.
    """
    from app.services.bench.incidence.run import bench_incidence, refuse_bench_incidence

    if out is not None:
        refuse_bench_incidence(out, overwrite)
    finish(bench_incidence(peers, radius, quick, truth, watch()), out, json, overwrite)


@bench.command
def planes(
    *,
    out: Path | None = None,
    quick: bool = False,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Measure the error of the planes of whole leaves, and check them on a goniometer.

    Parameters
    ----------
    out
        Folder for the tables as CSV and JSON, and for the picture.
    quick
        Few leaves and angles: some seconds instead of ten minutes.
    """
    from app.services.bench.planes.run import bench_planes, refuse_bench_planes

    if out is not None:
        refuse_bench_planes(out, overwrite)
    finish(bench_planes(quick, watch()), out, json, overwrite)


@bench.command
def radiometry(
    *,
    out: Path | None = None,
    quick: bool = False,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Measure time and error of the way from number to reflectance, and prove its error budget.

    Parameters
    ----------
    out
        Folder for the tables as CSV and JSON, and for the picture.
    quick
        Few points and seeds: some seconds instead of five minutes.
    """
    from app.services.bench.radiometry.run import bench_radiometry, refuse_bench_radiometry

    if out is not None:
        refuse_bench_radiometry(out, overwrite)
    finish(bench_radiometry(quick, watch()), out, json, overwrite)


@bench.command
def stability(
    *,
    out: Path | None = None,
    quick: bool = False,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Check that what must not change an angle of incidence or a reflectance does not.

    Parameters
    ----------
    out
        Folder for the tables as CSV and JSON.
    quick
        Smaller scans.
    """
    from app.services.bench.stability.run import bench_stability, refuse_bench_stability

    if out is not None:
        refuse_bench_stability(out, overwrite)
    finish(bench_stability(quick, watch()), out, json, overwrite)


@bench.command
def fit(
    *,
    out: Path | None = None,
    quick: bool = False,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Measure fits of angular models: time against excess error, and what intervals cover.

    Parameters
    ----------
    out
        Folder for the tables as CSV and JSON, and for the picture.
    quick
        Few curves and seeds: some seconds instead of five minutes.
    """
    from app.services.bench.fit.run import bench_fit, refuse_bench_fit

    if out is not None:
        refuse_bench_fit(out, overwrite)
    finish(bench_fit(quick, watch()), out, json, overwrite)


@bench.command
def ghosts(
    *,
    out: Path | None = None,
    quick: bool = False,
    truth: Path | None = None,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Measure how many ghost points are found and put back, against the truth and other ways.

    Parameters
    ----------
    out
        Folder for the tables as CSV and JSON, and for the pictures.
    quick
        Coarse scans of one seed: half a minute instead of a quarter of an hour.
    truth
        Folder with another simulator's scans (phase_shift, pulsed) to take in too.
    """
    from app.services.bench.ghosts.run import bench_ghosts, refuse_bench_ghosts

    if out is not None:
        refuse_bench_ghosts(out, overwrite)
    finish(bench_ghosts(quick, truth, watch()), out, json, overwrite)


@bench.command
def wrinkles(
    *,
    out: Path | None = None,
    quick: bool = False,
    truth: Path | None = None,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Hold angles from intensity, their intervals and the wrinkle index against the truth.

    Parameters
    ----------
    out
        Folder for the tables as CSV and JSON, and for the picture.
    quick
        One coarse scan: half a minute instead of several.
    truth
        Folder with another simulator's scans (phase_shift, pulsed) to take in too.
    """
    from app.services.bench.wrinkles.run import bench_wrinkles, refuse_bench_wrinkles

    if out is not None:
        refuse_bench_wrinkles(out, truth, overwrite)
    finish(bench_wrinkles(quick, truth, watch()), out, json, overwrite)


@bench.command
def area(
    *,
    out: Path | None = None,
    quick: bool = False,
    truth: Path | None = None,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Measure areas and segmentations of leaves: errors, intervals, and what peers make of them.

    Parameters
    ----------
    out
        Folder for the tables as CSV and JSON, and for the picture.
    quick
        One small scan: half a minute.
    truth
        Folder with another simulator's scans (phase_shift, pulsed) to take in too.
    """
    from app.services.bench.area.run import bench_area, refuse_bench_area

    if out is not None:
        refuse_bench_area(out, overwrite)
    finish(bench_area(quick, truth, watch()), out, json, overwrite)


def finish(found: Bench, out: Path | None, as_json: bool, overwrite: bool) -> None:
    """Write what a bench found, if a folder is given, and print it."""
    from app.cli.printing import print_json, say
    from app.services.bench.results import write_bench

    if out is not None:
        write_bench(found, out, overwrite)
    if as_json:
        print_json(found.as_dict())
        return
    for table in found.tables:
        print_table(table)
    say(", ".join(f"{name} {value}" for name, value in found.as_dict()["machine"].items()))
    if out is not None:
        say(f"Tables and pictures are in {out.resolve()}.")


def print_table(table: ResultTable) -> None:
    """Print a table, numbers to the right; whole lines where the output is no terminal."""
    from rich.console import Console
    from rich.table import Table

    LINE.wipe()
    shown = Table(title=table.title, title_justify="left", caption=table.note or None)
    numeric = {name for name in table.columns if not isinstance(table.rows[0][name], (str, bool))}
    for name in table.columns:
        shown.add_column(name, justify="right" if name in numeric else "left")
    for row in table.rows:
        shown.add_row(*(show_value(row[name]) for name in table.columns))
    console = Console(highlight=False)
    if not console.is_terminal:
        wide = console.options.update(max_width=WIDEST)
        console = Console(
            highlight=False, width=max(200, console.measure(shown, options=wide).maximum)
        )
    console.print(shown)


def show_value(value: Value) -> str:
    """A value in few digits; nothing where there is none."""
    if isinstance(value, float):
        return "" if value != value else f"{value:.6g}"
    return str(value)

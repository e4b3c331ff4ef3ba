"""The commands: each calls one service. Heavy imports wait until a command runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from app import __version__
from app.cli.console import watch
from app.core.errors import WrongUse

if TYPE_CHECKING:
    from app.services.opening import Opening

leafscope = App(
    name="leafscope",
    default_parameter=Parameter(negative=(), show_default=False),
    version=__version__,
    help="Laser scans of leaves: incidence angles, phase functions, Δω, ghost points. "
    "With a file or nothing, opens the window.",
)
Json = Annotated[bool, Parameter(help="Print JSON.")]
Overwrite = Annotated[bool, Parameter(help="Replace files that exist.")]


@Parameter(name="*")
@dataclass(frozen=True)
class Reading:
    """How a file is read and understood."""

    origin: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    "Position of the scanner in world metres, X,Y,Z."
    channel: tuple[str, ...] = ()
    "Name a channel by hand, NAME=WAVELENGTH:KIND (kind: DN, dB, linear, reflectance)."
    columns: str | None = None
    "Text files: names of the columns, x,y,z,intensity; - skips one."
    separator: str | None = None
    "Text files: what stands between columns."
    header_lines: int | None = None
    "Text files: lines to skip before the points."
    every_nth: int = 1
    "Read each n-th point only."
    recover: bool = False
    "Read what is complete of a truncated file."
    unit: float = 1.0
    "Metres per unit of the file (0.001 for millimetres)."
    profile: str | None = None
    "Calibrate the channels by a profile: a TOML file, or the name of a published one."
    power: tuple[str, ...] = ()
    "Laser power of the scan in a calibrated channel, CHANNEL=VALUE[:SIGMA]."
    panel: str | None = None
    "Measure that power by a panel in the scan: FIELD=LABEL:REFLECTANCE[:SIGMA], its points."
    partial_hits: bool = False
    "Give a reflectance also to points that the beam hits in part."
    correct: tuple[str, ...] = ()
    "Correct a channel for its angle, CHANNEL:WORKFLOW:b=1.78 (or a species, or FITS.json)."
    formula: tuple[str, ...] = ()
    'An index of your own, NAME=FORMULA, e.g. "mine=(r1063 - r1545) / (r1063 + r1545)".'


@Parameter(name="*")
@dataclass(frozen=True)
class Planes:
    """How the local plane at a point is found."""

    radius: float | None = None
    "Half-width of the window around a point, metres (default 0.004)."
    estimator: Literal["adaptive", "robust", "window", "ball"] | None = None
    "How planes are found: adaptive (default), robust, window, or ball as in other programs."


@Parameter(name="*")
@dataclass(frozen=True)
class Footprint:
    """The beam, for the fields footprint and footprint_share."""

    instrument: str | None = None
    "Beam of an instrument: a name (see simulate --list) or a TOML file."
    exit_diameter: float | None = None
    "Diameter of the beam where it leaves the scanner, mm."
    half_divergence: float | None = None
    "HALF of the beam's full divergence, degrees."
    smooth: float | None = None
    "Average channels over a synthetic footprint of so many mm, for fields …_smoothed."


DEFAULT_READING, DEFAULT_PLANES, DEFAULT_FOOTPRINT = Reading(), Planes(), Footprint()


def opening(file: Path, reading: Reading) -> Opening:
    """What a service is told about the file of a command."""
    from app.formats.options import ReadOptions
    from app.services.opening import Opening, parse_origin
    from app.services.profiles import find_profile

    options = ReadOptions(
        every_nth=reading.every_nth,
        recover=reading.recover,
        separator=reading.separator,
        header_lines=reading.header_lines,
        columns=tuple(reading.columns.split(",")) if reading.columns else None,
        metres_per_unit=reading.unit,
    )
    origin = None if reading.origin is None else parse_origin(reading.origin)
    profile = None if reading.profile is None else find_profile(reading.profile)
    if profile is None and (reading.power or reading.panel or reading.partial_hits):
        raise WrongUse("--power, --panel and --partial-hits belong to a --profile; give one.")
    return Opening(
        file,
        options,
        origin,
        reading.channel,
        profile,
        reading.power,
        reading.partial_hits,
        reading.panel,
        reading.correct,
        reading.formula,
    )


def parameters_of(
    planes: Planes, beam: Footprint = DEFAULT_FOOTPRINT, threshold: float | None = None
) -> dict[str, Any]:
    """What a service is told about the parameters of the fields; None stays the default."""
    from app.core.units import MM_PER_M
    from app.services.beams import choose_beam

    return {
        "synthetic_footprint": None if beam.smooth is None else beam.smooth / MM_PER_M,
        "radius": planes.radius,
        "estimator": planes.estimator,
        "beam": choose_beam(beam.instrument, beam.exit_diameter, beam.half_divergence),
        "ghost_threshold": threshold,
    }


@leafscope.default
def window(file: Path | None = None, /) -> None:
    """Open the window, with a scan or session if one is named.

    Parameters
    ----------
    file
        A scan or session.
    """
    if file is not None and not file.exists():
        raise WrongUse(f"There is no command and no file named {file}.", "See leafscope --help.")
    from app.services.launch import open_window

    open_window([str(file)] if file else [])


@leafscope.command
def info(file: Path, /, reading: Reading = DEFAULT_READING, json: Json = False) -> None:
    """Say what a file holds.

    Parameters
    ----------
    file
        A scan.
    """
    from app.cli.printing import print_info
    from app.services.info import describe_opened

    print_info(describe_opened(opening(file, reading), watch()), json)


@leafscope.command
def compute(
    file: Path,
    /,
    *,
    field: tuple[str, ...],
    out: Path,
    report: Path | None = None,
    planes: Planes = DEFAULT_PLANES,
    beam: Footprint = DEFAULT_FOOTPRINT,
    reading: Reading = DEFAULT_READING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Compute fields for every point and write them in file order.

    Parameters
    ----------
    file
        A scan.
    field
        A field: range, incidence, incidence_sigma, footprint, ndi, ghost, a channel … (may be
        repeated).
    out
        File to write: .npz, .laz, .las, .e57, .ptx, .ply or .csv.
    report
        JSON file with seconds, counts and versions.
    """
    from app.cli.printing import print_report, write_json
    from app.formats.atomic import is_same_file, refuse_target
    from app.services.compute import compute_file

    if report is not None:
        if is_same_file(report, out):
            raise WrongUse(f"{out} cannot be both the result and the report.")
        refuse_target(report, overwrite, sources=[file])
    parameters = parameters_of(planes, beam)
    found = compute_file(opening(file, reading), field, out, parameters, overwrite, watch())
    if report is not None:
        write_json(found, report, overwrite)
    print_report(found, out, json)


@leafscope.command
def leaves(
    file: Path,
    /,
    *,
    out: Path,
    label_field: str | None = None,
    seeds: Path | None = None,
    planes: Planes = DEFAULT_PLANES,
    beam: Footprint = DEFAULT_FOOTPRINT,
    reading: Reading = DEFAULT_READING,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Measure the leaves of a scan into a table: planes, angles, areas, channels.

    Parameters
    ----------
    file
        A scan.
    out
        CSV file to write, a row per leaf.
    label_field
        Field whose whole numbers from 0 on name the leaves; without it leaves are found by
        connectivity.
    seeds
        CSV file with columns leaf, x, y, z (metres) that puts leaves right: places of one name
        on several leaves make them one, places of several names on one leaf split it.
    """
    from app.cli.printing import print_leaves
    from app.services.leaf_tables import tabulate_leaves

    parameters = parameters_of(planes, beam)
    rows = tabulate_leaves(
        opening(file, reading), out, label_field, parameters, overwrite, watch(), seeds
    )
    print_leaves(rows, out, json)


@leafscope.command
def snapshot(
    file: Path,
    /,
    *,
    colour: str,
    out: Path,
    size: str = "1280x800",
    theme: Literal["light", "dark"] = "light",
    limits: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    view: Literal["3d", "image"] = "3d",
    footprints: int | None = None,
    planes: Planes = DEFAULT_PLANES,
    beam: Footprint = DEFAULT_FOOTPRINT,
    reading: Reading = DEFAULT_READING,
    overwrite: Overwrite = False,
) -> None:
    """Make a picture of a scan, coloured by a field.

    Parameters
    ----------
    file
        A scan.
    colour
        Field that colours the points.
    out
        PNG file to write.
    size
        Width and height in pixels, WxH.
    limits
        Limits of the colours, LOW,HIGH.
    view
        3d: all scans in perspective; image: what the scanner of the first saw, azimuth to the
        right and elevation upwards.
    footprints
        Draw footprints at true scale, of every so many rows and columns (3000 of them at most).
    """
    from app.cli.printing import say
    from app.services.snapshot import parse_limits, parse_size, snapshot_file

    snapshot_file(
        opening(file, reading),
        colour,
        out,
        parse_size(size),
        theme,
        parse_limits(limits) if limits else None,
        parameters_of(planes, beam),
        overwrite,
        watch(),
        view,
        footprints,
    )
    say(f"{out} written.")


@leafscope.command
def replay(
    session: Path, /, *, out: Path, json: Json = False, overwrite: Overwrite = False
) -> None:
    """Do again all that a session holds, without a window, and write its numbers.

    Parameters
    ----------
    session
        A .leafscope file.
    out
        Folder for points, tables and report.
    """
    from app.cli.printing import print_replay
    from app.services.sessions import replay as replay_session

    print_replay(replay_session(session, out, overwrite, watch()), out, json)


@leafscope.command
def demo(*, out: Path | None = None, overwrite: Overwrite = False) -> None:
    """Open the demo scan in the window; with --out, run the demo headless instead.

    Parameters
    ----------
    out
        Folder for the demo's pictures and tables.
    """
    if out is None:
        from app.services.launch import open_window

        open_window(["--demo"])
    else:
        from app.cli.printing import say
        from app.services.demo import run_demo

        for line in run_demo(out, overwrite, watch()):
            say(line)


# By name, so that its file may use what stands here.
leafscope.command(
    "app.cli.simulating:simulate",
    help="Scan a simulated scene: points with everything that is true about them.",
)
leafscope.command(
    "app.cli.fitting:fit",
    help="Fit an angular model to a table of angles (degrees) and values.",
)
leafscope.command(
    "app.cli.fitting:fit_scan",
    help="Fit a model to the leaves of a scan in each of its channels.",
)
leafscope.command("app.cli.benching:bench", help="Measure how right and how fast Leafscope is.")
leafscope.command(
    "app.cli.sampling:sample",
    help="Means of samples that several instruments scanned, and indices of the means.",
)
leafscope.command(
    "app.cli.correcting:correct",
    help="Correct leaves for their angle of incidence: WF1, WF2 and WF3 side by side.",
)
leafscope.command(
    "app.cli.indexing:index_angle",
    help="An index against the angle: its curve, its range, and whether that exceeds the noise.",
)
leafscope.command(
    "app.cli.indexing:synthetic_footprint",
    help="How the spread of an index falls when channels are averaged over a footprint.",
)
leafscope.command(
    "app.cli.calibrating:calibrate",
    help="Calibrate an instrument from a table of panels: DN to reflectance.",
)
leafscope.command(
    "app.cli.calibrating:profiles",
    help="List what is published about instruments, and the profiles that come with Leafscope.",
)
leafscope.command(
    "app.cli.series:series",
    help="Carry leaves through scans of other angles or times, and measure them into a table.",
)
leafscope.command(
    "app.cli.planning:plan",
    help="Plan a scan: footprint, points, ghosts and the largest usable angle on a leaf.",
)
leafscope.command(
    "app.cli.wrinkling:wrinkles",
    help="Wrinkles of leaves: angles from intensity against each leaf's plane.",
)
leafscope.command(
    "app.cli.meshing:mesh",
    help="Mesh the leaves of a scan on its grid, and write triangles.",
)
leafscope.command(
    "app.cli.cleaning:clean",
    help="Find ghost points and mark, delete or correct them.",
)

"""The command that calibrates; `app.cli.commands` knows it by name and loads it late."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from app.cli.commands import Json, Overwrite
from app.cli.console import watch
from app.cli.printing import print_json, print_warnings, say
from app.core.errors import WrongUse

if TYPE_CHECKING:
    from app.core.radiometry.profile import Noise
    from app.services.calibrate import CalibrationReport, ChannelReport, Naming


@Parameter(name="*")
@dataclass(frozen=True)
class Panels:
    """How the table is understood."""

    column: tuple[str, ...] = ()
    "Name a column by hand, ROLE=NAME (range, dn, reflectance, scan, panel, channel …)."
    channel: str | None = None
    "Only this channel; or the name of the channel, as in your scans."
    wavelength: float | None = None
    "Wavelength, nm, where the table has none."
    percent: bool = False
    "The reflectances are percent."
    panel_sigma: float = 0.0
    "σ of the panels' reflectance as a share of it (0.02: 2 %)."
    saturated: Annotated[float | None, Parameter(allow_leading_hyphen=True)] = None
    "DN from which a panel is saturated."
    dark: Annotated[float | None, Parameter(allow_leading_hyphen=True)] = None
    "DN up to which nothing is told."
    fixed_panel: tuple[str, ...] = ()
    "A panel that stands still, to measure the laser's power by (may be repeated)."
    reference_scan: str | None = None
    "The scan whose power is 1."
    reference_range: float | None = None
    "Range at which the range effect is none, metres."
    break_at: tuple[float, ...] = ()
    "Where pieces of a polynomial or spline meet, metres (may be repeated)."
    same_power: bool = False
    "The laser's power did not change between the scans of the table."


@Parameter(name="*")
@dataclass(frozen=True)
class Result:
    """What the profile says beside the fit."""

    name: str = ""
    "Name of the profile (default: that of the table)."
    instrument: str = ""
    "Short name of the instrument (see profiles): its model and scale, where not given here."
    point_noise: str | None = None
    "Noise of a single point, CONSTANT[,SHARE[,LIGHT]]: DN, share of the DN, share of the light."
    margin: float = 0.0
    "Metres beyond the panels' ranges where the profile is to hold as well, 0.1 at most."
    range_noise: float = 0.0
    "σ of a range, mm, for its part in the error budget."
    any_range: bool = False
    "The profile holds at any range: the instrument has taken the effect of range out."


AS_FOUND, PLAIN_RESULT = Panels(), Result()


def calibrate(
    table: Path,
    /,
    *,
    out: Path,
    model: str | None = None,
    report: Path | None = None,
    panels: Panels = AS_FOUND,
    result: Result = PLAIN_RESULT,
    json: Json = False,
    overwrite: Overwrite = False,
) -> None:
    """Calibrate an instrument from a table of panels: DN to reflectance, with an error budget.

    Parameters
    ----------
    table
        CSV file with columns range (m), dn and reflectance, and as far as there are such scan,
        panel, channel, wavelength_nm, dn_sigma, reflectance_sigma.
    model
        log, linear, proportional or salca, with a range effect behind it if there is one:
        +inverse-square, +polynomial, +spline, +analytic, +analytic-inner. Or polynomial or spline
        alone: numbers as at the reference range, for which one panel is enough. Or a paper:
        balduzzi, junttila-log, junttila-linear, kaasalainen, hancock. Default: that of the
        --instrument.
    out
        TOML file to write, the profile.
    report
        Markdown file to write, with a picture of the same name (.png).
    """
    from app.core.radiometry.calibration import Wishes
    from app.services.calibrate import calibrate_table
    from app.services.calibration_report import refuse_calibration, write_calibration
    from app.services.instrument_facts import choose_calibration
    from app.services.panel_columns import TableOptions

    refuse_calibration(out, report, overwrite, [table])
    options = TableOptions(
        panels.column, panels.channel, panels.wavelength, panels.percent, panels.panel_sigma
    )
    wishes = Wishes(
        panels.reference_range,
        panels.reference_scan,
        panels.fixed_panel,
        panels.break_at,
        panels.dark,
        panels.saturated,
        same_power=panels.same_power,
    )
    model, options, wishes = choose_calibration(result.instrument, model, options, wishes)
    found = calibrate_table(table, model, options, wishes, name_result(result), watch())
    written = write_calibration(found, out, report, overwrite)
    if json:
        print_json({**found.as_dict(), "files": [str(path) for path in written]})
        return
    print_calibration(found)
    for path in written:
        say(f"{path} written.")


def profiles(*, json: Json = False) -> None:
    """List the instruments of the papers: what is published, and the profiles that there are."""
    from msgspec import to_builtins

    from app.services.instrument_facts import list_facts
    from app.services.profiles import name_profiles

    if json:
        known = {"instruments": list_facts(), "profiles": name_profiles()}
        print_json(to_builtins(known))
        return
    for facts in list_facts():
        nm = ", ".join(f"{each:g}" for each in facts.wavelengths_nm)
        say(f"{facts.name}: {facts.title}, {nm} nm; its paper's --model {facts.model}")
        say(f"  profile: {', '.join(facts.profiles) or 'none, for no numbers are published'}")
        for note in facts.notes:
            say(f"  {note}")
    for key, profile in name_profiles().items():
        say(f"--profile {key}: {profile.name} (published, not yours)")
        for note in profile.notes:
            say(f"  {note}")


def name_result(result: Result) -> Naming:
    """What the service is told about the profile."""
    from app.core.units import MM_PER_M
    from app.services.calibrate import Naming

    return Naming(
        result.name,
        result.instrument,
        None if result.point_noise is None else parse_noise(result.point_noise),
        result.margin,
        result.any_range,
        result.range_noise / MM_PER_M,
    )


def parse_noise(text: str) -> Noise:
    """Noise of a point, ``CONSTANT[,SHARE[,LIGHT]]``; raises `WrongUse` for anything else."""
    from app.core.radiometry.profile import Noise

    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in (1, 2, 3):
        raise WrongUse(f"{text!r} is no noise.", "Write CONSTANT[,SHARE[,LIGHT]], e.g. 1,0.01.")
    return Noise(*values)


def print_calibration(found: CalibrationReport) -> None:
    """Print the parameters of each channel, and how well its panels come out."""
    if found.ignored:
        say(f"note: columns not used: {', '.join(found.ignored)}")
    for channel in found.channels:
        _print_channel(channel)
    print_warnings(found.warnings)


def _print_channel(report: ChannelReport) -> None:
    from app.core.radiometry.joint import count_rows
    from app.services.calibration_words import NOT_KNOWN, list_parameters, tell_error

    found = report.calibration
    say(f"{report.channel.name}: {found.model.name}, {count_rows(len(found.table))}")
    for name, value, _, low, high, *_ in list_parameters(found):
        known = low is not None and high is not None
        say(f"  {name} = {value:.6g}" + (f" (95 %: {low:.6g} to {high:.6g})" if known else ""))
    if found.fit.noise is None:
        say(f"  {NOT_KNOWN}")
    say(f"  {tell_error(found, report.channel.evidence)}")
    digits, unit = (".3g", " DN") if found.model.range_alone else (".4f", "")
    for score in report.scores:
        rmse, bias = f"{score.rmse:{digits}}{unit}", f"{score.bias:+{digits}}{unit}"
        say(f"  panel {score.panel}: RMSE {rmse}, bias {bias}")
    print_warnings(report.warnings)

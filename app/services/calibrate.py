"""Calibrate an instrument from a table of panels: profile, report and picture in one go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from app.core.errors import BadInput, LeafscopeError, WrongUse
from app.core.progress import QUIET, Progress
from app.core.radiometry.calibration import (
    BY_RULE,
    Calibration,
    Wishes,
    calibrate,
    fit_other_form,
    make_channel,
)
from app.core.radiometry.joint import JointFit
from app.core.radiometry.models import CalibrationModel, choose_model
from app.core.radiometry.panels import PanelTable
from app.core.radiometry.profile import MOST_MARGIN, ChannelCalibration, Noise, Profile
from app.core.radiometry.residuals import MaterialScore, gather_evidence, score_materials
from app.services.calibration_words import list_parameters, warn_of
from app.services.instrument_facts import warn_unknown
from app.services.panel_columns import PLAIN, TableOptions, read_panels

WORSE = 3.0
"""χ² by which another reading must be better before it is said."""


@dataclass(frozen=True, slots=True)
class Naming:
    """What the profile is called, and what it adds to the table.

    Attributes
    ----------
    name : str
        Default: the name of the table.
    instrument : str
        Short name such as ``salca``.
    point_noise : Noise or None
        Of a single point, where it is known: rows of a table are means of many.
    margin : float
        Metres beyond the panels' ranges where the profile is to hold as well, `MOST_MARGIN` at
        most.
    range_sigma : float
        σ of a range, metres; 0: unknown, and without a part in the budget.
    any_range : bool
        It holds everywhere: the instrument has taken the effect of range out.
    """

    name: str = ""
    instrument: str = ""
    point_noise: Noise | None = None
    margin: float = 0.0
    any_range: bool = False
    range_sigma: float = 0.0


UNNAMED = Naming()


@dataclass(frozen=True, slots=True, eq=False)
class ChannelReport:
    """A calibrated channel and all that is shown of it.

    Attributes
    ----------
    channel : ChannelCalibration
    calibration : Calibration
    scores : tuple of MaterialScore
    other : (CalibrationModel, JointFit) or None
        The other reading of Hancock's range effect.
    warnings : tuple of str
    """

    channel: ChannelCalibration
    calibration: Calibration
    scores: tuple[MaterialScore, ...]
    other: tuple[CalibrationModel, JointFit] | None
    warnings: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationReport:
    """A profile, and how each of its channels was found."""

    profile: Profile
    table: str
    channels: tuple[ChannelReport, ...]
    ignored: tuple[str, ...]
    warnings: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The JSON answer of ``leafscope calibrate``."""
        return {
            "profile": self.profile.name,
            "instrument": self.profile.instrument,
            "table": self.table,
            "ignored_columns": list(self.ignored),
            "warnings": list(self.warnings),
            "channels": [_describe_channel(each) for each in self.channels],
        }


def calibrate_table(
    path: str | Path,
    model: str,
    options: TableOptions = PLAIN,
    wishes: Wishes = BY_RULE,
    naming: Naming = UNNAMED,
    progress: Progress = QUIET,
) -> CalibrationReport:
    """Calibrate every channel of a table; nothing is written.

    Parameters
    ----------
    path : str or Path
        CSV with columns for range (m), DN and reflectance; see `panel_columns.SYNONYMS`.
    model : str
        See `app.core.radiometry.models.choose_model`.
    options : TableOptions
    wishes : Wishes
    naming : Naming
    progress : Progress

    Raises
    ------
    BadInput
        The table cannot be used; one sentence says why.
    WrongUse
        An option does not exist or does not fit the table.
    """
    chosen = choose_model(model)
    _check_margin(naming.margin)
    file = read_panels(path, options)
    reports = []
    for place, table in enumerate(file.tables):
        progress.report(place / len(file.tables), f"Calibrating {table.channel}")
        try:
            reports.append(report_channel(table, chosen, wishes, naming))
        except LeafscopeError as error:
            if len(file.tables) == 1:
                raise
            told = type(error) if type(error) in (BadInput, WrongUse) else BadInput
            raise told(f"Channel {table.channel}: {error.what}", error.hint) from error
    name = naming.name or Path(path).stem
    channels = tuple(each.channel for each in reports)
    notes = (f"Calibrated from {Path(path).name} with the model {_name_models(reports)}.",)
    profile = Profile(name, channels, naming.instrument, "yours", notes)
    said = tuple(filter(None, [warn_unknown(naming.instrument)]))
    return CalibrationReport(profile, Path(path).name, tuple(reports), file.ignored, said)


def _name_models(reports: Sequence[ChannelReport]) -> str:
    return ", ".join(dict.fromkeys(each.calibration.model.name for each in reports))


def _check_margin(margin: float) -> None:
    if not 0.0 <= margin < float("inf"):
        raise WrongUse(f"A margin of {margin:g} m is impossible.", "Give metres from 0 on.")
    if margin > MOST_MARGIN:
        raise WrongUse(
            f"A margin of {margin:g} m is more than {MOST_MARGIN:g} m: nothing is known there.",
            "A margin is for the noise of ranges; scan panels nearer or farther.",
        )


def report_channel(
    table: PanelTable, model: CalibrationModel, wishes: Wishes, naming: Naming = UNNAMED
) -> ChannelReport:
    """Calibrate one channel and measure how well it did; raises as `calibrate_table`."""
    if naming.any_range and model.fits_range:
        raise WrongUse(
            "A profile with a fitted range effect cannot hold at any range.",
            "Leave --any-range out, or choose a model without range.",
        )
    found = calibrate(table, model, wishes)
    scores = score_materials(found)
    channel = make_channel(found, gather_evidence(found, scores))
    if naming.any_range:
        channel = replace(channel, nearest=None, farthest=None)
    elif channel.nearest is not None and channel.farthest is not None:
        nearest = max(channel.nearest - naming.margin, 0.0)
        channel = replace(channel, nearest=nearest, farthest=channel.farthest + naming.margin)
    channel = replace(channel, range_sigma=naming.range_sigma)
    if naming.point_noise is not None:
        channel = replace(channel, noise=naming.point_noise)
    try:
        other = fit_other_form(found)
    except BadInput:
        other = None
    said = warn_of(found, naming.any_range, naming.point_noise is not None)
    return ChannelReport(channel, found, scores, other, (*said, *_compare(found, other)))


def misfit(fit: JointFit, other: JointFit) -> float:
    """χ² of a fit with the σ of another."""
    return float(((fit.residual / other.sigma) ** 2).sum())


def _compare(
    found: Calibration, other: tuple[CalibrationModel, JointFit] | None
) -> tuple[str, ...]:
    if other is None or misfit(other[1], found.fit) >= found.fit.chi_square - WORSE:
        return ()
    return (f"The model {other[0].name} fits better; see the report.",)


def _describe_channel(report: ChannelReport) -> dict[str, Any]:
    found, fit = report.calibration, report.calibration.fit
    return {
        "channel": report.channel.channel,
        "field": report.channel.name,
        "wavelength_nm": report.channel.wavelength_nm,
        "model": found.model.name,
        "reference_range_m": found.reference_range,
        "reference_scan": found.reference_scan,
        "fixed_panels": list(found.fixed_panels),
        "rows": len(found.table),
        "saturated_left_out": found.saturated,
        "dark_left_out": found.dark,
        "parameters": {
            one.name: {"value": one.value, "sd": one.sd, "low": one.low, "high": one.high}
            for one in list_parameters(found)
        },
        "staged_intervals": _list_staged(found),
        "powers": {} if found.model.range_alone else dict(fit.powers()),
        "noise": None
        if fit.noise is None
        else {"constant": fit.noise.constant, "share": fit.noise.share},
        "scale": fit.scale,
        "chi_square": fit.chi_square,
        "freedom": fit.freedom,
        "singular_values": fit.singular.tolist(),
        "other_form": None
        if report.other is None
        else {"model": report.other[0].name, "chi_square": misfit(report.other[1], fit)},
        "unit": "DN" if found.model.range_alone else "reflectance",
        "panels": [_describe_score(score) for score in report.scores],
        "warnings": list(report.warnings),
    }


def _list_staged(found: Calibration) -> Mapping[str, list[float]] | None:
    if found.staged is None:
        return None
    return {name: list(ends) for name, ends in found.staged.intervals.items()}


def _describe_score(score: MaterialScore) -> dict[str, Any]:
    return {name: getattr(score, name) for name in MaterialScore.__slots__}

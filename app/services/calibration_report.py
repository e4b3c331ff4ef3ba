"""The report of a calibration: Markdown with tables, and a picture beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.core.radiometry.joint import count_rows
from app.formats.atomic import atomic_files, refuse_targets
from app.services.calibrate import CalibrationReport, ChannelReport, misfit
from app.services.calibration_words import list_parameters, tell_error, tell_noise
from app.services.profiles import encode_profile


def list_targets(out: Path, report: Path | None) -> list[Path]:
    """The files that a calibration writes."""
    return [out] if report is None else [out, report, report.with_suffix(".png")]


def refuse_calibration(
    out: Path, report: Path | None, overwrite: bool, sources: Sequence[Path] = ()
) -> None:
    """Raise `BadInput` where a file must not be written; cheap, call it before the work."""
    refuse_targets(list_targets(out, report), overwrite, sources)


def write_calibration(
    found: CalibrationReport, out: Path, report: Path | None = None, overwrite: bool = False
) -> list[Path]:
    """Write the profile, and with `report` the Markdown and its picture; all of them or none.

    Raises
    ------
    BadInput
        A file exists already or cannot be written.
    """
    from app.services.calibration_picture import draw_calibration

    targets = list_targets(out, report)
    with atomic_files() as begin:
        begin(out, overwrite).write_bytes(encode_profile(found.profile))
        if report is not None:
            picture = targets[2]
            begin(report, overwrite).write_text(tell(found, picture.name), encoding="utf-8")
            draw_calibration(found, begin(picture, overwrite))
    return targets


def tell(found: CalibrationReport, picture: str) -> str:
    """The report as Markdown."""
    lines = [f"# Calibration {found.profile.name}", "", f"Table: {found.table}."]
    if found.ignored:
        lines.append(f"Columns that were not used: {', '.join(found.ignored)}.")
    lines += [f"Note: {warning}" for warning in found.warnings]
    lines += ["", f"![Data, curve and residuals]({picture})", ""]
    for channel in found.channels:
        lines += _tell_channel(channel)
    return "\n".join(lines).rstrip() + "\n"


def _tell_channel(report: ChannelReport) -> list[str]:
    found, fit = report.calibration, report.calibration.fit
    parts = [found.model.response, *filter(None, [found.model.range_effect])]
    scan = "" if found.model.range_alone else (
        f", reference scan {found.reference_scan} (power 1), fixed panels:"
        f" {', '.join(found.fixed_panels) or 'none'}"
    )  # fmt: skip
    error = tell_error(found, report.channel.evidence)
    return [
        f"## {report.channel.name}",
        "",
        *(f"- {part.title}: {part.formula} ({part.source})" for part in parts),
        f"- Reference range {found.reference_range:g} m{scan}",
        f"- {count_rows(len(found.table))} used; left out: {found.saturated} saturated,"
        f" {found.dark} dark",
        f"- {error[:1].upper()}{error[1:]}",
        f"- Noise of a row: {tell_noise(found)}; χ² {fit.chi_square:.1f} with"
        f" {fit.freedom} degrees of freedom",
        *(f"- Note: {warning}" for warning in report.warnings),
        "",
        "### Parameters",
        "",
        *_tell_parameters(report),
        "",
        "### Panels",
        "",
        *_tell_panels(report),
        "",
        *_tell_forms(report),
        "### Singular values",
        "",
        "Of the Jacobian with columns of length 1; one near 0 would mean that parameters can change"
        " together unseen: " + ", ".join(f"{value:.3g}" for value in fit.singular) + ".",
        "",
    ]


def _tell_parameters(report: ChannelReport) -> list[str]:
    found = report.calibration
    staged = found.staged.intervals if found.staged else {}
    rows = []
    for name, value, _, low, high, noise, panel in list_parameters(found):
        alone = f"{staged[name][0]:.6g} to {staged[name][1]:.6g}" if name in staged else ""
        rows.append(
            (
                name,
                f"{value:.6g}",
                "not known" if low is None or high is None else f"{low:.6g} to {high:.6g}",
                "not known" if noise is None else f"{noise:.2g}",
                f"{panel:.2g}",
                *([alone] if staged else []),
            )
        )
    names = ["parameter", "value", "95 % interval", "σ from noise", "σ from panels"]
    if staged:
        names.append("95 % of the stage alone (too narrow)")
    return _table(names, rows)


def _tell_panels(report: ChannelReport) -> list[str]:
    alone = report.calibration.model.range_alone
    digits, unit = (".3g", ", DN") if alone else (".4f", "")
    rows: list[tuple[str, ...]] = [
        (
            score.panel,
            f"{score.reflectance:g}",
            str(score.rows),
            f"{score.rmse:{digits}}",
            f"{score.bias:+{digits}}",
            f"{score.dn_rmse:.3g}",
            f"{score.dn_bias:+.3g}",
            "not determined" if score.left_out_rmse is None
            else f"{score.left_out_rmse:{digits}}",
            "" if score.left_out_bias is None else f"{score.left_out_bias:+{digits}}",
        )
        for score in report.scores
    ]  # fmt: skip
    names = [
        "panel", "reflectance", "rows", f"RMSE{unit}", f"bias{unit}", "RMSE, DN", "bias, DN",
        f"RMSE without it{unit}", f"bias without it{unit}",
    ]  # fmt: skip
    if alone:  # they are DN already
        names, rows = [*names[:5], *names[7:]], [(*row[:5], *row[7:]) for row in rows]
    return _table(names, rows)


def _tell_forms(report: ChannelReport) -> list[str]:
    if report.other is None:
        return []
    fit, (model, other) = report.calibration.fit, report.other
    rows = [
        (report.calibration.model.name, f"{fit.chi_square:.2f}", str(fit.freedom)),
        (model.name, f"{misfit(other, fit):.2f}", str(other.freedom)),
    ]
    return [
        "### Both readings of the range effect",
        "",
        *_table(("model", "χ²", "degrees of freedom"), rows),
        "",
    ]


def _table(names: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |"

    return [line(names), line(["---"] * len(names)), *(line(row) for row in rows)]

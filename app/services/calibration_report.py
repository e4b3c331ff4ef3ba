"""The report of a calibration: Markdown with tables, and a picture beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.formats.atomic import atomic_files, refuse_target
from app.services.calibrate import CalibrationReport, ChannelReport, misfit
from app.services.profiles import encode_profile


def list_targets(out: Path, report: Path | None) -> list[Path]:
    """The files that a calibration writes."""
    return [out] if report is None else [out, report, report.with_suffix(".png")]


def refuse_calibration(out: Path, report: Path | None, overwrite: bool) -> None:
    """Raise `BadInput` where a file must not be written; cheap, call it before the work."""
    for target in list_targets(out, report):
        refuse_target(target, overwrite)


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
    lines += ["", f"![Data, curve and residuals]({picture})", ""]
    for channel in found.channels:
        lines += _tell_channel(channel)
    return "\n".join(lines).rstrip() + "\n"


def _tell_channel(report: ChannelReport) -> list[str]:
    found, fit = report.calibration, report.calibration.fit
    evidence = report.channel.evidence
    parts = [found.model.response, *filter(None, [found.model.range_effect])]
    outside = "" if evidence is None or evidence.left_out_rmse is None else (
        f", {evidence.left_out_rmse:.4f} for panels left out of the fit"
    )  # fmt: skip
    error = "" if evidence is None else (
        f"RMSE of the reflectance {evidence.rmse:.4f}, bias {evidence.bias:+.4f}{outside}."
    )  # fmt: skip
    return [
        f"## {report.channel.name}",
        "",
        *(f"- {part.title}: {part.formula} ({part.source})" for part in parts),
        f"- Reference range {found.reference_range:g} m, reference scan {found.reference_scan}"
        f" (power 1), fixed panels: {', '.join(found.fixed_panels) or 'none'}",
        f"- {len(found.table)} rows used; left out: {found.saturated} saturated, {found.dark} dark",
        f"- {error}",
        f"- Noise of a row: {fit.noise.constant:.3g} DN and {100 * fit.noise.share:.3g} % of it;"
        f" χ² {fit.chi_square:.1f} with {fit.freedom} degrees of freedom",
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
    found, fit = report.calibration, report.calibration.fit
    staged = found.staged.intervals if found.staged else {}
    rows = []
    for k, name in enumerate(fit.found.names):
        noise, panel = (c[k, k] ** 0.5 for c in (fit.noise_covariance, fit.panel_covariance))
        alone = f"{staged[name][0]:.6g} to {staged[name][1]:.6g}" if name in staged else ""
        rows.append(
            (
                name,
                f"{fit.found.natural()[k]:.6g}",
                f"{fit.low[k]:.6g} to {fit.high[k]:.6g}",
                f"{noise:.2g}",
                f"{panel:.2g}",
                *([alone] if staged else []),
            )
        )
    names = ["parameter", "value", "95 % interval", "σ from noise", "σ from panels"]
    if staged:
        names.append("95 % of the stage alone (too narrow)")
    return _table(names, rows)


def _tell_panels(report: ChannelReport) -> list[str]:
    rows = [
        (
            score.panel,
            f"{score.reflectance:g}",
            str(score.rows),
            f"{score.rmse:.4f}",
            f"{score.bias:+.4f}",
            f"{score.dn_rmse:.3g}",
            f"{score.dn_bias:+.3g}",
            "not determined" if score.left_out_rmse is None else f"{score.left_out_rmse:.4f}",
            "" if score.left_out_bias is None else f"{score.left_out_bias:+.4f}",
        )
        for score in report.scores
    ]
    names = (
        "panel", "reflectance", "rows", "RMSE", "bias", "RMSE, DN", "bias, DN",
        "RMSE without it", "bias without it",
    )  # fmt: skip
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

"""The picture of a calibration: a row for each channel, data and curve, then residuals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.radiometry import chain as chains
from app.core.radiometry.calibration import Calibration
from app.services.bench.picture import COLOURS, DPI, INK, number_axis
from app.services.calibrate import CalibrationReport, ChannelReport

WIDTH, HEIGHT = 4.0, 3.1
"""Inches of one diagram."""
SAMPLES = 300
LONGEST_LEGEND = 12


def draw_calibration(found: CalibrationReport, path: Path) -> None:
    """Draw a PNG file: response, range effect, residuals over range and over reflectance."""
    # The Agg canvas straight away: no global state, no display, no thread trouble.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = len(found.channels)
    figure = Figure(figsize=(4 * WIDTH, rows * HEIGHT), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    for axes, channel in zip(figure.subplots(rows, 4, squeeze=False), found.channels, strict=True):
        _draw_response(axes[0], channel)
        _draw_range(axes[1], channel.calibration)
        _draw_residuals(axes[2], channel.calibration, "range")
        _draw_residuals(axes[3], channel.calibration, "reflectance")
        for each in axes:
            _style(each)
    figure.savefig(path, format="png", metadata={"Software": None})


def _draw_response(axes: Any, report: ChannelReport) -> None:
    """Numbers as at the reference range over the light, and the response as a line."""
    found, alone = report.calibration, report.calibration.model.range_alone
    light, dn = _reach_response(found)
    for k, panel in enumerate(found.table.panels):
        mine = found.table.panel == panel
        label = panel if len(found.table.panels) <= LONGEST_LEGEND else None
        axes.plot(light[mine], dn[mine], ".", color=COLOURS[k % len(COLOURS)], label=label)
    if not alone:
        line = np.geomspace(max(float(np.nanmin(light)), 1e-6), float(np.nanmax(light)), SAMPLES)
        number = _split(found)[1].respond(line, np.ones(SAMPLES))
        axes.plot(line, number, color=INK, linewidth=1.2)
    axes.set_xscale("log")
    number_axis(axes.xaxis)
    axes.set_title(report.channel.name, fontsize=10, color=INK, loc="left")
    named = "reflectance" if alone else "light: reflectance × power × range effect"
    axes.set_xlabel(named, fontsize=9, color=INK)
    axes.set_ylabel("DN, range effect taken out", fontsize=9, color=INK)
    if len(found.table.panels) <= LONGEST_LEGEND:
        axes.legend(fontsize=6.5, frameon=False)


def _draw_range(axes: Any, found: Calibration) -> None:
    """The range effect as a line, and what each row says of it."""
    front, response, back = _split(found)
    table, distance = found.rows_fitted, found.table.distance
    power = found.fit.found.powers[table.index_scans()]
    line = np.linspace(float(distance.min()), float(distance.max()), SAMPLES)
    axes.set_xlabel("range, m", fontsize=9, color=INK)
    if back:
        expected = response.respond(table.reflectance * power, distance)
        axes.plot(distance, table.dn - expected, ".", color=COLOURS[0])
        axes.plot(line, chains.respond(back, np.zeros(SAMPLES), line), color=INK, linewidth=1.2)
        axes.set_ylabel("range effect, DN", fontsize=9, color=INK)
        return
    seen = response.invert(table.dn, distance) / (table.reflectance * power)
    axes.plot(distance, seen, ".", color=COLOURS[0])
    axes.plot(line, chains.respond(front, np.ones(SAMPLES), line), color=INK, linewidth=1.2)
    if float(np.nanmax(seen)) > 5 * max(float(np.nanmin(seen)), 1e-9) > 0:
        axes.set_yscale("log")
        number_axis(axes.yaxis)
    axes.set_ylabel("range effect, factor", fontsize=9, color=INK)


def _draw_residuals(axes: Any, found: Calibration, over: str) -> None:
    table = found.table
    x = table.distance if over == "range" else table.reflectance
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.plot(x, found.fit.residual / found.fit.sigma, ".", color=COLOURS[0])
    axes.set_xlabel("range, m" if over == "range" else "reflectance", fontsize=9, color=INK)
    axes.set_ylabel("measured − fitted, σ", fontsize=9, color=INK)


def _style(axes: Any) -> None:
    axes.grid(True, which="major", color="#d9dcdf", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8, colors=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _split(found: Calibration) -> tuple[Any, Any, Any]:
    """Steps before the response, the response, and steps behind it."""
    steps = found.fit.found.steps
    at = next(k for k, step in enumerate(steps) if isinstance(step, chains.RESPONSES))
    return steps[:at], steps[at], steps[at + 1 :]


def _reach_response(found: Calibration) -> tuple[Floats, Floats]:
    """Light that reaches the response, and the number that leaves it, of each row."""
    front, _, back = _split(found)
    table = found.table
    if found.model.range_alone:
        return table.reflectance, found.fit.found.steps[-1].invert(table.dn, table.distance)
    power = found.fit.found.powers[table.index_scans()]
    light = chains.respond(front, table.reflectance * power, table.distance)
    return light, chains.invert(back, table.dn, table.distance)

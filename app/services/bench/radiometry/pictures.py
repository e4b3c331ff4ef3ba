"""The picture: time against error of each method and its simple alternative."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from app.core.radiometry.waveform import SIGMAS
from app.services.bench.picture import Dots, Scatter, draw_scatters
from app.services.bench.radiometry.goals import Row
from app.services.bench.results import ResultTable

LEAST_ERROR = 1e-16
"""Drawn for an error of 0."""
SIMPLE = ("inverse square", "none", "one polynomial")


def draw_costs(tables: Sequence[ResultTable], path: Path) -> None:
    """Draw a panel for each kind of work.

    Parameters
    ----------
    tables : sequence of ResultTable
        Inverses, range effects, fits, waveforms and hits.
    path : Path
    """
    inverses, ranges, fits, waveforms, hits = (table.rows for table in tables)
    panels = [
        _draw_inverses(inverses),
        _draw_ranges(ranges),
        _draw_fits(fits),
        _draw_waveforms(waveforms),
        _draw_hits(hits),
    ]
    draw_scatters(panels, path)


def _scatter(name: str, dots: Iterable[tuple[float, float, str]], rival: bool) -> Iterator[Dots]:
    """A set for each dot, so that no line joins them: (time, error, text)."""
    for time, error, text in dots:
        yield Dots(name, [time], [max(error, LEAST_ERROR)], [text], [False], rival)


def _draw_inverses(rows: Sequence[Row]) -> Scatter:
    dots: list[Dots] = []
    for row in rows:
        if str(row["inverse"]) not in ("linear", "proportional"):
            name = str(row["inverse"]).replace("polynomial of order", "poly")
            cost = 1e3 / float(row["million_per_s"]), float(row["largest_error"]), name
            dots += _scatter(f"inverse: {row['way']}", [cost], row["way"] != "ours")
    return Scatter("Inverses, one core", "ns per point", "largest relative error", dots)


def _draw_ranges(rows: Sequence[Row]) -> Scatter:
    dots: list[Dots] = []
    for row in rows:
        effect, simple = str(row["range_effect"]), row["range_effect"] in SIMPLE
        name = f"range: {row['instrument']}{', simple' if simple else ''}"
        cost = float(row["fit_seconds"]), float(row["rmse_percent"])
        dots += _scatter(name, [(*cost, effect.replace("polynomial of order", "poly"))], simple)
    return Scatter("Range effects", "seconds of a fit", "RMSE of reflectance, %", dots)


def _draw_fits(rows: Sequence[Row]) -> Scatter:
    dots: list[Dots] = []
    for row in rows:
        if float(row["rmse_percent"]) > 0:  # none where all fits failed
            text = f"{row['wavelength_nm']}, {str(row['noise']).split(' +')[0]}"
            cost = float(row["seconds"]), float(row["rmse_percent"]), text
            dots += _scatter(f"fit: {row['fit']}", [cost], str(row["fit"]).startswith("curve_fit"))
    return Scatter("Calibrating SALCA", "seconds", "RMSE of reflectance, %", dots)


def _draw_waveforms(rows: Sequence[Row]) -> Scatter:
    single = [
        row
        for row in rows
        if row["threshold_sigma"] == SIGMAS and np.isnan(float(row["pulses_apart"]))
    ]
    dots = [
        Dots(
            f"return: {name}",
            [float(row["us_per_return"]) for row in own],
            [float(row["rms_percent"]) for row in own],
            [f"{row['noise_percent']:g} %" for row in own],
            [False] * len(own),
            rival=name in ("highest sample", "sum over all", "curve_fit"),
        )
        for name in dict.fromkeys(str(row["way"]) for row in single)
        for own in [[row for row in single if row["way"] == name]]
    ]
    return Scatter("Energy of a return, by noise", "µs per return", "rms error, %", dots)


def _draw_hits(rows: Sequence[Row]) -> Scatter:
    dots: list[Dots] = []
    for row in rows:
        wrong = 200 - float(row["precision_percent"]) - float(row["recall_percent"])
        time = 1e6 * float(row["seconds"]) / float(row["points"])
        text = f"{row['scene']}, {row['instrument']}"
        ours = row["way"] == "hit_fraction"
        dots += _scatter(f"hits: {row['way']}", [(time, wrong, text)], not ours)
    return Scatter("Full hits", "µs per point", "full hits lost + others kept, %", dots)

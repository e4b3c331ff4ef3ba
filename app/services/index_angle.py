"""An index against the angle: of the leaves of a scan, or of a table of holder angles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.core.amplitude import LEVEL, Amplitude, measure_amplitude
from app.core.arrays import Floats
from app.core.channel_index import ChannelIndex
from app.core.errors import BadInput
from app.core.index_curves import (
    IndexCurve,
    bins_of_index,
    curve_of_index,
    fit_channel,
)
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees
from app.formats.atomic import refuse_targets
from app.services.labels import put_labels_first
from app.services.leaves import Row, write_table


@dataclass(frozen=True, slots=True)
class Group:
    """Values of channels at angles, of one leaf.

    Attributes
    ----------
    labels : mapping of str to str
    angle : (n,) array
        Radians.
    values : mapping of channel to (n,) array
    without_angle, beyond : int
        Points that were left out before: without an angle, and beyond 80°.
    """

    labels: Mapping[str, str]
    angle: Floats
    values: Mapping[str, Floats]
    without_angle: int = 0
    beyond: int = 0

    @property
    def name(self) -> str:
        """The labels in words."""
        return ", ".join(text or "(empty)" for text in self.labels.values()) or "all"


@dataclass(frozen=True, slots=True)
class IndexAngles:
    """Index against angle, leaf by leaf.

    Attributes
    ----------
    index : ChannelIndex
    rows : list of Row
        Per leaf: the index's mean, least and largest value, and amplitude.
    curves : list of Row
        Per leaf and angle: measured steps, and the fitted curve.
    warnings : tuple of str
    names : tuple of str
        Of the leaf of each row, in words.
    """

    index: ChannelIndex
    rows: list[Row]
    curves: list[Row]
    warnings: tuple[str, ...] = ()
    names: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The JSON answer of ``leafscope index-angle``."""
        return {
            "index": self.index.name,
            "channels": list(self.index.channels),
            "picks": [pick.words for pick in self.index.picks],
            "rows": self.rows,
            "curves": self.curves,
            "warnings": list(self.warnings),
        }


def compare_angles(
    index: ChannelIndex,
    groups: Sequence[Group],
    model: str,
    reference: str | None,
    holder: bool,
    progress: Progress = QUIET,
) -> IndexAngles:
    """Curve, range and amplitude of an index in each group.

    Parameters
    ----------
    index : ChannelIndex
    groups : sequence of Group
    model : str
        Angular model that is fitted to each channel.
    reference : str or None
        Channel whose cosine fit gives the angle of the peak; None leaves it free. Only for
        holder angles.
    holder : bool
        The angles are those of a holder. Angles of incidence count from face-on: their peak is
        at 0°.
    progress : Progress
    """
    rows: list[Row] = []
    curves: list[Row] = []
    whose: list[Mapping[str, str]] = []
    warnings: list[str] = []
    for number, group in enumerate(groups):
        progress.report(number / len(groups), "Comparing angles")
        row = _count_points(index, group)
        warnings += _tell_left_out(group.name, row)
        measured = bins_of_index(index, group.angle, group.values)
        lines = _tell_curve("measured", measured)
        row |= _tell_range("measured", measured)
        try:
            fits = {c: fit_channel(model, group.angle, group.values[c]) for c in index.channels}
            fitted = curve_of_index(index, fits)
            lines += _tell_curve("fitted", fitted)
            row |= _tell_range("fitted", fitted)
        except BadInput as error:
            warnings.append(f"{group.name}: no curve: {error}")
        try:
            row |= _measure_amplitudes(index, group, reference, holder)
        except BadInput as error:
            warnings.append(f"{group.name}: no amplitude: {error}")
        rows.append(row)
        curves += lines
        whose += [group.labels] * len(lines)
    if not rows:
        raise BadInput("There is no leaf to compare angles of.")
    labels, names = [group.labels for group in groups], tuple(group.name for group in groups)
    rows, curves = put_labels_first(labels, rows), put_labels_first(whose, curves)
    return IndexAngles(index, rows, curves, tuple(warnings), names)


def _count_points(index: ChannelIndex, group: Group) -> Row:
    """Points that nothing is told of: no angle, a steep one, or no index at a usable angle."""
    known = np.isfinite(group.angle)
    undefined = known & ~np.isfinite(index.evaluate(group.values))
    return {
        "without_angle": group.without_angle + int(np.count_nonzero(~known)),
        "beyond_80": group.beyond,
        "undefined": int(np.count_nonzero(undefined)),
    }


def _tell_left_out(name: str, counts: Row) -> list[str]:
    words = {"without_angle": "without an angle", "beyond_80": "beyond 80°",
             "undefined": "without the index"}  # fmt: skip
    told = [f"{counts[key]:,} {said}" for key, said in words.items() if counts[key]]
    return [f"{name}: points left out: {', '.join(told)}."] if told else []


def _tell_range(name: str, curve: IndexCurve) -> Row:
    low, low_at, high, high_at = map(_number, curve.extremes)
    return {
        f"{name}_min": low,
        f"{name}_min_deg": _degrees(low_at),
        f"{name}_max": high,
        f"{name}_max_deg": _degrees(high_at),
    }


def _tell_curve(name: str, curve: IndexCurve) -> list[Row]:
    cells = zip(curve.angle, curve.value, curve.sigma, curve.count, strict=True)
    return [
        {
            "curve": name,
            "angle_deg": _degrees(float(angle)),
            "index": _number(float(value)),
            "sigma": _number(float(sigma)),
            "n": int(count),
        }
        for angle, value, sigma, count in cells
    ]


def _measure_amplitudes(
    index: ChannelIndex, group: Group, reference: str | None, holder: bool
) -> Row:
    """Amplitudes of the index and of each channel (Hancock 2017, Table I)."""
    mu = None if holder else 0.0
    channels = {c: measure_amplitude(group.angle, group.values[c], mu) for c in group.values}
    if holder and reference is not None and np.isfinite(channels[reference].mu_deg):
        mu = channels[reference].mu_deg
    found = measure_amplitude(group.angle, index.evaluate(group.values), mu)
    row: Row = {"index_mean": _number(found.mean), "n": found.n}
    values = index.evaluate(group.values)[np.isfinite(group.angle)]
    low, high = _interval_of_mean(values)
    row |= {"index_mean_low": _number(low), "index_mean_high": _number(high)}
    row |= _tell_amplitude("A", found)
    row |= {"mu_deg": _number(found.mu_deg)}
    for channel, amplitude in channels.items():
        row |= _tell_amplitude(f"A_{channel}", amplitude)
    return row


def _interval_of_mean(values: Floats) -> tuple[float, float]:
    """95 % interval of a mean by Student's t, as if points were independent."""
    from scipy.stats import t

    known = values[np.isfinite(values)]
    if len(known) < 2:
        return float("nan"), float("nan")
    reach = float(known.std(ddof=1) / np.sqrt(len(known)) * t.isf(LEVEL / 2.0, len(known) - 1))
    return float(known.mean()) - reach, float(known.mean()) + reach


def _tell_amplitude(name: str, found: Amplitude) -> Row:
    return {
        name: _number(found.value),
        f"{name}_low": _number(found.interval[0]),
        f"{name}_high": _number(found.interval[1]),
        f"{name}_from_noise": _number(found.from_noise),
        f"{name}_p": _number(found.p),
        f"{name}_exceeds_noise": int(found.exceeds_noise),
    }


def write_index_angles(found: IndexAngles, out: Path, curve: Path | None, overwrite: bool) -> None:
    """Write the table of leaves, and the table of curves where one is wanted."""
    refuse_targets(filter(None, (out, curve)), overwrite)
    write_table(found.rows, out, overwrite)
    if curve is not None:
        write_table(found.curves, curve, overwrite)


def _degrees(radians: float | None) -> float | None:
    return None if radians is None else float(to_degrees(radians))


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None

"""An index against the angle, and its spread against the footprint, in words."""

from __future__ import annotations

from PySide6.QtCore import QCoreApplication

from app.services.leaves import Row
from app.services.synthetic_footprints import Spread
from widgets.common.numbers import UNKNOWN, count_decimals, show_count, show_number


def tell_leaf(name: str, index: str, row: Row) -> str:
    """Range, amplitude, and whether it exceeds the noise, in a few sentences."""
    parts = [_tell_range(name, index, row)]
    if _number(row, "A") is not None:
        parts.append(_tell_amplitude(row))
    undefined = int(row.get("undefined") or 0)
    if undefined:
        text = _tr("{n} points have no index (a zero or negative sum).")
        parts.append(text.format(n=show_count(undefined)))
    return " ".join(filter(None, parts))


def _tell_range(name: str, index: str, row: Row) -> str:
    kind = "fitted" if row.get("fitted_min") is not None else "measured"
    low, low_at, high, high_at = (
        _number(row, f"{kind}_{what}") for what in ("min", "min_deg", "max", "max_deg")
    )
    if low is None or high is None:
        return _tr("{name} has no value of {index}.").format(name=name, index=index)
    decimals = max(count_decimals(None, (high - low) / 10), 2)
    where = _tr("on the curve") if kind == "fitted" else _tr("of the means per 5°")
    return _tr("{name}: {index} {where} runs from {low} (at {at}°) to {high} (at {to}°).").format(
        name=name, index=index, where=where, low=show_number(low, decimals),
        at=show_number(low_at, 0), high=show_number(high, decimals), to=show_number(high_at, 0),
    )  # fmt: skip


def _tell_amplitude(row: Row) -> str:
    amplitude, noise, p = (_number(row, key) for key in ("A", "A_from_noise", "A_p"))
    chance = _tr("p < 0.0001") if p is not None and p < 1e-4 else f"p = {show_number(p, 4)}"
    if row.get("A_exceeds_noise"):
        text = _tr(
            "Its amplitude A = {A} (95 %: {low} to {high}) exceeds the noise, which alone gives "
            "about {noise} ({p})."
        )
    else:
        text = _tr(
            "Its amplitude A = {A} (95 %: {low} to {high}) does not exceed the noise, which "
            "alone gives about {noise} ({p})."
        )
    low, high = (show_number(_number(row, k), 4) for k in ("A_low", "A_high"))
    return text.format(
        A=show_number(amplitude, 4), low=low, high=high, noise=show_number(noise, 4), p=chance
    )


def list_cells(name: str, row: Row) -> list[str]:
    """Leaf, mean, amplitude ± half its 95 % interval, whether it exceeds the noise."""
    mean, low, high = (_number(row, k) for k in ("index_mean", "A_low", "A_high"))
    beyond = _tr("yes") if row.get("A_exceeds_noise") else _tr("no")
    amplitude = _number(row, "A")
    return [
        name,
        show_number(mean, 3),
        show_with_half(amplitude, low, high),
        UNKNOWN if amplitude is None else beyond,
    ]


def show_with_half(value: float | None, low: float | None, high: float | None) -> str:
    """A number ± half the width of its interval."""
    if value is None or low is None or high is None:
        return show_number(value, 3)
    return f"{show_number(value, 3)} ± {show_number((high - low) / 2, 3)}"


def tell_spread(found: Spread, error: float, reached: float | None) -> str:
    """What the spread is, and from which size on it stays below the error."""
    first = found.rows[0]
    text = _tr("Single points of {index} spread by {sd} (sd of {n}).").format(
        index=found.index.name, sd=show_number(_number(first, "sd"), 4),
        n=show_count(int(first["n"] or 0)),
    )  # fmt: skip
    if reached is None:
        last = _number(found.rows[-1], "diameter_mm")
        rest = _tr("An error of {error} is not reached up to {size} mm.")
        return f"{text} {rest.format(error=f'{error:g}', size=show_number(last, 0))}"
    if reached == 0.0:
        return f"{text} " + _tr("That is below {error} already.").format(error=f"{error:g}")
    rest = _tr("An error of {error} is reached from a footprint of {size} mm on.")
    return f"{text} {rest.format(error=f'{error:g}', size=show_number(reached, 1))}"


def _number(row: Row, key: str) -> float | None:
    value = row.get(key)
    return float(value) if isinstance(value, (int, float)) else None


def _tr(text: str) -> str:
    return QCoreApplication.translate("Indices", text)

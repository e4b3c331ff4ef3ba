"""Wrinkles in words: the numbers of a leaf, why points are not valid, what a shape means."""

from __future__ import annotations

from PySide6.QtCore import QCoreApplication

from app.core.wrinkling.claim import Calibration, Case
from app.core.wrinkling.leaf import JudgedLeaf
from app.core.wrinkling.shape import Shape
from app.core.wrinkling.validity import PARTS, name_reasons
from app.services.leaves import Row
from app.services.wrinkles.measure import LeafWrinkles
from widgets.common.numbers import UNKNOWN, show_count, show_number, show_signed

TITLES: dict[Case, str] = {
    "known": "ω and Δω are known",
    "species": "ω within its interval",
    "levelled": "Only Δω inside the leaf",
}
MEANING: dict[Shape, str] = {
    "unimodal": "one even peak: the index says how wrinkled",
    "skewed": "one skewed peak: a bend, most often",
    "several modes": "several peaks: wrinkles",
    "too few points": "fewer than 30 valid angles: no word",
}
SHARED = {"noise": "noise", "curve": "curve", "reflectance": "reflectance", "offset": "offset"}
Facts = list[tuple[str, str]]


def tell_claim(calibration: Calibration) -> str:
    """What may be claimed: a title and the sentence, as rich text."""
    return f"<b>{_tr(TITLES[calibration.case])}.</b> {calibration.sentence}"


def tell_title(found: LeafWrinkles, row: Row) -> str:
    """Name, angle of the plane and wrinkle index of a leaf, in a line."""
    index = row.get("wrinkle_index_deg")
    if found.judged is None or index is None:
        return f"<b>{found.leaf.name}</b>"
    return _tr("<b>{name}</b>: ω {plane}°, wrinkle index {index}° ({low} to {high})").format(
        name=found.leaf.name, plane=_degrees(row, "omega_plane_deg"),
        index=_degrees(row, "wrinkle_index_deg"), low=_degrees(row, "wrinkle_index_low_deg"),
        high=_degrees(row, "wrinkle_index_high_deg"),
    )  # fmt: skip


def tell_shape(judged: JudgedLeaf) -> str:
    """The word for the distribution, and what it means."""
    return f"<b>{_tr(judged.shape)}</b> ({_tr(MEANING[judged.shape])})"


def tell_reasons(judged: JudgedLeaf) -> str:
    """How many points are grey, and why."""
    counts = name_reasons(judged.angles.doubt)
    total, valid = sum(counts.values()), counts.pop("valid")
    if valid == total:
        return _tr("All {n} points are valid.").format(n=show_count(total))
    why = ", ".join(f"{show_count(count)} {_tr(word)}" for word, count in counts.items() if count)
    return _tr("Grey: {n} of {total} points are not valid: {why}.").format(
        n=show_count(total - valid), total=show_count(total), why=why
    )


def list_facts(found: LeafWrinkles, row: Row) -> Facts:
    """Names and values of one leaf."""
    judged = found.judged
    if judged is None:
        return []
    facts = [
        (_tr("ω of the leaf's plane"), _with_sigma(row, "omega_plane")),
        (_tr("ω of the mean intensity"), _tell_shift(row)),
        (_tr("Wrinkle index"), _tell_index(row, judged)),
        (_tr("Δω, mean ± sd"), _tell_mean(row)),
        (_tr("Δω, median (5 to 95 %)"), _tell_quantiles(row)),
        (_tr("Skewness"), show_signed(_number(row, "skewness"), 2)),
        (_tr("Peaks of Δω"), _tell_modes(row)),
        (_tr("Beyond 2 σ"), _tr("{0} % of the valid points").format(
            show_number(100.0 * (_number(row, "significant_share") or 0.0), 0))),
        (_tr("σ of one angle, median"), _tell_parts(row)),
        (_tr("Offset"), _tell_offset(row, judged)),
        (_tr("Noise of one value"), _tell_noise(judged)),
    ]  # fmt: skip
    if found.calibration is not None:
        facts.append((_tr("Curve"), found.calibration.curve.origin))
    return facts


def _tell_shift(row: Row) -> str:
    shift, plane = _number(row, "omega_of_mean_intensity_minus_plane_deg"), "omega_plane_deg"
    if shift is None:
        return _tr("not on the curve")
    angle = (_number(row, plane) or 0.0) + shift
    return _tr("{angle}° (shift {shift}°)").format(
        angle=show_number(angle, 1), shift=show_signed(shift)
    )


def _tell_index(row: Row, judged: JudgedLeaf) -> str:
    if row.get("wrinkle_index_deg") is None:
        return judged.refusal
    return _tr("{0}° (95 %: {1} to {2})").format(
        *(_degrees(row, f"wrinkle_index{part}_deg") for part in ("", "_low", "_high"))
    )


def _tell_mean(row: Row) -> str:
    mean, sd = _number(row, "delta_mean_deg"), _number(row, "delta_sd_deg")
    rounded = None if mean is None else round(mean, 1) + 0.0  # a levelled leaf has no −0.0°
    return f"{show_signed(rounded)}° ± {show_number(sd, 1)}°"


def _tell_quantiles(row: Row) -> str:
    median, low, high = (
        show_signed(_number(row, f"delta_{part}_deg")) for part in ("median", "q05", "q95")
    )
    return _tr("{0}° ({1} to {2})").format(median, low, high)


def _tell_modes(row: Row) -> str:
    modes = str(row.get("modes_deg") or "").split()
    return ", ".join(f"{show_signed(float(mode))}°" for mode in modes) or UNKNOWN


def _tell_parts(row: Row) -> str:
    """The error and what it is made of."""
    parts = ", ".join(
        f"{_tr(SHARED[part])} {show_number(value, 1)}"
        for part in PARTS
        if (value := _number(row, f"sigma_{part}_median_deg"))
    )
    whole = f"{_degrees(row, 'sigma_median_deg')}°"
    return f"{whole} ({parts})" if parts else whole


def _tell_offset(row: Row, judged: JudgedLeaf) -> str:
    offset = judged.offset
    sign = show_signed(offset.value, 1) if offset.kind == "added" else show_number(offset.value, 3)
    decimals = 1 if offset.kind == "added" else 3
    text = f"{sign} DN" if offset.kind == "added" else f"× {sign}"
    text = f"{text} ± {show_number(offset.sigma, decimals)}" if offset.sigma else text
    factor = _number(row, "offset_as_factor")
    if offset.kind == "factor" or factor is None:
        return text
    return _tr("{0}, reflectance × {1}").format(text, show_number(factor, 2))


def _tell_noise(judged: JudgedLeaf) -> str:
    if judged.offset.kind == "added":
        return f"{show_number(judged.noise, 1)} DN"
    return _tr("{0} % of it").format(show_number(100.0 * judged.noise, 2))


def _with_sigma(row: Row, name: str) -> str:
    sigma = _number(row, f"{name}_sigma_deg")
    text = f"{_degrees(row, f'{name}_deg')}°"
    return text if sigma is None else f"{text} ± {show_number(sigma, 2)}°"


def _degrees(row: Row, name: str) -> str:
    return show_number(_number(row, name), 1)


def _number(row: Row, name: str) -> float | None:
    value = row.get(name)
    return float(value) if isinstance(value, (int, float)) else None


def _tr(text: str) -> str:
    return QCoreApplication.translate("wrinkles", text)

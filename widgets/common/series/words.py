"""How the panel speaks of what was found of a leaf."""

from __future__ import annotations

from PySide6.QtCore import QCoreApplication

from app.core.units import to_mm
from app.model.scan import Vector
from app.model.series import Series, SeriesEntry
from app.services.series.carrying import Found
from widgets.common.numbers import UNKNOWN, show_number

SIGNS = {"sure": "✓", "check": "?", "vanished": "✗", "corrected": "✎"}


def name_verdict(found: Found) -> str:
    """A sign and a word: never a colour alone."""
    words = {
        "sure": _tr("sure"),
        "check": _tr("check"),
        "vanished": _tr("not there"),
        "corrected": _tr("by you") if len(found.rows) else _tr("not there, by you"),
    }
    return f"{SIGNS.get(found.verdict, '')} {words.get(found.verdict, found.verdict)}"


def explain(found: Found, reference: bool) -> str:
    """A sentence or two on one leaf."""
    if reference:
        return _tr("{leaf} comes from this scan.").format(leaf=found.leaf.name)
    if found.verdict == "corrected":
        words = _tr("You said which points it has.") if len(found.rows) else found.reason
        return f"{found.leaf.name}: {words}"
    told = _tr("{share} of it found, {overlap} shared with others, {offset} mm off.").format(
        share=show_share(found.share),
        overlap=show_share(found.overlap),
        offset=show_number(to_mm(abs(found.offset)), 1),
    )
    return f"{found.leaf.name}: {found.reason or told}"


def show_share(share: float) -> str:
    """A share as percent."""
    return UNKNOWN if share != share else f"{share:.0%}"


def name_entry(entry: SeriesEntry, name: str) -> str:
    """What tells a scan from the others: its angle, its hours, its words, else its name."""
    said = []
    if entry.angle_deg is not None:
        said.append(f"{show_number(entry.angle_deg, _decimals(entry.angle_deg))}°")
    if entry.hours is not None:
        said.append(f"{show_number(entry.hours, _decimals(entry.hours))} h")
    said += [text for text in (entry.treatment, entry.label) if text]
    return ", ".join(said) or name


def list_facts(series: Series, reference: str) -> list[tuple[str, str]]:
    """What a series is, in short."""
    entries = series.entries
    facts = [(_tr("Scans"), str(len(entries))), (_tr("Reference"), reference)]
    for title, unit, values in (
        (_tr("Angles"), "°", [e.angle_deg for e in entries if e.angle_deg is not None]),
        (_tr("Times"), " h", [e.hours for e in entries if e.hours is not None]),
    ):
        if values:
            low, high = (show_number(v, _decimals(v)) for v in (min(values), max(values)))
            facts.append((title, _tr("{low} to {high}").format(low=low, high=high) + unit))
    words = dict.fromkeys(entry.treatment for entry in entries if entry.treatment)
    return [*facts, (_tr("Treatments"), ", ".join(words))] if words else facts


def describe_motion(series: Series) -> str:
    """How leaves come from the reference to the other scans."""
    if series.axis is None:
        return _tr("Same pose: leaves are looked for where they were.")
    return _tr("Turned about an axis: {origin}.\nThrough {point} m, along {along}.").format(
        origin=series.axis.origin,
        point=_show_vector(series.axis.point),
        along=_show_vector(series.axis.direction),
    )


def _show_vector(vector: Vector) -> str:
    return "; ".join(show_number(round(value, 3) + 0.0, 3) for value in vector)


def _decimals(value: float) -> int:
    return 0 if value == round(value) else 1 if value * 10 == round(value * 10) else 2


def _tr(text: str) -> str:
    return QCoreApplication.translate("Series", text)

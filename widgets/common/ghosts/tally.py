"""What a clean-up changes, in words for a narrow panel and for the tip behind it."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QCoreApplication

from app.services.cleanup.areas import AreaChange
from app.services.cleanup.statistics import Statistics
from widgets.common.numbers import UNKNOWN, show_count, show_number

MOST_LEAVES = 20


def describe_short(found: Statistics) -> str:
    """Counts by answer, and how far points move."""
    words = {
        "corrected": _tr("{0} corrected"),
        "deleted": _tr("{0} deleted"),
        "kept": _tr("{0} kept"),
        "left marked": _tr("{0} left marked"),
        "open": _tr("{0} left alone"),
    }
    said = [
        word.format(show_count(found.by_answer[name]))
        for name, word in words.items()
        if found.by_answer[name]
    ]
    text = ", ".join(said) or _tr("nothing to do")
    if found.shift_median is not None and found.shift_95 is not None:
        text += _tr("; moved by {0} mm (median), {1} mm (95 %)").format(
            show_number(found.shift_median, 1), show_number(found.shift_95, 0)
        )
    return text + "."


def describe_reasons(found: Statistics) -> str:
    """A table of reasons against answers, as rich text."""
    head = (_tr("Why"), _tr("corrected"), _tr("deleted"), _tr("kept"), _tr("marked"))
    names = ("corrected", "deleted", "kept", "left marked")
    rows = [
        (word, *(show_count(counts[name]) for name in names))
        for word, counts in found.by_reason.items()
    ]
    return _table(head, rows)


def describe_areas(areas: Sequence[AreaChange]) -> str:
    """What became of the area of all leaves that have a mesh before and after; else empty."""
    known = [(a.before, a.after) for a in areas if a.before is not None and a.after is not None]
    if not known:
        return ""
    before, after = (sum(side) for side in zip(*known, strict=True))
    text = _tr(" Area of {0} leaves: {1} cm² before, {2} cm² after.")
    return text.format(show_count(len(known)), show_number(before, 1), show_number(after, 1))


def describe_leaves(found: Statistics, areas: Sequence[AreaChange] = ()) -> str:
    """A table of leaves, points and areas before and after, as rich text; empty without leaves."""
    head = [_tr("Leaf"), _tr("points before"), _tr("after"), _tr("corrected"), _tr("deleted")]
    rows = [
        [
            leaf.name,
            *(show_count(n) for n in (leaf.before, leaf.after, leaf.corrected, leaf.deleted)),
        ]
        for leaf in found.leaves[:MOST_LEAVES]
    ]
    if areas:
        head += [_tr("cm² before"), _tr("after")]
        for row, area in zip(rows, areas, strict=False):
            sides = (area.before, area.after)
            row += [UNKNOWN if side is None else show_number(side, 2) for side in sides]
    more = len(found.leaves) - len(rows)
    if more > 0:
        rows.append([_tr("and {0} more").format(show_count(more))])
    return _table(head, rows) if rows else ""


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = ["".join(f"<th align='left'>{cell}&nbsp;&nbsp;</th>" for cell in head)]
    lines += ["".join(f"<td>{cell}&nbsp;&nbsp;</td>" for cell in row) for row in rows]
    return "<table>" + "".join(f"<tr>{line}</tr>" for line in lines) + "</table>"


def _tr(text: str) -> str:
    return QCoreApplication.translate("GhostTally", text)

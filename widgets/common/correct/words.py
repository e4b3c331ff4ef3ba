"""What corrections say in words: their numbers, and why points are marked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from PySide6.QtCore import QCoreApplication

from app.core.workflows.chain import get_workflow
from app.core.workflows.marks import (
    BEYOND_FITTED,
    NEGATIVE,
    NO_ANGLE,
    NO_CORRECTION,
    NO_INTENSITY,
    SMALL_BRACKET,
    WORDS,
)
from app.model.corrections import Correction, describe_correction
from widgets.common.correct.workflow_grid import SHORT
from widgets.common.numbers import UNKNOWN, count_decimals, show_count, show_number

REASONS = {
    WORDS[NO_INTENSITY]: "without an intensity",
    WORDS[NO_ANGLE]: "without an angle",
    WORDS[BEYOND_FITTED]: "at angles beyond those that were fitted",
    WORDS[SMALL_BRACKET]: "where 1 − b·(1 − cos ω) is below {least}: the correction would explode",
    WORDS[NEGATIVE]: "negative after the correction (kept, for leaving them out raises means)",
    WORDS[NO_CORRECTION]: "of leaves without a correction",
}


def tell_marks(workflow: str, counts: Mapping[str, int], least: float) -> str:
    """How many points are marked and why, in a sentence."""
    total, good = sum(counts.values()), counts.get(WORDS[0], 0)
    if total == good:
        text = _tr("{workflow}: all {n} points have a value.")
        return text.format(workflow=SHORT[workflow], n=show_count(total))
    reasons = ", ".join(
        f"{show_count(counts[word])} {_tr(why).format(least=f'{least:g}')}"
        for word, why in REASONS.items()
        if counts.get(word)
    )
    text = _tr("{workflow}: {marked} of {n} points are marked: {reasons}.")
    return text.format(
        workflow=SHORT[workflow], marked=show_count(total - good), n=show_count(total),
        reasons=reasons,
    )  # fmt: skip


def list_numbers(
    corrections: Sequence[Correction], names: Mapping[str, str]
) -> tuple[list[tuple[str, ...]], list[str]]:
    """Rows (whose, workflow, b, k_d, m) and their tool tips; `names` are those of leaves."""
    rows, tips = [], []
    for each in corrections:
        whose = ", ".join(names.get(key, key) for key in each.leaves) or _tr("all")
        cells = [_show(each, name) for name in ("b", "k_d", "m")]
        rows.append((whose, SHORT[each.workflow], *cells))
        low, high = (math.degrees(angle) for angle in each.fitted)
        tips.append(
            _tr("{whose}: {numbers}; angles {low}° to {high}°").format(
                whose=whose, numbers=describe_correction(each),
                low=f"{low:.1f}", high=f"{high:.1f}",
            )
        )  # fmt: skip
    return rows, tips


def _show(each: Correction, name: str) -> str:
    if name not in each.values:
        taken = get_workflow(each.workflow).assumed.get(name)
        return UNKNOWN if taken is None else f"{taken:g}"
    variance = each.covariance.get(name, {}).get(name)
    sd = None if variance is None else math.sqrt(max(variance, 0.0))
    if sd == 0.0 or sd is None:
        return f"{each.values[name]:.4g}"
    # On two lines: three such columns have to fit into a narrow panel.
    value, decimals = each.values[name], max(count_decimals(each.values[name], sd), 2)
    return f"{show_number(value, decimals)}\n± {show_number(sd, decimals)}"


def _tr(text: str) -> str:
    return QCoreApplication.translate("Corrections", text)

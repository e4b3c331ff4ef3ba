"""What the history calls a change of corrections, own indices or the synthetic footprint."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QCoreApplication

from app.core.units import to_mm
from app.core.workflows.chain import get_workflow
from app.model.corrections import Correction
from app.model.parameters import Formula

MOST_NAMED = 2


def title_corrections(old: Sequence[Correction], new: Sequence[Correction]) -> str:
    """Which channels are corrected now, and by what; or which no more."""
    added = [each for each in new if each not in old]
    if added:
        return _tr("Correct {what}").format(what=_list([_tell(added, n) for n in _names(added)]))
    gone = [name for name in _names(old) if name not in _names(new)]
    if gone:
        return _tr("Remove correction {names}").format(names=_list(gone))
    return _tr("Change corrections")


def _names(corrections: Sequence[Correction]) -> list[str]:
    return list(dict.fromkeys(each.name for each in corrections))


def _tell(corrections: Sequence[Correction], name: str) -> str:
    mine = [each for each in corrections if each.name == name]
    first, short = mine[0], get_workflow(mine[0].workflow).title.partition(",")[0]
    if len(mine) > 1:
        how = _tr("{n} leaves").format(n=len(mine))
    else:
        how = ", ".join(f"{key} = {value:.3g}" for key, value in first.values.items())
    return _tr("{channel} by {workflow} ({how})").format(
        channel=first.source, workflow=short, how=how
    )


def title_formulas(old: Sequence[Formula], new: Sequence[Formula]) -> str:
    """Which index was written, renamed or removed."""
    before, after = {f.name: f.text for f in old}, {f.name: f.text for f in new}
    added = [name for name in after if name not in before]
    gone = [name for name in before if name not in after]
    changed = [name for name in after if name in before and before[name] != after[name]]
    if len(added) == len(gone) == 1:
        return _tr("Rename index {old} to {new}").format(old=gone[0], new=added[0])
    if added or changed:
        written = [f"{name} = {after[name]}" for name in (*added, *changed)]
        return _tr("Write index {what}").format(what=_list(written))
    if gone:
        return _tr("Remove index {names}").format(names=_list(gone))
    return _tr("Change own indices")


def title_footprint(diameter: float | None) -> str:
    """To which size the channels are smoothed."""
    if diameter is None:
        return _tr("Smooth channels no more")
    return _tr("Smooth channels over {mm} mm").format(mm=f"{to_mm(diameter):g}")


def _list(names: Sequence[str]) -> str:
    if len(names) > MOST_NAMED:
        return _tr("{names} and {n} more").format(
            names=", ".join(names[:MOST_NAMED]), n=len(names) - MOST_NAMED
        )
    return ", ".join(names)


def _tr(text: str) -> str:
    return QCoreApplication.translate("StepTitles", text)

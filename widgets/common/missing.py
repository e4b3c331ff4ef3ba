"""What a panel about leaves and angles lacks, in words, and what helps."""

from __future__ import annotations

from collections.abc import Collection

from PySide6.QtCore import QCoreApplication

from app.model.state import ScanState
from widgets.controller import Controller


def find_missing(
    state: ScanState | None, to_open: str, no_channel: str, what: str, keys: Collection[str] | None
) -> tuple[str, str]:
    """A sentence and the text of a button; both empty when nothing is missing.

    Parameters
    ----------
    state : ScanState or None
        The current scan.
    to_open, no_channel : str
        What the panel says without a scan, and without an intensity.
    what : str
        Which leaves were asked for; "chosen" and "leaf" have sentences of their own.
    keys : collection of str or None
        Leaves that are there; None for the whole scan.
    """
    if state is None:
        return to_open, ""
    if not state.channels:
        return no_channel, ""
    if state.scan.pose is None:
        return _tr(
            "Nobody knows where the scanner stood, and without that there are no angles."
        ), _tr("Set position…")
    if keys is None or keys:
        return "", ""
    if what == "chosen":
        return _tr("Select one or more leaves of this scan in the Leaves panel."), ""
    if what == "leaf":
        return _tr("Choose a leaf in the Leaves panel, or draw one with the lasso."), ""
    return _tr("This scan has no leaf yet: find or draw some, or take the whole scan."), ""


def list_keys(controller: Controller, what: str, chosen: Collection[str]) -> tuple[str, ...] | None:
    """Keys of the leaves that are asked for, in the order of the scan; None for the whole scan."""
    if what == "scan":
        return None
    leaves = controller.project.state.leaves_of(controller.current or "")
    keys = tuple(leaf.key for leaf in leaves)
    wanted = {"chosen": chosen, "leaf": (controller.view.leaf,)}.get(what, keys)
    return tuple(key for key in keys if key in wanted)


def _tr(text: str) -> str:
    return QCoreApplication.translate("Missing", text)

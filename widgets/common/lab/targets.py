"""Whose points are looked at, what is missing for it, and how it is titled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QObject

from app.core.errors import LeafscopeError
from app.model.state import State
from app.services.curves import result_of
from widgets.common.angular_points import NO_POINTS, AngularPoints
from widgets.common.curve_choice import CurveChoice, Target, What
from widgets.common.known_fits import find_newest
from widgets.common.lab.gathering import Group, Wanted
from widgets.common.lab.series import Series, Shape
from widgets.controller import Controller


def choose_groups(controller: Controller, what: What, chosen: Sequence[str]) -> tuple[Group, ...]:
    """Groups of leaves of the current scan, the one at work first; () is the whole scan."""
    if what == "scan":
        return ((),)
    leaves, current = controller.project.state.leaves, controller.view.leaf or ""
    asked = (current,) if what == "leaf" else tuple(chosen)
    keys = [k for k in asked if k in leaves and leaves[k].scan == controller.current]
    if what != "each":
        return (tuple(keys),) if keys else ()
    return tuple((key,) for key in sorted(keys, key=lambda key: key != current))


def find_missing(
    panel: QObject, controller: Controller, what: What, targets: Sequence[Target]
) -> tuple[str, str]:
    """What keeps the lab from showing anything, and the button that helps; both may be empty."""
    state = controller.scan
    if state is None:
        return panel.tr("Open a scan to see how its intensity depends on the angle."), ""
    if not state.channels:
        return panel.tr(
            "This scan has no intensity, and a curve needs it. If one of its values is an "
            "intensity, name it as a channel in the Scans panel."
        ), ""
    if state.scan.pose is None:
        return panel.tr(
            "Nobody knows where the scanner stood, and without that there are no angles."
        ), panel.tr("Set position…")
    if not targets and what in ("chosen", "each"):
        return panel.tr("Select one or more leaves of this scan in the Leaves panel."), ""
    if not targets:
        return panel.tr(
            "Choose a leaf in the Leaves panel or draw one with the lasso, "
            "or look at the whole scan."
        ), ""
    return "", ""


def title_values(panel: QObject, kind: str) -> str:
    """Title of an axis of intensities, with the unit."""
    return {
        "DN": panel.tr("Intensity (DN)"),
        "dB": panel.tr("Intensity (dB)"),
        "linear": panel.tr("Intensity (linear)"),
        "reflectance": panel.tr("Reflectance (0–1)"),
    }[kind]


def build_series(
    state: State,
    targets: Sequence[Target],
    found: Mapping[Wanted, AngularPoints],
    choice: CurveChoice,
    shape: Shape | None,
) -> tuple[Series, ...]:
    """What is drawn of each target; the first has the curve of the editor."""
    groups = list(dict.fromkeys(target.leaves for target in targets))
    channels = list(dict.fromkeys(target.channel for target in targets))
    series = []
    for place, target in enumerate(targets):
        channel = choice.channel_list.title_of(target.channel)
        # A look tells channels apart, or leaves, or, where there are both, each of them.
        if len(groups) == 1:
            title, number = channel, choice.channel_list.number_of(target.channel)
        elif len(channels) == 1:
            title, number = _name(state, target.leaves), place
        else:
            title, number = f"{_name(state, target.leaves)}, {channel}", place
        points = found.get((target.leaves, target.channel), NO_POINTS)
        series.append(
            Series(title, number, points, shape if place == 0 else _known_shape(state, target))
        )
    return tuple(series)


def _name(state: State, group: Group) -> str:
    names = [state.leaves[key].name for key in group if key in state.leaves]
    return ", ".join(names)


def _known_shape(state: State, target: Target) -> Shape | None:
    """The curve of the newest fit of a target."""
    record = find_newest(state, target)
    if record is None:
        return None
    try:
        result = result_of(record)
    except LeafscopeError:
        return None
    return Shape(result.angular_model, result.values)

"""Wrinkles of the leaves of a scan: a request in, arrays and numbers per leaf out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from app.core.arrays import Ints
from app.core.errors import Cancelled, LeafscopeError
from app.core.progress import QUIET, Progress
from app.core.wrinkling.claim import Calibration
from app.core.wrinkling.leaf import Choices, JudgedLeaf, LeafPoints, judge_leaf, pool_noise
from app.model.leaf import Leaf
from app.model.project import Project
from app.model.scan import Channel
from app.services.wrinkles.calibrating import Calibrator, calibrate
from app.services.wrinkles.gather import gather_leaves
from app.services.wrinkles.request import CurveInUse, WrinkleRequest
from app.services.wrinkles.scale import find_scale

RAW = (
    "{channel} holds raw DN, which depend on the range too: inside a leaf that is little, from "
    "leaf to leaf it is not. Take a calibrated channel (--profile) where ω itself counts."
)


@dataclass(frozen=True, slots=True, eq=False)
class LeafWrinkles:
    """One leaf of a scan.

    Attributes
    ----------
    leaf : Leaf
    points : (k,) numbers
        Its living points; arrays of `judged` are in their order.
    measured : LeafPoints
    calibration : Calibration or None
    judged : JudgedLeaf or None
    refusal : str
        Why nothing can be said of it.
    """

    leaf: Leaf
    points: Ints
    measured: LeafPoints
    calibration: Calibration | None
    judged: JudgedLeaf | None
    refusal: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class ScanWrinkles:
    """Leaves of a scan, the channel that was read, and what to be warned of."""

    leaves: tuple[LeafWrinkles, ...]
    channel: Channel
    warnings: tuple[str, ...]


def measure_wrinkles(
    project: Project,
    scan: str,
    request: WrinkleRequest,
    keys: Sequence[str] | None = None,
    progress: Progress = QUIET,
) -> ScanWrinkles:
    """Judge leaves of a scan by their intensity.

    A leaf of which nothing can be said has a refusal and does not stop the others. The noise of
    the channel, and the height of a species' curve, are taken from all leaves of the scan.

    Parameters
    ----------
    keys : sequence of str or None
        Leaves; None: all.

    Raises
    ------
    LeafscopeError
        The request cannot be met for any leaf: no scanner position, channel, curve or scale.
    Cancelled
    """
    state = project.state.scan(scan)
    channel = _find_channel(project, scan, request)
    scale = find_scale(channel, state.scan, request.instrument)
    saturated = scale.saturated if request.saturated is None else request.saturated
    if channel not in state.scan.channels and request.saturated is None:
        saturated = None  # the end of raw numbers is none of calibrated ones
    gathered = gather_leaves(project, scan, None, channel, saturated, progress.part(0.0, 0.4))
    progress.report(0.4, "Noise of the channel")
    choices = request.choices
    if choices.noise is None:
        choices = replace(choices, noise=pool_noise(gathered.measured, scale.scale))
    calibrator = calibrate(
        project, scan, request, channel, scale, gathered, progress.part(0.4, 0.5)
    )
    chosen = [each for each in gathered if keys is None or each[0].key in keys]
    found = []
    for number, (leaf, points, measured) in enumerate(chosen):
        progress.report(0.5 + 0.5 * number / len(chosen), f"Wrinkles of {leaf.name}")
        found.append(_judge(leaf, points, measured, calibrator, choices))
    warnings = (*gathered.warnings, *calibrator.warnings)
    if channel.kind == "DN" and channel in state.scan.channels:
        warnings = (*warnings, RAW.format(channel=channel.name))
    return ScanWrinkles(tuple(found), channel, warnings)


def _find_channel(project: Project, scan: str, request: WrinkleRequest) -> Channel:
    state = project.state.scan(scan)
    if request.channel is not None:
        return state.channel(request.channel)
    curve = state.parameters.curve
    if isinstance(request.source, CurveInUse) and curve is not None:
        return state.channel(curve.channel)
    return state.channel_in_use("an angle from intensity")


def _judge(
    leaf: Leaf, points: Ints, measured: LeafPoints, calibrator: Calibrator, choices: Choices
) -> LeafWrinkles:
    calibration = None
    try:
        calibration = calibrator.of_leaf(leaf, points, measured)
        judged = judge_leaf(measured, calibration, choices)
    except Cancelled:
        raise
    except LeafscopeError as error:
        return LeafWrinkles(leaf, points, measured, calibration, None, str(error))
    return LeafWrinkles(leaf, points, measured, calibration, judged)

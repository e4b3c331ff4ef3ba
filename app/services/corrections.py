"""Corrections for the angle of incidence: made from fits, papers or numbers, put to use, undone.

Corrected channels stand beside the calibrated one (WF1) as channels of their own: nothing is
changed in place.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from msgspec.structs import replace

from app.core.errors import BadInput, WrongUse
from app.core.fitting import FitResult
from app.core.workflows.chain import LEAST_BRACKET, get_workflow
from app.core.workflows.marks import WORDS
from app.core.workflows.published import SOURCE, find_published
from app.model.corrections import Correction
from app.model.leaf import FitRecord
from app.model.operations import SetParameters
from app.model.project import Project
from app.model.scan import Channel

MOST_NAMED = 3
DECIBEL = "A logarithm of the light cannot be divided by a factor."


def correction_of_fit(
    project: Project,
    record: FitRecord,
    workflow: str,
    *,
    leaves: Sequence[str] | None = None,
    least_bracket: float = LEAST_BRACKET,
) -> Correction:
    """A correction with the parameters of a fit, their covariance and its range of angles.

    Parameters
    ----------
    project : Project
    record : FitRecord
        Of model incidence-b for WF2, of lambert-beckmann for WF3.
    workflow : str
    leaves : sequence of str or None
        Keys of the leaves that it is for; None: those that were fitted (all points for a fit of
        the whole scan), empty: all points.
    least_bracket : float

    Raises
    ------
    WrongUse
        The fit is of another model.
    BadInput
        The data left a parameter undetermined that the workflow needs.
    """
    chain, result = get_workflow(workflow), FitResult.from_dict(record.result)
    if record.model != chain.model:
        raise WrongUse(
            f"{chain.title} takes a fit of {chain.model}, not of {record.model}.",
            f"Fit {chain.model} to {record.channel} first.",
        )
    values = {
        name: value
        for name, value in result.values.items()
        if name in chain.parameters and math.isfinite(value)
    }
    _require_determined(chain.parameters, chain.assumed, values, record)
    wanted = record.leaves if leaves is None else tuple(leaves)
    return Correction(
        record.channel,
        workflow,
        values,
        covariance_of(result, values),
        least_bracket,
        result.angle_range,
        _tell_origin(project, record),
        wanted,
    )


def _require_determined(
    names: Iterable[str],
    assumed: Mapping[str, float],
    values: Mapping[str, float],
    record: FitRecord,
) -> None:
    for name in names:
        dull = name == "m" and values.get("k_d") == 1.0
        if name not in values and name not in assumed and not dull:
            raise BadInput(
                f"The fit of {record.channel} left {name} undetermined: nothing to correct with."
            )


def covariance_of(result: FitResult, names: Iterable[str]) -> dict[str, dict[str, float]]:
    """Covariance of some parameters; where a fit tells only their σ, as if independent."""
    told: dict[str, dict[str, float]] = getattr(result, "covariance", {})
    wanted = [name for name in names if result.parameters[name].sd is not None]
    if told:
        return {a: {b: told[a][b] for b in wanted if b in told[a]} for a in wanted if a in told}
    return {name: {name: float(result.parameters[name].sd or 0.0) ** 2} for name in wanted}


def _tell_origin(project: Project, record: FitRecord) -> str:
    leaves = project.state.leaves
    names = [leaves[key].name for key in record.leaves if key in leaves]
    if len(names) > MOST_NAMED:
        return f"fit of {len(names)} leaves, {names[0]} to {names[-1]}"
    return f"fit of {', '.join(names) if names else 'the whole scan'}"


def published_correction(
    channel: Channel, workflow: str, species: str, leaves: Sequence[str] = ()
) -> Correction:
    """A correction with Junttila's parameters of a species at the channel's wavelength.

    `leaves` are the keys of those of this species; none: all points.

    Raises
    ------
    WrongUse
        The paper has no such species or wavelength.
    """
    values = find_published(species, channel.wavelength_nm, workflow)
    origin = f"{species}, {SOURCE}"
    return Correction(channel.name, workflow, values, origin=origin, leaves=tuple(leaves))


def apply_corrections(
    project: Project, scan: str, corrections: Sequence[Correction], *, instead: bool = False
) -> None:
    """Put corrections to use beside those in use, as one step to undo.

    One of the same channel, workflow and leaves is replaced. With `instead` they take the place
    of all that is in use for the same leaves: one for all points replaces every one of its name.

    Raises
    ------
    WrongUse
        The channel is corrected already, or two corrections are for one leaf.
    BadInput
        The channel is in dB.
    MissingChannel
        There is no such channel.
    MissingScanner
        Nobody knows where the scanner stood.
    """
    state = project.state.scan(scan)
    state.scan.scanner("the angle of incidence")
    for correction in corrections:
        _check_source(state.channel(correction.source))
    marks = [(each.name, each.leaves) for each in corrections]
    kept = [each for each in state.parameters.corrections if (each.name, each.leaves) not in marks]
    if instead:
        kept = [rest for each in kept if (rest := _cut(each, corrections)) is not None]
    wanted = (*kept, *corrections)
    _refuse_two_for_one(wanted)
    project.do(SetParameters(scan, replace(state.parameters, corrections=wanted)))


def _cut(old: Correction, newer: Sequence[Correction]) -> Correction | None:
    """What remains of a correction beside newer ones."""
    rivals = [each for each in newer if each.name == old.name]
    if any(not each.leaves for each in rivals):
        return None
    taken = {key for each in rivals for key in each.leaves}
    left = tuple(key for key in old.leaves if key not in taken)
    return old if not old.leaves else replace(old, leaves=left) if left else None


def _check_source(source: Channel) -> None:
    if source.workflow:
        raise WrongUse(
            f"{source.name} is corrected already.", "Correct the calibrated channel itself."
        )
    if source.kind == "dB":
        raise BadInput(
            f"{source.name} is in dB. {DECIBEL}", "Calibrate it to reflectance by a profile."
        )


def _refuse_two_for_one(corrections: Sequence[Correction]) -> None:
    taken: set[tuple[str, str]] = set()
    for correction in corrections:
        for key in correction.leaves or ("all",):
            if (correction.name, key) in taken:
                raise WrongUse(
                    f"Two corrections make {correction.name} of "
                    f"{'all points' if key == 'all' else key}.",
                    "Take one of them out.",
                )
            taken.add((correction.name, key))


def remove_corrections(project: Project, scan: str, names: Sequence[str] | None = None) -> None:
    """Take corrected channels out, all of them where none is named, as one step to undo."""
    parameters = project.state.scan(scan).parameters
    there = {each.name for each in parameters.corrections}
    for name in names or ():
        if name not in there:
            raise WrongUse(
                f"{name} is no corrected channel.", f"There are: {', '.join(sorted(there))}."
            )
    kept = tuple(c for c in parameters.corrections if names is not None and c.name not in names)
    project.do(SetParameters(scan, replace(parameters, corrections=kept)))


def tell_corrections(project: Project, scan: str, fields: Sequence[str]) -> list[str]:
    """Sentences about corrected channels among computed fields: the numbers, what is marked."""
    state, known = project.state.scan(scan), project.cache.known(scan)
    lines = []
    for channel in state.channels:
        name = channel.name
        if channel.workflow and name in known and any(f.startswith(name) for f in fields):
            counts = [f"{known[name].notes[w]:,} {w}" for w in WORDS if known[name].notes.get(w)]
            lines.append(f"{name}: {channel.calibration}; {', '.join(counts)}.")
            lines += filter(None, [warn_about_source(channel)])
    return lines


def warn_about_source(channel: Channel) -> str:
    """Say in a sentence why correcting this channel may mean nothing; empty if all is well."""
    if channel.kind != "DN":
        return ""
    return f"{channel.name} is in raw DN, which may be logarithmic: calibrate it first."

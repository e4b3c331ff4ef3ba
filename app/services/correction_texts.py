"""Corrections as a command says them: ``CHANNEL:WORKFLOW:b=1.78``, a species, or a table of fits.

Examples: ``reflectance_1550:wf2:b=1.78,to=60``, ``reflectance_690:wf3:birch``,
``reflectance_1550:wf2:fits.json``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from app.core.errors import BadInput, WrongUse
from app.core.units import to_radians
from app.core.workflows.chain import LEAST_BRACKET, get_workflow
from app.core.workflows.published import list_published
from app.model.corrections import Correction
from app.model.project import Project
from app.services.corrections import apply_corrections, published_correction

EXAMPLE = "Write CHANNEL:WORKFLOW:b=1.78, CHANNEL:WORKFLOW:SPECIES or CHANNEL:WORKFLOW:FITS.json."
TYPED = "typed in"
LIMITS = {"least": LEAST_BRACKET, "from": 0.0, "to": 90.0}


def use_correction_texts(project: Project, scan: str, texts: Sequence[str]) -> None:
    """Put the corrections that a command names to use, as one step.

    Raises
    ------
    WrongUse
        A text that says no correction.
    BadInput
        A table of fits that cannot be used.
    """
    apply_corrections(project, scan, [parse_correction(project, scan, text) for text in texts])


def parse_correction(project: Project, scan: str, text: str) -> Correction:
    """Read one text; see the head of this module for the forms, and `use_correction_texts`."""
    name, _, rest = text.partition(":")
    workflow, _, numbers = rest.partition(":")
    if not numbers:
        raise WrongUse(f"{text!r} says no correction.", EXAMPLE)
    get_workflow(workflow)
    channel = project.state.scan(scan).channel(name)
    if numbers.endswith(".json"):
        return read_fitted(Path(numbers), name, workflow)
    if numbers in list_published():
        return published_correction(channel, workflow, numbers)
    values = _parse_numbers(numbers)
    limits = {key: values.pop(key, usual) for key, usual in LIMITS.items()}
    low, high = (float(to_radians(limits[key])) for key in ("from", "to"))
    return Correction(name, workflow, values, {}, limits["least"], (low, high), TYPED)


def _parse_numbers(text: str) -> dict[str, float]:
    values = {}
    for part in text.split(","):
        name, _, number = part.partition("=")
        try:
            values[name.strip()] = float(number)
        except ValueError as error:
            raise WrongUse(
                f"{text!r} holds no numbers of a correction, and is no species.",
                f"{EXAMPLE} Species: {', '.join(list_published())}.",
            ) from error
    return values


def read_fitted(path: Path, channel: str, workflow: str) -> Correction:
    """The correction of the only fit, or the fit of this channel, in a table of fits.

    Parameters
    ----------
    path : Path
        What ``leafscope fit --json`` printed.
    channel, workflow : str

    Raises
    ------
    BadInput
        The file is no such table, or none or several of its fits are meant.
    """
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))["fits"]
        fits = [entry for entry in entries if _is_meant(entry, channel, workflow)]
        made = [_correction_of(entry, path.name, channel, workflow) for entry in fits]
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise BadInput(f"{path} is no table of fits: {error}.", "Make one with fit --json.") from (
            error
        )
    if len(made) != 1:
        raise BadInput(
            f"{path.name} has {len(made)} fits of {get_workflow(workflow).model} for {channel}.",
            "Keep the one that is meant, with its channel as a group.",
        )
    return made[0]


def _is_meant(entry: Mapping[str, Any], channel: str, workflow: str) -> bool:
    if entry["model"] != get_workflow(workflow).model:
        return False
    said = entry["group"].get("channel")
    return said is None or said == channel


def _correction_of(entry: Mapping[str, Any], name: str, channel: str, workflow: str) -> Correction:
    wanted = get_workflow(workflow).parameters
    told = {key: p for key, p in entry["parameters"].items() if key in wanted}
    values = {key: float(p["value"]) for key, p in told.items() if p["value"] is not None}
    spread = {key: p["sd"] for key, p in told.items() if key in values and p["sd"] is not None}
    covariance = _read_covariance(entry.get("covariance") or {}, spread)
    low, high = (float(to_radians(a)) for a in entry.get("angles_deg") or (0.0, 90.0))
    return Correction(channel, workflow, values, covariance, LEAST_BRACKET, (low, high), name)


def _read_covariance(
    told: Mapping[str, Mapping[str, float]], spread: Mapping[str, float]
) -> dict[str, dict[str, float]]:
    """The covariance of a fit; where only standard deviations are told, as if independent."""
    if not told:
        return {key: {key: float(sd) ** 2} for key, sd in spread.items()}
    return {a: {b: float(told[a][b]) for b in spread} for a in spread}

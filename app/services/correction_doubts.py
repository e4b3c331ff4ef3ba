"""Why the numbers of a correction deserve doubt: at a bound, beyond physics, nothing to remove."""

from __future__ import annotations

from app.core.phase import get_model
from app.core.phase.lambert_beckmann import ROUGHEST_PHYSICAL
from app.core.workflows.chain import get_workflow
from app.model.corrections import Correction


def doubt_correction(correction: Correction) -> tuple[str, ...]:
    """Sentences about the parameters of a correction; none where nothing is to be said."""
    values, found = correction.values, []
    dull = values.get("k_d") == 1.0
    if dull:
        found.append("k_d is 1: no specular share is removed.")
    for parameter in get_model(get_workflow(correction.workflow).model).parameters:
        name = parameter.name
        value = values.get(name)
        if value is None or (dull and name in ("k_d", "m")) or parameter.scales:
            continue
        if parameter.touches_bound(value):
            found.append(f"{name} is on its bound, {value:g}: the data do not determine it.")
    if not dull and values.get("m", 0.0) > ROUGHEST_PHYSICAL:
        found.append(
            f"m is above {ROUGHEST_PHYSICAL:.3f}: the specular share that is removed rises away "
            "from 0°, which is unphysical."
        )
    return tuple(found)

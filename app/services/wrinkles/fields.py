"""Wrinkles as fields of the scan: NaN outside leaves and where no angle is valid."""

from __future__ import annotations

import numpy as np

from app.core.units import to_degrees
from app.model.fields import Values, fingerprint
from app.model.project import Project
from app.model.wrinkle_fields import DELTA, SIGNIFICANCE
from app.services.wrinkles.measure import ScanWrinkles


def _list_claims(found: ScanWrinkles) -> set[str]:
    return {leaf.calibration.case for leaf in found.leaves if leaf.calibration}


def fields_of(project: Project, scan: str, found: ScanWrinkles) -> dict[str, Values]:
    """What `Project.accept` takes over.

    Parameters
    ----------
    project : Project
        As it was when the wrinkles were measured: it says what the values depend on.
    """
    size = len(project.state.scan(scan).scan)
    delta, significance = np.full(size, np.nan), np.full(size, np.nan)
    for leaf in found.leaves:
        if leaf.judged is not None:
            valid = leaf.judged.angles.valid
            delta[leaf.points[valid]] = to_degrees(leaf.judged.delta[valid])
            significance[leaf.points[valid]] = leaf.judged.significance[valid]
    catalogue, subject = project.catalogue(scan), project.subject(scan)
    every = np.ones(size, bool)
    curves = {leaf.calibration.curve.origin for leaf in found.leaves if leaf.calibration}
    notes = {"curve": "; ".join(sorted(curves)), "claim": "; ".join(sorted(_list_claims(found)))}
    return {
        name: Values(
            fingerprint(catalogue, name, subject),
            values,
            every,
            True,
            notes=dict(notes),
            computed=size,
            fresh=size,
        )
        for name, values in ((DELTA, delta), (SIGNIFICANCE, significance))
    }

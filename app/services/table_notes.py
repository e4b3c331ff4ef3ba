"""What is to be said about the numbers of a user's table before they are fitted."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats

LARGEST_RADIANS = 1.6
"""A right angle, and what was rounded."""
FEW = 3


def tell_missing(table: str, columns: dict[str, Floats]) -> tuple[str, ...]:
    """Say how many rows of a table lack a number; nothing if all have one."""
    lacking = [np.isnan(numbers) for numbers in columns.values()]
    count = int(np.count_nonzero(np.any(lacking, axis=0)))
    if not count:
        return ()
    names = " or ".join(name for name, gaps in zip(columns, lacking, strict=True) if gaps.any())
    rows = "1 row has" if count == 1 else f"{count} rows have"
    return (f"{table}: {rows} no number in {names}.",)


def tell_radians(column: str, angle: Floats) -> tuple[str, ...]:
    """Say that angles, meant as degrees, look like radians; nothing if they do not."""
    known = np.unique(angle[np.isfinite(angle)])
    if len(known) <= FEW or np.abs(known).max() > LARGEST_RADIANS:
        return ()
    return (
        f"The angles in column {column}, {known[0]:.3g} to {known[-1]:.3g}, look like radians; "
        "degrees are expected.",
    )


def tell_negative(angle: Floats) -> tuple[str, ...]:
    """Say where negative angles, which a fit leaves out, come from; nothing without them."""
    if not (angle < 0.0).any():
        return ()
    return (
        "Negative angles look like those of a holder: use a column of incidence angles "
        "(incidence_mean_deg), or the model cosine.",
    )

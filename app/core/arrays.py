"""Array types, and the few questions about arrays that everyone asks."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]
AnyArray = npt.NDArray[Any]


def finite_rows(xyz: Floats) -> Bools:
    """Rows of an (n, 3) array without NaN or infinity, as (n,) booleans."""
    finite: Bools = np.logical_and.reduce(np.isfinite(xyz), axis=1)
    return finite


def read_only(array: AnyArray) -> AnyArray:
    """The same array, protected against writing: scans share their arrays."""
    view = array.view()
    view.flags.writeable = False
    return view

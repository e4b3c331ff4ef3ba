"""Reflectance of a leaf from PROSPECT-5, where the optional package prosail is installed."""

from __future__ import annotations

from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.simulate.spectra import read_off

GRAMS = "g/cm² (1 g/m² is 0.0001 g/cm²)"


class Prospect(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, rename={"n": "N"}
):
    """Input of PROSPECT-5 (science: section 6); the bounds are those of measured leaves.

    Attributes
    ----------
    n : float
        Layers of the leaf, written ``N``.
    Cab, Car : float
        Chlorophyll and carotenoids, µg/cm².
    EWT, LMA : float
        Water and dry mass, g/cm².
    """

    n: Annotated[float, Meta(ge=1, le=4)]
    Cab: Annotated[float, Meta(ge=0, le=150)]
    Car: Annotated[float, Meta(ge=0, le=50)]
    EWT: Annotated[float, Meta(ge=0, le=0.1, description=GRAMS)]
    LMA: Annotated[float, Meta(gt=0, le=0.1, description=GRAMS)]


def reflect(prospect: Prospect, wavelengths_nm: Floats, water: float = 1.0) -> Floats:
    """Reflectance at some wavelengths; `water` multiplies the leaf's EWT.

    PROSPECT tells the hemispherical reflectance, which is taken as the reflectance factor at
    ω = 0: the two differ by the gloss alone.

    Raises
    ------
    BadInput
        prosail is not installed, or a wavelength lies outside 400–2500 nm.
    """
    try:
        from prosail import run_prospect  # type: ignore[import-not-found,unused-ignore]
    except ModuleNotFoundError as error:
        raise BadInput(
            "A material made by PROSPECT needs the package prosail, which is not installed.",
            "Install it with: pip install 'leafscope[prospect]'; or name a ready material.",
        ) from error
    nm, rho, _ = run_prospect(
        prospect.n,
        prospect.Cab,
        prospect.Car,
        0.0,
        prospect.EWT * water,
        prospect.LMA,
        prospect_version="5",
    )
    return read_off(np.asarray(nm, float), np.asarray(rho, float), wavelengths_nm, "PROSPECT")

"""Correct a number of a log instrument to the reference range (Balduzzi et al. 2011, eqs 6, 7).

A panel (99 %) scanned at many ranges gives the curve f99(d). Equation 7 moves a point along
that curve and works for any target; equation 6, the ratio form, needs to know how far the
target lies from the panel at the reference range. The signs are those of the consistent form;
the print has the other sign in both equations.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from app.core.arrays import Floats

Curve = Callable[[Floats], Floats]
"""f99: DN of the panel at ranges in metres; NaN outside the ranges where it was scanned."""


def shift_to_reference(dn: Floats, distance: Floats, curve: Curve, reference: float) -> Floats:
    """Equation 7: I_c = f99(d_ref) + c with c = I − f99(d).

    Parameters
    ----------
    dn, distance : (n,) arrays
        DN and metres.
    curve : callable
    reference : float
        d_ref, metres.

    Returns
    -------
    (n,) array
        DN at d_ref; NaN where `curve` is not known.
    """
    at_reference = curve(np.array([reference]))[0]
    return np.asarray(at_reference + (dn - curve(np.asarray(distance, float))))


def scale_to_reference(
    dn: Floats, distance: Floats, curve: Curve, reference: float, dn_reference: float
) -> Floats:
    """Equation 6: I_c = I · I(d_ref) / (f99(d) − c_ref) with c_ref = f99(d_ref) − I(d_ref).

    Parameters
    ----------
    dn, distance : (n,) arrays
        DN and metres.
    curve : callable
    reference : float
        d_ref, metres.
    dn_reference : float
        I(d_ref), DN of this very target at the reference range.

    Returns
    -------
    (n,) array
        DN at d_ref; NaN where `curve` is not known or the expected DN is 0.
    """
    shift = curve(np.array([reference]))[0] - dn_reference
    expected = curve(np.asarray(distance, float)) - shift
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(expected == 0, np.nan, dn * dn_reference / expected)

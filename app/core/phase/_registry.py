"""The models there are: one line each."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from app.core.errors import WrongUse
from app.core.phase import (
    cosine,
    fourier_2,
    incidence_b,
    lambert,
    lambert_beckmann,
    lommel_seeliger,
    polynomial_4,
)
from app.core.phase.model import PhaseModel

MODELS: Mapping[str, PhaseModel] = MappingProxyType(
    {
        model.name: model
        for model in (
            lambert.MODEL,
            lambert_beckmann.MODEL,
            lommel_seeliger.MODEL,
            incidence_b.MODEL,
            cosine.MODEL,
            fourier_2.MODEL,
            polynomial_4.MODEL,
        )
    }
)


def get_model(name: str) -> PhaseModel:
    """The model of that name; raises `WrongUse` with the names there are."""
    try:
        return MODELS[name]
    except KeyError:
        known = ", ".join(MODELS)
        raise WrongUse(f"There is no model {name!r}.", f"Models: {known}.") from None

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


def choose_model(model: PhaseModel | str) -> PhaseModel:
    """The model itself, or the one of that name.

    Raises
    ------
    WrongUse
        There is none of that name, or it is a formula, which has no columns to solve for.
    """
    if isinstance(model, str):
        return get_model(model)
    if not isinstance(model, PhaseModel):
        raise WrongUse(
            "A formula model can be fitted to points or to bins, by least squares only.",
            "Choose a model of the list for anything else.",
        )
    return model


def get_model(name: str) -> PhaseModel:
    """The model of that name; raises `WrongUse` with the names there are."""
    try:
        return MODELS[name]
    except KeyError:
        known = ", ".join(MODELS)
        raise WrongUse(f"There is no model {name!r}.", f"Models: {known}.") from None

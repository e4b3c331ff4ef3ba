"""Junttila's parameters for five species, as the workflows take them."""

from __future__ import annotations

from app.core.errors import WrongUse
from app.core.phase import get_model
from app.core.workflows.chain import get_workflow

SAME_NM = 20.0
SOURCE = "Junttila et al. 2016, table 3"


def list_published() -> dict[str, dict[float, dict[str, float]]]:
    """Parameters b, k_d and m by species and wavelength, nm."""
    found: dict[str, dict[float, dict[str, float]]] = {}
    for model in ("incidence-b", "lambert-beckmann"):
        for reference in get_model(model).references:
            if "Junttila" not in reference.source:
                continue
            species, _, channel = reference.sample.partition(", ")
            nm = float(channel.split()[1])
            found.setdefault(species, {}).setdefault(nm, {}).update(reference.values)
    return found


def find_published(species: str, wavelength_nm: float | None, workflow: str) -> dict[str, float]:
    """A workflow's parameters of a species at the wavelength that is near.

    Raises
    ------
    WrongUse
        The species, the wavelength or the sample's own f is not in the paper.
    """
    chain, known = get_workflow(workflow), list_published()
    if species not in known:
        raise WrongUse(f"There are no published parameters of {species!r}.",
                       f"Species: {', '.join(known)}.")  # fmt: skip
    near = [nm for nm in known[species] if abs(nm - (wavelength_nm or 0.0)) <= SAME_NM]
    if not near:
        there = " and ".join(f"{nm:g}" for nm in known[species])
        whose = "unknown" if wavelength_nm is None else f"{wavelength_nm:g} nm"
        raise WrongUse(
            f"The published parameters of {species} are for {there} nm; this wavelength is {whose}."
        )
    values = known[species][near[0]]
    if "f" in chain.parameters:
        raise WrongUse("Subtraction needs the sample's own f: fit it, or give f=….")
    # b in WF3 belongs to the diffuse part, not to the whole that the published b describes.
    return {name: values[name] for name in chain.parameters if name not in chain.assumed}

"""What a surface sends back in each channel."""

from __future__ import annotations

from dataclasses import dataclass

from app.core.errors import WrongUse


@dataclass(frozen=True, slots=True)
class Sheen:
    """Reflectance of one channel: ρ at ω = 0, and a phase function for every other angle.

    Attributes
    ----------
    rho : float
        Reflectance factor at ω = 0; 1 is a white Lambertian surface.
    model : str
        A phase function of `app.core.phase`; its own value at ω = 0 is divided out.
    parameters : tuple of (str, float)
        Those of the model that shape it; one that only scales it may be left out.
    """

    rho: float
    model: str = "lambert"
    parameters: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        if not 0 <= self.rho < 100:
            raise WrongUse(
                f"A surface cannot have a reflectance of {self.rho:g}.",
                "Give a share, 0 to about 1 (1 is a white matt panel).",
            )


Material = tuple[Sheen, ...]
"""One `Sheen` per channel, in the order of the scene's wavelengths."""


def matt(rho: float) -> Sheen:
    """A Lambertian surface."""
    return Sheen(rho)


def glossy(rho: float, k_d: float, m: float) -> Sheen:
    """A Lambert–Beckmann surface (science: Kaasalainen 2018, section 2.1)."""
    return Sheen(rho, "lambert-beckmann", (("k_d", k_d), ("m", m)))

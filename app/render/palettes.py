"""Named colour maps: tables of 256 colours, the same on the screen, in pictures and legends."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from app.core.arrays import AnyArray, Floats, read_only
from app.core.errors import WrongUse

Bytes = npt.NDArray[np.uint8]
Rgb = tuple[int, int, int]
Background = Literal["light", "dark"]
PaletteKind = Literal["sequential", "diverging", "flag", "categorical"]

PALETTES: Mapping[PaletteKind, tuple[str, ...]] = {
    "sequential": ("cividis", "viridis", "batlow", "grey"),
    "diverging": ("delta-omega", "residual", "vik"),
    "flag": ("flag",),
    "categorical": ("leaves", "verdict", "marks"),
}
# Δω after Balduzzi: negative (towards facing the beam) yellow and red, zero green, positive
# (towards edge-on) blue and purple. Lightness falls to both sides, so it also reads in grey.
DELTA_OMEGA = ("#8c1018", "#d73027", "#f99b3c", "#f7dc50", "#4fb463", "#3e8fc4", "#4a58b0",
               "#6a3796", "#401259")  # fmt: skip
DELTA_OMEGA_AT = (0.0, 0.14, 0.28, 0.40, 0.50, 0.62, 0.74, 0.87, 1.0)
# Blue below, sand at zero, brown above: sand vanishes on no background, where white would.
RESIDUAL = ("#1d4a94", "#2a6cb8", "#5f9bcf", "#b9a96c", "#d9803a", "#b8481f", "#8c2014")
FLAG = ("#56b4e9", "#d55e00")
VERDICT = (*FLAG, "#f0e442")  # no, yes, unsure
# Good, no signal, dark, saturated, beyond the ranges, beyond the response, partial hit.
MARKS = ("#009e73", "#0072b2", "#882255", "#f0e442", "#56b4e9", "#cc79a7", "#d55e00")
# Okabe and Ito without black, and Tol's wine: eight that all kinds of colour vision tell apart.
LEAVES = ("#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7", "#882255")
BACKGROUNDS: Mapping[Background, tuple[Rgb, Rgb]] = {
    "light": ((250, 251, 252), (226, 231, 236)),
    "dark": ((38, 43, 50), (19, 22, 27)),
}
MISSING: Mapping[Background, Rgb] = {"light": (176, 181, 187), "dark": (86, 92, 100)}
PLAIN: Mapping[Background, Rgb] = {"light": (73, 96, 116), "dark": (178, 195, 208)}


def list_palettes() -> tuple[str, ...]:
    """Names of all colour maps."""
    return tuple(name for names in PALETTES.values() for name in names)


def is_categorical(name: str) -> bool:
    """Whether a map gives one colour per whole number instead of a range."""
    return name in PALETTES["categorical"]


@cache
def colour_table(name: str) -> Bytes:
    """The colours of a map.

    Parameters
    ----------
    name : str
        One of `list_palettes`.

    Returns
    -------
    (256, 4) uint8, read-only
        RGBA from the low to the high limit; for a categorical map the colour of number i.

    Raises
    ------
    WrongUse
        There is no such map.
    """
    match name:
        case "delta-omega":
            table = _blend(DELTA_OMEGA, DELTA_OMEGA_AT)
        case "residual":
            table = _blend(RESIDUAL, tuple(np.linspace(0.0, 1.0, len(RESIDUAL)).tolist()))
        case "flag":
            table = np.repeat([_rgba(colour) for colour in FLAG], 128, axis=0)
        case "leaves":
            # Leaves are numbered from one.
            table = np.array([_rgba(LEAVES[(i - 1) % len(LEAVES)]) for i in range(256)])
        case "verdict":
            table = np.array([_rgba(VERDICT[min(i, 2)]) for i in range(256)])
        case "marks":
            table = np.array([_rgba(MARKS[min(i, len(MARKS) - 1)]) for i in range(256)])
        case "cividis" | "viridis" | "batlow" | "vik":
            table = _published(name)
        case "grey":
            # Neither end may vanish in a light or a dark background.
            table = _blend(("#1c1c1c", "#e4e4e4"), (0.0, 1.0))
        case _:
            known = ", ".join(list_palettes())
            raise WrongUse(f"There is no colour map {name}; there are: {known}.")
    return read_only(table.astype(np.uint8))


def colours(
    values: AnyArray,
    low: float,
    high: float,
    name: str,
    missing: Rgb = MISSING["light"],
) -> Bytes:
    """Colours of values, by the same rule as on the screen.

    Parameters
    ----------
    values : (n,) array
    low, high : float
        Limits; values beyond take the colour of the limit.
    name : str
        Colour map.
    missing : (r, g, b)
        Colour of NaN.

    Returns
    -------
    (n, 4) uint8
    """
    numbers = np.asarray(values, dtype=np.float64)
    known = np.isfinite(numbers)
    index = np.zeros(len(numbers), np.int64)
    index[known] = table_rows(numbers[known], low, high, is_categorical(name))
    found: Bytes = colour_table(name)[index]
    found[~known] = (*missing, 255)
    return found


def table_rows(values: Floats, low: float, high: float, categorical: bool) -> AnyArray:
    """Rows of the colour table for finite values; the shader holds the same formula."""
    if categorical:
        return np.mod(np.floor(values + 0.5), 256).astype(np.int64)
    span = max(high - low, 1e-30)
    share = np.clip((values - low) / span, 0.0, 1.0)
    return np.floor(share * 255.0 + 0.5).astype(np.int64)


def parse_rgb(colour: str) -> Rgb:
    """``#rrggbb`` as three numbers."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def _rgba(colour: str) -> tuple[int, int, int, int]:
    return (*parse_rgb(colour), 255)


def _blend(stops: tuple[str, ...], at: tuple[float, ...]) -> AnyArray:
    """Blend in linear light: mixing the coded numbers would give muddy middles."""
    coded = np.array([parse_rgb(stop) for stop in stops]) / 255.0
    where = np.linspace(0.0, 1.0, 256)
    mixed = np.stack([np.interp(where, at, coded[:, i] ** 2.2) for i in range(3)], axis=1)
    opaque = np.full((256, 1), 255.0)
    return np.round(np.hstack((255.0 * mixed ** (1 / 2.2), opaque)))


def _published(name: str) -> AnyArray:
    from cmap import Colormap

    found: Any = Colormap(name)(np.linspace(0.0, 1.0, 256))
    return np.round(np.asarray(found) * 255.0)

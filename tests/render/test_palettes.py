from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.radiometry.marks import WORDS
from app.core.workflows.marks import WORDS as CORRECTED
from app.render.legend import ANSWERS
from app.render.palettes import (
    BACKGROUNDS,
    MISSING,
    PALETTES,
    colour_table,
    colours,
    list_palettes,
)


@pytest.mark.parametrize("name", list_palettes())
def test_every_map_is_a_full_opaque_table(name: str) -> None:
    table = colour_table(name)
    assert table.shape == (256, 4)
    assert table.dtype == np.uint8
    assert (table[:, 3] == 255).all()
    with pytest.raises(ValueError, match="read-only"):
        table[0] = 0


def test_unknown_map_names_the_known_ones() -> None:
    with pytest.raises(WrongUse, match="cividis"):
        colour_table("jet")


def lightness(rgb: np.ndarray) -> np.ndarray:
    """CIE L* from coded sRGB."""
    coded = rgb[..., :3] / 255.0
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    y = linear @ np.array([0.2126, 0.7152, 0.0722])
    return np.where(y > 0.008856, 116 * np.cbrt(y) - 16, 903.3 * y)


@pytest.mark.parametrize("name", PALETTES["sequential"])
def test_sequential_maps_grow_lighter(name: str) -> None:
    steps = np.diff(lightness(colour_table(name)[::8].astype(float)))
    assert (steps > 0).all()


def test_delta_omega_is_green_at_zero_red_below_and_purple_above() -> None:
    low, zero, high = colours(np.array([-30.0, 0.0, 30.0]), -30, 30, "delta-omega").astype(int)
    assert low[0] > 2 * max(low[1], low[2])
    assert zero[1] > 1.5 * zero[0]
    assert zero[1] > 1.5 * zero[2]
    assert high[2] > high[0] > high[1]


def test_a_residual_of_zero_is_the_lightest_and_seen_on_every_background() -> None:
    table = colour_table("residual")[::5].astype(float)
    middle = int(np.argmax(lightness(table)))
    assert abs(middle - len(table) // 2) <= 1
    zero = colours(np.zeros(1), -1.0, 1.0, "residual")[0, :3].astype(float)
    for ground in (*BACKGROUNDS["light"], *BACKGROUNDS["dark"], *MISSING.values()):
        assert np.abs(zero - ground).max() > 30
    low, high = (colours(np.array([x]), -1.0, 1.0, "residual")[0].astype(int) for x in (-0.5, 0.5))
    assert low[2] > low[0] + 60
    assert high[0] > high[2] + 60


def test_values_beyond_the_limits_and_nan() -> None:
    found = colours(np.array([-5.0, 0.0, 1.0, 9.0, np.nan]), 0, 1, "viridis", (1, 2, 3))
    table = colour_table("viridis")
    assert (found[:2] == table[0]).all()
    assert (found[2:4] == table[255]).all()
    assert tuple(found[4]) == (1, 2, 3, 255)


def test_leaves_differ_from_their_neighbours() -> None:
    numbers = np.arange(1.0, 30.0)
    found = colours(numbers, 0, 1, "leaves").astype(int)
    assert (np.abs(np.diff(found, axis=0)).sum(axis=1) > 60).all()
    assert (found[0] == found[8]).all()


@pytest.mark.parametrize("background", ["light", "dark"])
def test_missing_values_are_seen_on_the_background(background: str) -> None:
    missing = lightness(np.array(MISSING[background], float))
    for colour in BACKGROUNDS[background]:
        assert abs(missing - lightness(np.array(colour, float))) > 15


def test_every_mark_has_a_colour_and_words() -> None:
    assert [row for row, _ in ANSWERS["mark"]] == list(range(len(WORDS)))
    assert [row for row, _ in ANSWERS["correction"]] == list(range(len(CORRECTED)))
    found = colours(np.arange(float(len(WORDS))), 0, 6, "marks").tolist()
    assert len({tuple(colour) for colour in found}) == len(WORDS)


def test_a_verdict_has_a_colour_per_answer() -> None:
    no, yes, unsure = colours(np.array([0.0, 1.0, 2.0]), 0, 2, "verdict").tolist()
    flag = colour_table("flag").tolist()
    assert (no, yes) == (flag[0], flag[255])
    assert unsure not in (no, yes)

"""Formulas over nm: the nearest channel, its distance, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.channel_index import choose_index
from app.core.errors import MissingChannel, WrongUse
from app.core.formula_wavelengths import resolve_formula
from app.core.indices import NAMED, evaluate

CHANNELS = {"reflectance_1064": 1064.0, "reflectance_1550": 1550.0, "raw": 1063.0, "red": None}
NDI = "(r1063 - r1545) / (r1063 + r1545)"


def test_a_wavelength_takes_the_nearest_channel_and_says_how_near() -> None:
    found = resolve_formula(NDI, CHANNELS)
    assert found.reads == {"r1063": "reflectance_1064", "r1545": "reflectance_1550"}
    assert [pick.distance_nm for pick in found.picks] == [1.0, 5.0]
    far = resolve_formula("i690 + 1", CHANNELS).picks[0]
    assert far.channel == "reflectance_1064"  # before the raw one of the same laser
    assert "far from what was asked" in far.words
    assert resolve_formula("r564_3", {"a": 564.3}).picks[0].distance_nm == 0.0


def test_its_values_are_those_of_the_named_index() -> None:
    random = np.random.default_rng(1)
    values = {name: random.uniform(-0.1, 1.0, 200) for name in CHANNELS}
    pair = {"r1063": values["reflectance_1064"], "r1545": values["reflectance_1550"]}
    found = resolve_formula(NDI, CHANNELS).evaluate(values)
    named = evaluate(NAMED["ndi"], pair)
    known = np.isfinite(named)
    np.testing.assert_allclose(found[known], named[known], rtol=1e-12)


def test_a_channel_of_such_a_name_is_meant_itself() -> None:
    found = resolve_formula("r1063 * raw", {"r1063": None, **CHANNELS}, ["raw"])
    assert found.picks == ()
    assert found.reads == {"r1063": "r1063", "raw": "raw"}


@pytest.mark.parametrize(
    ("text", "channels", "error", "says"),
    [
        ("r1063 / r1545", {"a": 905.0}, WrongUse, "both nearest to a"),
        ("r1063", {"a": None}, MissingChannel, "no channel says its wavelength"),
        ("nir / 2", CHANNELS, MissingChannel, "nir"),
        ("r1063.__class__", CHANNELS, WrongUse, "a dot"),
        ("__import__('os')", CHANNELS, WrongUse, "not allowed"),
        ("r99999 + 1", CHANNELS, MissingChannel, "r99999"),
        ("r1063 +" * 200, CHANNELS, WrongUse, "characters"),
        ("2 + 2", CHANNELS, WrongUse, "no channel"),
    ],
)
def test_what_is_refused(
    text: str, channels: dict[str, float | None], error: type, says: str
) -> None:
    with pytest.raises(error, match=says):
        resolve_formula(text, channels)


@pytest.mark.parametrize("text", ["ndi", NDI, "log(r1063) - r1545 ** 2"])
def test_errors_are_propagated_as_monte_carlo_finds(text: str) -> None:
    index = choose_index(text, CHANNELS)
    random = np.random.default_rng(4)
    centre, table = np.array([0.5, 0.3]), np.array([[4e-5, 1e-5], [1e-5, 2e-5]])
    drawn = random.multivariate_normal(centre, table, 100_000).T
    spread = index.evaluate(dict(zip(index.channels, drawn, strict=True))).std()
    at = {name: np.array([value]) for name, value in zip(index.channels, centre, strict=True)}
    np.testing.assert_allclose(index.propagate(at, table[:, :, None]), spread, rtol=0.02)

"""Named materials: their knots, and how water changes them."""

import msgspec
import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.core.phase import get_model
from app.simulate.spectra import Spectrum, get_spectrum, list_materials, optics_at

EXPECTED = {"bark", "black_cloth", "dry_leaf", "ground", "leaf", "needle", "wall"}


def test_materials_are_the_promised_ones():
    assert set(list_materials()) == EXPECTED


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_every_material_is_whole_and_physical(name):
    spectrum = get_spectrum(name)
    assert spectrum.title
    assert spectrum.source
    assert spectrum.wavelengths_nm[0] <= 500
    assert spectrum.wavelengths_nm[-1] >= 1650
    assert all(0 < rho < 1 for rho in spectrum.rho)
    model = get_model(spectrum.model)
    shaping = {p.name: p for p in model.parameters if not p.scales}
    assert spectrum.parameters.keys() == shaping.keys()
    for key, values in spectrum.parameters.items():
        assert all(shaping[key].lower <= v <= shaping[key].upper for v in values)


def test_fresh_leaf_has_the_numbers_of_the_demo_and_of_kaasalainen():
    leaf = optics_at("leaf", np.array([1063.0, 1545.0, 564.3, 659.9]))
    np.testing.assert_array_equal(leaf.rho[:2], [0.48, 0.27])
    np.testing.assert_array_equal(leaf.parameters["k_d"][:2], [0.88, 0.72])
    np.testing.assert_array_equal(leaf.parameters["m"][:2], [0.22, 0.30])
    np.testing.assert_allclose(leaf.parameters["k_d"][2:], 0.45, atol=0.05)
    np.testing.assert_allclose(leaf.parameters["m"][2:], 0.30, atol=0.03)


def test_values_lie_on_straight_lines_between_knots():
    spectrum = get_spectrum("bark")
    a, b = spectrum.wavelengths_nm[3:5]
    middle = optics_at("bark", np.array([(a + b) / 2])).rho[0]
    assert middle == pytest.approx(sum(spectrum.rho[3:5]) / 2)


def test_water_moves_log_reflectance_in_a_straight_line_from_dry_to_fresh():
    nm = np.array([690.0, 1063.0, 1545.0])
    rows = [np.log(optics_at("leaf", nm, water).rho) for water in (0.0, 0.5, 1.0, 1.5)]
    np.testing.assert_allclose(rows[0], np.log(optics_at("dry_leaf", nm).rho))
    np.testing.assert_allclose(np.diff(rows, axis=0), np.tile(rows[1] - rows[0], (3, 1)))
    drop = rows[0] - rows[2]
    assert drop[2] > 5 * abs(drop[1])


def test_material_without_a_dry_twin_does_not_dry():
    nm = np.array([1063.0])
    np.testing.assert_array_equal(optics_at("wall", nm, 0.2).rho, optics_at("wall", nm).rho)


@pytest.mark.parametrize("nm", [350.0, 1700.0, float("inf")])
def test_wavelengths_outside_the_knots_are_refused(nm):
    with pytest.raises(BadInput, match="leaf is known from 500 to 1650 nm"):
        optics_at("leaf", np.array([1063.0, nm]))


def test_unknown_materials_and_impossible_water_are_refused():
    with pytest.raises(BadInput, match="black_cloth"):
        get_spectrum("../scenes/leaf")
    with pytest.raises(WrongUse, match="water"):
        optics_at("leaf", np.array([1063.0]), 1.6)


@pytest.mark.parametrize(
    "change",
    [{"wavelengths_nm": [600, 500]}, {"rho": [0.1]}, {"parameters": {"m": [0.1]}}, {"colour": 1}],
)
def test_damaged_material_files_are_refused(change):
    table = {"title": "t", "source": "s", "wavelengths_nm": [500, 600], "rho": [0.1, 0.2]}
    assert msgspec.convert(table, Spectrum).rho == (0.1, 0.2)
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(table | change, Spectrum)

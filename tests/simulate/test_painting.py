"""Materials as scene files write them."""

import msgspec
import pytest

from app.core.errors import BadInput, WrongUse
from app.simulate.branch import BARK, LEAF, MATT
from app.simulate.material import Sheen
from app.simulate.painting import AnyMaterial, brighten, material_at

NM = (1063.0, 1545.0)


def paint(value, wavelengths=NM, water=1.0):
    return material_at(msgspec.convert(value, AnyMaterial, strict=True), wavelengths, water)


def test_names_give_the_materials_of_the_demo():
    assert paint("leaf") == LEAF
    assert paint("bark") == BARK
    assert paint("wall") == MATT


def test_a_number_is_a_matt_surface_in_every_channel():
    assert paint(0.5, (532.0, 785.0, 1545.0)) == (Sheen(0.5),) * 3
    assert paint(1) == (Sheen(1.0),) * 2


def test_a_recipe_changes_what_it_says_and_no_more():
    leaf = paint({"like": "leaf", "rho": 0.5})
    assert [s.rho for s in leaf] == [0.5, 0.5]
    assert [s.parameters for s in leaf] == [s.parameters for s in LEAF]
    by_nm = paint({"like": "leaf", "rho": {"1545": 0.2, "1063": 0.6}}, (1063.0, 1304.0))
    assert [s.rho for s in by_nm] == pytest.approx([0.6, 0.4])
    rough = paint({"like": "leaf", "parameters": {"m": 0.4}})
    assert [dict(s.parameters) for s in rough] == [{"k_d": 0.88, "m": 0.4}, {"k_d": 0.72, "m": 0.4}]


def test_any_phase_function_can_be_named():
    junttila = {"rho": 0.4, "model": "incidence-b", "parameters": {"b": {"1000": 1.0, "2000": 2.0}}}
    values = [dict(s.parameters)["b"] for s in paint(junttila)]
    assert values == pytest.approx([1.063, 1.545])
    both = {"rho": 0.4, "model": "lommel-seeliger", "parameters": {"c": 0.3, "d": 0.1}}
    assert paint(both)[0].model == "lommel-seeliger"
    assert paint({"like": "leaf", "model": "lambert"})[0] == Sheen(0.48, "lambert")


def test_a_drying_recipe_changes_as_its_model_does():
    fresh, dry = paint("leaf"), paint("leaf", water=0.3)
    mine, dried = paint({"like": "leaf", "rho": 0.3}), paint({"like": "leaf", "rho": 0.3}, NM, 0.3)
    ratio = [b.rho / a.rho for a, b in zip(mine, dried, strict=True)]
    assert ratio == pytest.approx([b.rho / a.rho for a, b in zip(fresh, dry, strict=True)])
    assert ratio[1] > 1.3
    assert paint({"rho": 0.3}, NM, 0.3) == paint(0.3)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ({}, "neither"),
        ({"like": "leef"}, "no material 'leef'"),
        ({"rho": 0.5, "model": "lambert-beckmann", "parameters": {"m": 0.2}}, "needs .* k_d"),
        ({"rho": 0.5, "model": "lommel-seeliger", "parameters": {"c": 0.2}}, "needs .* d"),
        ({"like": "leaf", "parameters": {"k": 0.2}}, "no parameter 'k'"),
        ({"like": "leaf", "parameters": {"k_d": 1.2}}, "between 0 and 1"),
        ({"rho": {"1063": 0.5}}, "1545 nm"),
        ({"rho": {"green": 0.5}}, "no number"),
        ({"rho": {}}, "no wavelength"),
    ],
)
def test_incomplete_recipes_are_refused_in_words(value, words):
    with pytest.raises(BadInput, match=words):
        paint(value)


def test_unknown_phase_function_is_refused():
    with pytest.raises(WrongUse, match="phong"):
        paint({"rho": 0.5, "model": "phong"})


@pytest.mark.parametrize("value", [-0.1, 3.0, {"rho": -1}, {"colour": 1}, True, [0.5]])
def test_values_out_of_range_are_refused_when_read(value):
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(value, AnyMaterial, strict=True)


def test_brighten_scales_every_channel():
    assert [s.rho for s in brighten(LEAF, 0.5)] == [0.24, 0.135]

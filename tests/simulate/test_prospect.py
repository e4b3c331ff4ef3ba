"""Materials by PROSPECT, with and without the optional package."""

import importlib.util
import sys
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from app.core.errors import BadInput
from app.simulate.painting import AnyMaterial, material_at
from app.simulate.prospect import Prospect

LEAF = {"N": 1.5, "Cab": 40, "Car": 8, "EWT": 0.012, "LMA": 0.006}


def paint(nm, water=1.0):
    return material_at(msgspec.convert({"prospect": LEAF}, AnyMaterial), nm, water)


def test_without_the_package_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "prosail", None)
    with pytest.raises(BadInput, match=r"pip install 'leafscope\[prospect\]'"):
        paint((1063.0, 1545.0))


def test_arguments_arrive_in_their_order_and_units(monkeypatch):
    seen = []

    def run_prospect(*leaf, prospect_version):
        seen.append((leaf, prospect_version))
        nm = np.arange(400, 2501)
        return nm, nm / 2500.0, 0 * nm

    monkeypatch.setitem(sys.modules, "prosail", SimpleNamespace(run_prospect=run_prospect))
    near, short = paint((1000.0, 1500.0), water=0.5)
    assert seen == [((1.5, 40, 8, 0.0, 0.006, 0.006), "5")]
    assert (near.rho, short.rho) == pytest.approx((0.4, 0.6))
    assert near.model == "lambert-beckmann"


@pytest.mark.skipif(importlib.util.find_spec("prosail") is None, reason="prosail is not installed")
def test_water_darkens_1545_nm_and_leaves_785_nm():
    wet, dry = (paint((785.0, 1545.0), water) for water in (1.0, 0.2))
    assert wet[0].rho == pytest.approx(dry[0].rho, rel=0.01)
    assert 0.2 < wet[1].rho < 0.8 * dry[1].rho


@pytest.mark.parametrize("change", [{"EWT": 120}, {"LMA": 60}, {"N": 0.5}, {"Cab": -1}, {"cm": 1}])
def test_units_and_domains_are_checked(change):
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(LEAF | change, Prospect)

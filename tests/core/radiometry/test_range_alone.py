"""The range effect alone: the curve of one panel or several, and equation 7."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.radiometry import chain as chains
from app.core.radiometry.calibration import Wishes, calibrate, make_channel
from app.core.radiometry.models import choose_model
from app.core.radiometry.panels import PanelTable, make_table
from app.core.radiometry.range_shift import shift_to_reference
from app.core.radiometry.residuals import gather_evidence, score_materials

AWAY = np.array([0.35, 0.45, 0.6, 0.75, 0.8, 1.15, 1.85, 2.15, 2.6, 3.56, 5.0, 7.5, 10.0])
F99 = 1781.45 + np.array([-610.0, -480, -350, -260, -230, -120, 40, 62, 51, 0, -140, -330, -480])
SHIFTS = {"83 %": 30.24, "80 %": 27.84, "68 %": 79.07, "48 %": 169.55, "22 %": 399.3, "3 %": 884.93}
"""Science 1.2: below the 99 % panel, DN."""
REFERENCE = Wishes(reference_range=3.56)


def panels(names: dict[str, float], noise: float = 0.0) -> PanelTable:
    random = np.random.default_rng(4)
    away = np.tile(AWAY, len(names))
    dn = np.concatenate([F99 - shift for shift in names.values()])
    dn = dn + noise * random.standard_normal(len(dn))
    told = np.repeat([float(name.split()[0]) / 100 for name in names], len(AWAY))
    return make_table(away, dn, told, 785.0, panel=np.repeat(list(names), len(AWAY)))


WHITE = {"99 %": 0.0}


@pytest.mark.parametrize("model", ["polynomial", "spline"])
def test_other_materials_are_corrected_as_by_equation_7(model: str) -> None:
    found = calibrate(panels(WHITE), choose_model(model), REFERENCE)
    channel = make_channel(found)
    assert (channel.name, channel.kind, len(channel.steps)) == ("corrected_785", "DN", 1)
    assert (channel.nearest, channel.farthest) == (0.35, 10.0)
    for shift in SHIFTS.values():
        dn = F99 - shift
        expected = shift_to_reference(dn, AWAY, lambda away: np.interp(away, AWAY, F99), 3.56)
        assert chains.invert(channel.steps, dn, AWAY) == pytest.approx(expected, abs=1e-6)
        assert expected == pytest.approx(np.full(len(AWAY), 1781.45 - shift))
    between = chains.invert(channel.steps, np.array([1500.0]), np.array([4.28]))
    if model == "polynomial":
        assert between == pytest.approx([1500.0 + 70.0])
    assert (channel.noise, channel.fit_covariance) == (None, ())


def test_several_panels_tell_the_noise_and_one_covariance() -> None:
    table = panels({**WHITE, **SHIFTS}, noise=3.0)
    found = calibrate(table, choose_model("polynomial"), REFERENCE)
    assert found.fit.noise is not None
    assert found.fit.noise.sigma(np.array(1500.0)) == pytest.approx(3.0, rel=0.3)
    channel = make_channel(found, gather_evidence(found, score_materials(found)))
    assert np.shape(channel.fit_covariance) == (len(channel.free), len(channel.free))
    sigma = np.sqrt(np.diag(channel.fit_covariance))
    levels = dict(zip(channel.free, channel.steps[0].values(), strict=True))
    for name, level, sure in zip(levels, levels.values(), sigma, strict=True):
        away = float(name[2:-3])
        assert level == pytest.approx(F99[away == AWAY][0] - 1781.45, abs=5 * sure)
    assert channel.evidence is not None
    assert channel.evidence.rmse == pytest.approx(3.0, rel=0.3)
    assert channel.evidence.left_out_rmse == pytest.approx(3.0, rel=0.5)


def test_the_covariance_is_that_of_the_scatter() -> None:
    away = np.array([2.0, 4.0, 8.0])
    sigma = np.array([3.0, 4.0, 5.0])
    table = make_table(away, np.array([900.0, 800, 600]), np.full(3, 0.5), 785.0, dn_sigma=sigma)
    channel = make_channel(calibrate(table, choose_model("spline"), Wishes(reference_range=4.0)))
    assert np.array(channel.fit_covariance) == pytest.approx(
        np.array([[9.0 + 16.0, 16.0], [16.0, 25.0 + 16.0]])
    )


def test_breaks_smooth_the_curve_of_one_panel() -> None:
    wishes = Wishes(reference_range=3.56, breaks=(0.8, 1.85))
    found = calibrate(panels(WHITE, noise=3.0), choose_model("polynomial"), wishes)
    assert found.fit.freedom == len(AWAY) - 5
    assert found.fit.noise is not None


def test_panels_that_share_no_range_are_refused() -> None:
    away = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    names = ["a"] * 3 + ["b"] * 3
    rho = np.repeat([0.5, 0.9], 3)
    table = make_table(away, 1000.0 - 20 * away, rho, 785.0, panel=names)
    with pytest.raises(BadInput):
        calibrate(table, choose_model("polynomial"), Wishes(breaks=(1.0, 2.0, 3.0, 4.0, 5.0)))

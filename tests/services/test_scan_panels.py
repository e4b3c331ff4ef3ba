"""Panels drawn in scans become a table, and a calibration whose noise is that of points."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.radiometry.calibration import Wishes
from app.core.radiometry.models import choose_model
from app.model.project import Project
from app.model.scan import Channel, Pose, Scan
from app.services.calibrate import Naming
from app.services.opening import add_scans
from app.services.scan_panels import (
    KnownPanel,
    calibrate_panels,
    guess_reflectance,
    scale_of,
    see_panels,
    tabulate,
)

A0, A1, NOISE, SATURATED = 1200.0, 2200.0, 20.0, 2033.0
RHOS = (0.99, 0.5, 0.25, 0.12)
EACH = 4000
LOG = choose_model("log")


def make_scan(distance: float = 4.0, seed: int = 1, name: str = "panels.csv") -> Scan:
    """Panels beside one another on a board that faces the scanner."""
    chance = np.random.default_rng(seed)
    place = np.repeat(np.arange(len(RHOS)), EACH)
    y = (place - 1.5) * 0.2 + chance.uniform(-0.08, 0.08, len(place))
    z = chance.uniform(-0.08, 0.08, len(place))
    light = np.array(RHOS)[place] * (4.0 / distance) ** 2
    dn = A1 + A0 * np.log10(light) + chance.normal(0.0, NOISE, len(place))
    xyz = np.column_stack((np.full(len(place), distance), y, z))
    return Scan(
        name,
        xyz,
        {"intensity": np.minimum(dn, SATURATED), "place": place.astype(float)},
        (Channel("intensity", "intensity", 1550.0, "DN"),),
        Pose((0.0, 0.0, 0.0), known_by="given"),
        metadata={"instrument": "simulated: FARO X330"},
    )


def panels_of(project: Project, key: str, rhos=RHOS) -> list[KnownPanel]:
    place = project.state.scan(key).scan.attributes["place"]
    return [
        KnownPanel(key, f"{100 * rho:g} %", np.flatnonzero(place == RHOS.index(rho)), rho)
        for rho in rhos
    ]


@pytest.fixture
def opened() -> tuple[Project, str]:
    project = Project()
    (key,) = add_scans(project, [make_scan()])
    return project, key


def test_a_table_holds_means_with_their_errors_and_leaves_saturated_panels_out(opened) -> None:
    project, key = opened
    seen = see_panels(project, panels_of(project, key), "intensity", SATURATED)
    assert [each.usable for each in seen] == [False, True, True, True]
    assert seen[0].saturated > 0.99
    table = tabulate(project, seen, "intensity", 1550.0)
    assert table.panels == ("50 %", "25 %", "12 %")
    assert table.scans == ("panels.csv",)
    expected = A1 + A0 * np.log10(table.reflectance)
    assert (np.abs(table.dn - expected) < 4 * NOISE / np.sqrt(EACH)).all()
    np.testing.assert_allclose(table.dn_sigma, NOISE / np.sqrt(EACH), rtol=0.06)
    assert ((table.distance > 4.0) & (table.distance < 4.02)).all()


def test_the_calibration_finds_the_response_and_the_noise_of_a_point(opened) -> None:
    project, key = opened
    wishes, naming = Wishes(saturated=SATURATED), Naming("board", "x330")
    report, seen = calibrate_panels(
        project, panels_of(project, key), ("intensity", 1550.0), LOG, wishes, naming
    )
    (channel,) = report.profile.channels
    assert (report.profile.name, report.profile.instrument) == ("board", "x330")
    assert len(seen) == 4
    response = channel.steps[-1]
    assert response.a0 == pytest.approx(A0, rel=0.005)
    assert response.a1 == pytest.approx(A1, abs=3.0)
    assert channel.noise.sigma(np.array([1500.0]))[0] == pytest.approx(NOISE, rel=0.05)
    ranges = project.field(key, "range")
    used = np.concatenate([each.panel.points for each in seen if each.usable])
    assert channel.nearest < ranges[used].min()
    assert channel.farthest > ranges[used].max()


def test_a_margin_widens_where_it_holds(opened) -> None:
    project, key = opened
    wanted, naming = ("intensity", 1550.0), Naming(margin=0.5)
    panels = panels_of(project, key, RHOS[1:])
    report, _ = calibrate_panels(project, panels, wanted, LOG, naming=naming)
    (channel,) = report.profile.channels
    plain, _ = calibrate_panels(project, panels, wanted, LOG)
    assert channel.nearest == pytest.approx(plain.profile.channels[0].nearest - 0.5)
    assert channel.farthest == pytest.approx(plain.profile.channels[0].farthest + 0.5)


def test_it_holds_for_the_points_of_panels_that_are_wider_than_their_mean() -> None:
    project, spread = Project(), make_scan()
    xyz = spread.xyz * np.tile(np.linspace(0.7, 1.3, EACH), len(RHOS))[:, None]
    (key,) = add_scans(project, [spread.with_xyz(xyz)])
    panels = panels_of(project, key, RHOS[1:])
    report, seen = calibrate_panels(project, panels, ("intensity", 1550.0), LOG)
    assert report.profile.channels[0].nearest == min(each.nearest for each in seen)
    assert report.profile.channels[0].farthest == max(each.farthest for each in seen)


def test_a_law_of_range_holds_at_any_range(opened) -> None:
    project, key = opened
    panels = panels_of(project, key, RHOS[1:])
    model = choose_model("log+inverse-square")
    report, _ = calibrate_panels(project, panels, ("intensity", 1550.0), model)
    assert report.profile.channels[0].nearest is None
    naming = Naming(any_range=True)
    report, _ = calibrate_panels(project, panels, ("intensity", 1550.0), LOG, naming=naming)
    assert report.profile.channels[0].farthest is None


def test_ghosts_far_off_a_panel_do_not_widen_it() -> None:
    scan = make_scan()
    xyz = scan.xyz.copy()
    xyz[np.flatnonzero(scan.attributes["place"] == 1)[:20]] *= 5.0
    project = Project()
    (key,) = add_scans(project, [scan.with_xyz(xyz)])
    seen = see_panels(project, panels_of(project, key, (0.5,)), "intensity")
    assert seen[0].farthest < 4.1


def test_panels_of_several_scans_tell_the_range_effect() -> None:
    project = Project()
    metres = (2.0, 3.0, 4.0, 6.0)
    scans = [make_scan(d, seed, f"at {d:g} m") for seed, d in enumerate(metres)]
    keys = add_scans(project, scans)
    panels = [each for key in keys for each in panels_of(project, key, RHOS[2:])]
    model = choose_model("log+inverse-square")
    report, seen = calibrate_panels(project, panels, ("intensity", 1550.0), model)
    (found,) = report.channels
    assert [each.usable for each in seen].count(False) == 1  # 25 % at 2 m: all of one number
    assert found.calibration.table.scans == tuple(scan.name for scan in scans)
    assert set(found.calibration.table.panels) == {"25 %", "12 %"}
    assert found.channel.steps[-1].a0 == pytest.approx(A0, rel=0.02)
    assert found.channel.evidence.rmse < 0.003


def test_scans_of_the_same_name_stay_apart() -> None:
    project = Project()
    keys = add_scans(project, [make_scan(3.0), make_scan(4.0)])
    panels = [each for key in keys for each in panels_of(project, key, (0.25,))]
    table = tabulate(project, see_panels(project, panels, "intensity"), "intensity", 1550.0)
    assert len(table.scans) == 2


def test_saturated_panels_alone_are_refused(opened) -> None:
    project, key = opened
    seen = see_panels(project, panels_of(project, key, (0.99,)), "intensity", SATURATED)
    with pytest.raises(BadInput, match="All 1 panels are saturated"):
        tabulate(project, seen, "intensity", 1550.0)
    with pytest.raises(BadInput, match="No panel has a reflectance"):
        tabulate(project, [], "intensity", 1550.0)


def test_names_tell_reflectances_and_instruments_their_scale() -> None:
    assert guess_reflectance("Grey 50 %") == 0.5
    assert guess_reflectance("12,5% card") == 0.125
    assert guess_reflectance("Leaf 3") is None
    assert scale_of(make_scan()) == (-2048, SATURATED)
    assert scale_of(Scan("a", np.zeros((1, 3)), {}, ())) == (None, None)

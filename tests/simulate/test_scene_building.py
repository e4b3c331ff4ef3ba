"""From scene files to surfaces, beams and scans."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.core.errors import BadInput, WrongUse
from app.simulate.beam import angles_of
from app.simulate.branch import MATT
from app.simulate.instrument import get_instrument
from app.simulate.leaf_table import tabulate_leaves
from app.simulate.scene_building import build_scene, fit_field, lay_grid
from app.simulate.scene_file import decode_scene, get_scene, list_scenes, load_document
from app.simulate.series import vary
from app.simulate.simulation import scan_scene
from app.simulate.surfaces import Scene, Wall

NM = (1063.0, 1545.0)
LEAF = {"kind": "leaf", "range": 3}
WALL = {"kind": "wall", "range": 5}
LEAVES = {"kind": "scatter", "count": 5}
FRAME = {"kind": "leaf_frame"}


def decode(*parts, **keys):
    return decode_scene({"name": "test", "part": list(parts)} | keys, "test.toml")


def build(*parts, **keys):
    return build_scene(decode(*parts, **keys), NM)


def test_same_file_same_scene_other_seed_other_scene():
    assert build(LEAVES, FRAME) == build(LEAVES, FRAME)
    assert build(LEAVES, FRAME).leaves != build(LEAVES, FRAME, seed=1).leaves


def test_a_part_more_changes_no_other():
    alone = build(LEAVES).leaves
    assert build(FRAME, LEAVES, LEAF).leaves[12:17] == alone
    twice = build(LEAVES, LEAVES | {"name": "more"}).leaves
    assert twice[:5] == alone
    assert twice[5:] != alone


def test_wind_and_hours_reach_the_leaves():
    still, windy = build(LEAVES), build(LEAVES, wind={"amplitude": 0.01})
    assert all(leaf.sway_rate == 0 for leaf in still.leaves)
    assert all(leaf.sway_rate > 0 for leaf in windy.leaves)
    assert [leaf.centre for leaf in windy.leaves] == [leaf.centre for leaf in still.leaves]
    assert all(leaf.water < 0.6 for leaf in build(LEAVES, hours=48).leaves)


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ({"kind": "leaf", "material": "leef"}, "no material 'leef'"),
        ({"kind": "leaf", "curvature": 30}, "cannot be bent"),
        ({"kind": "leaf", "wrinkle_height": 0.02}, "too steep"),
        ({"kind": "leaf", "centre": [0, 0, 1.6]}, "where the scanner is"),
        ({"kind": "leaf", "centre": [0, 0, 1.6], "normal": [1, 0, 0]}, "where the scanner is"),
        ({"kind": "leaf", "material": {"rho": {"500": 0.1}}}, "1063 nm"),
    ],
)
def test_what_cannot_be_built_names_its_part(part, words):
    with pytest.raises(BadInput, match=rf"test: part\.1 \(leaf\): .*{words}"):
        build(WALL, part)


def test_fitted_field_holds_the_leaf_and_its_margin_and_no_wall():
    scene = build({"kind": "leaf", "range": 3, "azimuth_deg": 30, "width": 0.1, "taper": 0}, WALL)
    azimuth, elevation = fit_field(scene, (0, 0, 1.6), 0.5)
    half = np.rad2deg(np.arctan(0.05 / 3))
    assert azimuth == pytest.approx((30 - half - 0.5, 30 + half + 0.5), abs=0.15)
    tall = np.rad2deg(np.arctan(0.0375 / 3))
    assert elevation == pytest.approx((-tall - 0.5, tall + 0.5), abs=0.1)


def test_field_behind_and_above_the_scanner():
    behind = build({"kind": "leaf", "azimuth_deg": 178}, {"kind": "leaf", "azimuth_deg": -178})
    azimuth, _ = fit_field(behind, (0, 0, 1.6), 0.0)
    assert azimuth[1] - azimuth[0] < 8
    above = build({"kind": "leaf", "centre": [0, 0, 3], "normal": [0, 0, 1]})
    azimuth, elevation = fit_field(above, (0, 0, 1.6), 0.0)
    assert azimuth == (-180, 180)
    assert elevation[1] > 87


LONG = {"kind": "stem", "start": [1, -3, 1], "end": [1, 3, 1]}
BOARD = {"kind": "panel", "size": 2, "range": 1}


@pytest.mark.parametrize(("part", "top"), [(LONG, 45.57), (BOARD, 45.0)])
def test_field_holds_the_middle_of_what_is_long(part, top):
    _, elevation = fit_field(build(part, position=[0, 0, 0]), (0, 0, 0), 0.0)
    assert elevation[1] == pytest.approx(top, abs=0.01)


@settings(max_examples=200)
@given(st.lists(st.tuples(*[st.floats(-4, 4)] * 6), min_size=1, max_size=3))
def test_fitted_field_holds_every_point_of_its_walls(numbers):
    # Upright or level boards along the axes fill two sides of their boxes.
    walls = tuple(
        Wall((x, y, z), (0, a, 0), (b, 0, 0) if level > 0 else (0, 0, b), MATT, name="board")
        for x, y, z, a, b, level in numbers
    )
    azimuth, elevation = fit_field(Scene("boards", walls=walls), (0, 0, 0), 0.0)
    place = np.linspace(-1, 1, 41)
    for wall in walls:
        across, up = (np.multiply.outer(place, edge) for edge in (wall.across, wall.up))
        points = (across[:, None] + up + wall.centre).reshape(-1, 3)
        points = points[np.hypot(points[:, 0], points[:, 1]) > 1e-9]
        rise, side = np.rad2deg(angles_of(points, np.zeros(3)))
        assert ((rise >= elevation[0] - 1e-9) & (rise <= elevation[1] + 1e-9)).all()
        assert ((side - azimuth[0] + 1e-9) % 360 <= azimuth[1] - azimuth[0] + 2e-9).all()


def test_a_scanner_inside_a_stem_is_refused():
    stem = {"kind": "stem", "start": [0, 0, 0], "end": [0, 0, 1.5], "radius": 0.2}
    for place in ([0.1, 0, 1.0], [0, 0.1, 1.6], [0, 0, -0.15]):
        with pytest.raises(BadInput, match=r"test: part\.1 \(stem\): .*inside a stem"):
            build(LEAF, stem, position=place)
    for place in ([0.21, 0, 1.0], [0, 0.18, 1.6], [0, 0, -0.21]):
        assert len(build(LEAF, stem, position=place).stems) == 1


def test_nothing_but_walls_has_no_fitted_field():
    with pytest.raises(BadInput, match="nothing but walls"):
        fit_field(build(WALL), (0, 0, 1.6), 0.5)


def test_panels_and_stages_are_fitted():
    azimuth, _ = fit_field(build({"kind": "panel", "size": 1.0, "range": 5}), (0, 0, 1.6), 0.0)
    assert azimuth == pytest.approx((-5.7106, 5.7106), abs=1e-3)


def test_grid_takes_the_field_and_the_step():
    field = {"azimuth_deg": [-2, 3], "elevation_deg": [-1, 1]}
    scene_file = decode(LEAF, field=field)
    grid = lay_grid(scene_file, build_scene(scene_file, NM), 0.5)
    assert (grid.rows, grid.columns) == (5, 11)
    assert np.rad2deg([grid.top, grid.left]) == pytest.approx([1, 3])


def test_too_many_beams_and_impossible_steps_are_refused():
    scene_file = decode(LEAF)
    scene = build_scene(scene_file, NM)
    with pytest.raises(BadInput, match="beams"):
        lay_grid(scene_file, scene, 1e-5)
    for step in (50.0, 0.0, -1.0, float("nan")):
        with pytest.raises(WrongUse, match="step"):
            lay_grid(scene_file, scene, step)


def scan(name, beams=15_000, document=None):
    """A ready scene with its own instrument, at a step that makes about `beams` beams."""
    scene_file = decode_scene(document or load_document(name), name)
    instrument = get_instrument(scene_file.instrument)
    scene = build_scene(scene_file, instrument.wavelengths_nm)
    fine = lay_grid(scene_file, scene, instrument.step_deg)
    step = instrument.step_deg * max(1.0, np.sqrt(fine.rows * fine.columns / beams))
    grid = lay_grid(scene_file, scene, step)
    made = scan_scene(scene, grid, instrument, scene_file.position, scene_file.seed)
    return made, tabulate_leaves(scene, scene_file.position)


SHARES = {  # of leaves seen, and of points on leaves
    "branch": (1.0, 0.15), "crown": (0.25, 0.5), "drying": (1.0, 0.04), "goniometer": (1.0, 0.03),
    "leaf": (1.0, 0.2), "leaf_frame": (1.0, 0.05), "leaf_row": (1.0, 0.2), "lobed_leaf": (1, 0.2),
    "needle_row": (0.9, 0.08), "panels": (0, 0), "pear_row": (0.6, 0.1), "shoot": (0.6, 0.05),
    "pulsed_leaves": (0.95, 0.2), "scattered": (0.8, 0.4), "wall_edge": (0, 0),
}  # fmt: skip


@pytest.mark.parametrize("name", list_scenes())
def test_ready_scenes_show_their_leaves_when_scanned(name):
    made, rows = scan(name)
    leaf = made.attributes["truth_leaf"]
    seen, share = SHARES[name]
    assert len(made) > 5000
    assert leaf.max() < max(len(rows), 1)
    assert len(np.unique(leaf[leaf >= 0])) >= seen * len(rows)
    assert (leaf >= 0).mean() >= share
    ghosts = (made.attributes["truth_ghost"] == 1).mean()
    assert ghosts < 0.2
    if name not in ("needle_row", "shoot"):  # their pulses are longer than all gaps
        assert ghosts > 0.0002


def test_goniometer_is_scanned_at_its_angle():
    document = vary(load_document("goniometer"), "stage.angle_deg", 50)
    made, (row,) = scan("goniometer", document=document)
    whole = (made.attributes["truth_leaf"] == 0) & (made.attributes["truth_hit_fraction"] > 0.999)
    assert whole.sum() > 50
    assert row.tilt_deg == pytest.approx(50)
    assert made.attributes["truth_incidence"][whole].mean() == pytest.approx(50, abs=1)


def test_leaves_look_drier_after_hours():
    index = []
    for hours in (0, 12, 77):
        made, _ = scan("drying", document=vary(load_document("drying"), "hours", hours))
        leaf = made.attributes["truth_leaf"] >= 0
        near, short = (np.median(made.channel_values(c.name)[leaf]) for c in made.channels)
        index.append((near - short) / (near + short))
    assert index[0] > 0.2
    assert index[0] > index[1] + 0.05 > index[2] + 0.05
    assert index[2] < 0.1


def test_points_of_a_leaf_cover_its_area():
    made, (row,) = scan("lobed_leaf", beams=10**9)
    step = get_instrument("two_colour").step_deg
    on = made.attributes["truth_leaf"] == 0
    assert get_scene("lobed_leaf").step_deg is None
    seen = on.sum() * (np.deg2rad(step) * 2.5) ** 2
    assert seen == pytest.approx(row.area, rel=0.05)


def test_wall_edge_lies_in_the_middle_and_its_ghosts_at_the_edge():
    made, _ = scan("wall_edge", beams=10**9)
    middle = made.grid.columns / 2
    off = np.abs(made.grid.column[made.attributes["truth_ghost"] == 1] - middle)
    assert len(off) > 100
    assert off.max() < 5
    distance = made.attributes["truth_range"]
    assert np.median(distance[made.grid.column < middle - 5]) == pytest.approx(3.0, abs=0.01)
    assert np.median(distance[made.grid.column > middle + 5]) == pytest.approx(3.4, abs=0.01)

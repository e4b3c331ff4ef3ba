"""The share of the beam on its surface, against analytic edges and both simulators' truth."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.core.neighbours.steps import Cells
from app.core.radiometry.partial_hits import (
    FULL_HIT,
    beam_rays,
    edge_places,
    hit_fraction,
)
from app.simulate.virtual_scan import find_instrument, simulate

STEP, SIDE = 3e-4, 60
BEAM = (0.0015, 2.4e-4)
HERE = np.zeros(3)


@dataclass
class Image:
    """Ranges by row and column, as points on a grid; NaN sends nothing back."""

    ranges: np.ndarray

    @property
    def kept(self) -> np.ndarray:
        return np.isfinite(self.ranges)

    @property
    def cells(self) -> Cells:
        row, column = np.nonzero(self.kept)
        return Cells(*self.ranges.shape, row.astype(np.int32), column.astype(np.int32))

    @property
    def xyz(self) -> np.ndarray:
        return (directions(self.ranges.shape) * self.ranges[..., None])[self.kept]

    def share(self, **options: object) -> np.ndarray:
        image = np.full(self.ranges.shape, np.nan)
        image[self.kept] = hit_fraction(self.xyz, HERE, self.cells, *BEAM, **options)
        return image


def directions(shape: tuple[int, int]) -> np.ndarray:
    row, column = np.mgrid[: shape[0], : shape[1]]
    rise, turn = (shape[0] / 2 - row) * STEP, (shape[1] / 2 - column) * STEP
    flat = np.cos(rise)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), np.sin(rise)], axis=-1)


def steep_plane(degrees: float, noise: float) -> np.ndarray:
    tilt = np.deg2rad(degrees)
    normal = np.array([np.cos(tilt), np.sin(tilt), 0.0])
    chance = np.random.default_rng(3)
    ranges = 3.0 * np.cos(tilt) / (directions((SIDE, SIDE)) @ normal)
    return ranges + noise * chance.standard_normal(ranges.shape)


def test_rays_and_edges_are_those_of_a_gaussian_beam_cut_at_its_radius() -> None:
    rays = beam_rays()
    assert rays[2].sum() == pytest.approx(1.0)
    assert np.hypot(rays[0], rays[1]).max() < 1.0
    chance = np.random.default_rng(0)
    x, y = chance.uniform(-1.0, 1.0, (2, 400_000))
    inside = np.hypot(x, y) <= 1.0
    energy = np.exp(-2.0 * (x**2 + y**2)) * inside
    for share in (0.1, 0.5, 0.8):
        edge = np.interp(share, np.linspace(0.0, 1.0, len(edge_places())), edge_places())
        assert energy[x > edge].sum() / energy.sum() == pytest.approx(share, abs=0.005)
        assert rays[2][rays[0] > edge].sum() == pytest.approx(share, abs=0.05)


@pytest.mark.parametrize("degrees", [0.0, 60.0, 80.0, 85.0])
@pytest.mark.parametrize("noise", [0.0, 0.0007])
def test_a_smooth_surface_is_hit_fully_however_steep(degrees: float, noise: float) -> None:
    share = Image(steep_plane(degrees, noise)).share()
    assert (share >= FULL_HIT).mean() > 0.995


def test_the_ground_at_grazing_angles_is_hit_fully() -> None:
    beams = directions((SIDE, SIDE))
    rise = np.arcsin(beams[..., 2])
    down = np.deg2rad(-6.0) + rise  # a scanner 1.5 m above the ground, looking 6° down
    assert (Image(1.5 / np.sin(-down)).share() == 1.0).all()


@pytest.mark.parametrize("upright", [True, False])
def test_a_straight_edge_between_two_surfaces(upright: bool) -> None:
    ranges = np.full((SIDE, SIDE), 2.0)
    ranges[:, SIDE // 2 :] = 2.3
    share = Image(ranges if upright else ranges.T).share()
    line = share[SIDE // 2] if upright else share[:, SIDE // 2]
    for own, places in ((2.0, range(SIDE // 2)), (2.3, range(SIDE // 2, SIDE))):
        radius = (BEAM[0] / own + np.tan(BEAM[1])) / STEP
        for k in places:
            # The edge lies anywhere between the two beams on its sides, evenly spread.
            ends = np.abs(k - (SIDE // 2 - 1 + np.linspace(0.0, 1.0, 101))) / radius
            beyond = np.interp(ends, edge_places()[::-1], np.linspace(1.0, 0.0, 65))
            assert line[k] == pytest.approx(1.0 - beyond.mean(), abs=0.03)
    assert (np.diff(line[: SIDE // 2]) <= 1e-9).all()
    assert line[10] == 1.0
    assert line[SIDE // 2 - 1] < 0.75


def test_a_near_surface_before_a_far_one_ends_before_its_last_points() -> None:
    ranges = np.full((SIDE, SIDE), 2.0)
    ranges[:, SIDE // 2 :] = 40.0
    share = Image(ranges).share()[SIDE // 2]
    assert share[SIDE // 2 - 1] < 0.3  # what is left of a leaf still outshines the wall
    assert share[SIDE // 2] > 0.9
    open_sky = np.where(ranges > 10.0, np.nan, ranges)
    assert Image(open_sky).share()[SIDE // 2, SIDE // 2 - 1] < 0.3


def test_mixed_ranges_at_an_edge_are_no_full_hits() -> None:
    ranges = np.full((SIDE, SIDE), 2.0)
    ranges[:, 30:] = 2.3
    chance = np.random.default_rng(1)
    ranges[:, 30] = chance.uniform(2.05, 2.25, SIDE)
    share = Image(ranges).share()
    assert (share[:, 30] < 0.8).all()
    assert (share[:, [29, 31]] < FULL_HIT).all()


def test_a_lone_dropout_and_the_border_are_no_edges_but_a_hole_is() -> None:
    ranges = np.full((SIDE, SIDE), 2.0)
    ranges[20, 20] = np.nan
    assert np.nanmin(Image(ranges).share()) == 1.0
    ranges[40:43, 40:43] = np.nan
    share = Image(ranges).share()
    assert (share[41, [38, 39, 43, 44]] < 0.9).all()
    assert (share[[0, -1]] == 1.0).all()
    assert (share[:, [0, -1]] == 1.0).all()


def test_beams_with_two_returns_are_partial_for_both() -> None:
    near = np.full((SIDE, SIDE), 2.0)
    near[:, 31:] = np.nan
    far = np.full((SIDE, SIDE), 5.0)
    far[:, :30] = np.nan
    one, two = Image(near), Image(far)
    xyz = np.vstack([one.xyz, two.xyz])
    cells = Cells(
        SIDE,
        SIDE,
        np.concatenate([one.cells.row, two.cells.row]),
        np.concatenate([one.cells.column, two.cells.column]),
    )
    share = hit_fraction(xyz, HERE, cells, *BEAM)
    both = cells.column == 30
    assert both.sum() == 2 * SIDE
    assert ((share[both] > 0.3) & (share[both] < 0.7)).all()
    assert (share[(cells.column < 25) | (cells.column > 35)] == 1.0).all()


@pytest.mark.parametrize("scene", ["scattered", "leaf_row", "panels"])
@pytest.mark.parametrize(
    ("tool", "precise", "found"),
    [("ls880", 0.94, 0.97), ("x330", 0.96, 0.97), ("salca", 0.9, 0.96)],
)
def test_full_hits_against_the_truth(scene: str, tool: str, precise: float, found: float) -> None:
    step = 0.035 if scene == "scattered" and tool != "salca" else None
    scan = simulate(scene, tool, seed=11, step_deg=step).scan
    bundle = find_instrument(tool).bundle
    assert scan.pose is not None
    place, truth = np.array(scan.pose.position), scan.attributes["truth_hit_fraction"]
    share = hit_fraction(
        scan.xyz, place, scan.grid, bundle.exit_diameter / 2, bundle.half_divergence
    )
    full, really = share >= FULL_HIT, truth >= 0.98
    assert (full & really).sum() / full.sum() > precise
    assert (full & really).sum() / really.sum() > found
    assert truth[full].mean() > 0.985
    if scene == "scattered" and tool != "salca":  # the mean truth of a bin lies near it
        for low, high in ((0.55, 0.7), (0.7, 0.85), (0.85, 0.97)):
            mine = (share >= low) & (share < high)
            assert truth[mine].mean() == pytest.approx(share[mine].mean(), abs=0.08)


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "precise", "found"), [("phase_shift", 0.975, 0.98), ("pulsed", 0.92, 0.95)]
)
def test_full_hits_of_another_simulator(
    shared_data: Path, name: str, precise: float, found: float
) -> None:
    from app.services.reading import read_file

    folder = shared_data / "truth_scenes"
    scan = read_file(folder / f"{name}.ptx")[0]
    truth = np.load(folder / f"{name}_truth.npz")["hit_fraction"]
    assert scan.pose is not None
    place = np.array(scan.pose.position)
    share = hit_fraction(scan.xyz, place, scan.grid, 0.0015, np.deg2rad(0.014))
    full, really = share >= FULL_HIT, truth >= 0.98
    assert (full & really).sum() / full.sum() > precise
    assert (full & really).sum() / really.sum() > found


def test_some_points_get_the_numbers_of_all() -> None:
    scan = simulate("scattered", "salca", seed=2, step_deg=0.06).scan
    assert scan.pose is not None
    place = np.array(scan.pose.position)
    every = hit_fraction(scan.xyz, place, scan.grid, 0.003, 2.9e-4)
    some = np.random.default_rng(5).integers(0, len(scan), 400)
    found = hit_fraction(scan.xyz, place, scan.grid, 0.003, 2.9e-4, some)
    assert np.array_equal(found, every[some])
    assert len(hit_fraction(scan.xyz, place, scan.grid, 0.003, 2.9e-4, some[:0])) == 0


def test_points_without_coordinates_have_no_share() -> None:
    image = Image(np.full((SIDE, SIDE), 2.0))
    xyz = image.xyz.copy()
    xyz[7] = np.nan
    share = hit_fraction(xyz, HERE, image.cells, *BEAM)
    assert np.isnan(share[7])
    assert np.isfinite(np.delete(share, 7)).all()


def test_a_seam_is_no_border() -> None:
    columns = round(2 * np.pi / 0.01)
    row, column = (a.ravel().astype(np.int32) for a in np.mgrid[:40, :columns])
    rise, turn = (20 - row) * 0.01, -column * (2 * np.pi / columns)
    flat = np.cos(rise)
    beams = np.stack([flat * np.cos(turn), flat * np.sin(turn), np.sin(rise)], axis=1)
    ranges = np.where((column == 0) | (column > columns - 30), 2.0, 3.0)
    share = hit_fraction(
        beams * ranges[:, None], HERE, Cells(40, columns, row, column), 0.03, 0.0
    ).reshape(40, columns)
    assert (share[10:30, columns - 1] < 1.0).all()  # one beam beyond the seam, then the edge
    assert (share[10:30, columns - 15] == 1.0).all()


def test_what_cannot_be_told_is_refused() -> None:
    image = Image(np.full((SIDE, SIDE), 2.0))
    with pytest.raises(BadInput, match="rows and columns"):
        hit_fraction(image.xyz, HERE, None, *BEAM)
    shuffled = np.random.default_rng(0).permutation(image.xyz)
    with pytest.raises(BadInput, match="rows and columns"):
        hit_fraction(shuffled, HERE, image.cells, *BEAM)
    with pytest.raises(WrongUse):
        hit_fraction(image.xyz, HERE, image.cells, -1.0, 0.0)
    with pytest.raises(WrongUse):
        hit_fraction(image.xyz, HERE, image.cells, *BEAM, np.array([SIDE * SIDE]))

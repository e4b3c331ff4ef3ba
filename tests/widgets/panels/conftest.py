"""A small scan with known answers: a bent leaf before a wall, and ghosts at its borders."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from PySide6.QtWidgets import QWidget

from app.model.points import PointSet
from app.model.scan import Channel, Grid, Pose, Scan
from app.model.selection import Explicit
from app.services.opening import add_scans
from widgets.controller import Controller
from widgets.documents import Documents
from widgets.leaf_work import LeafWork

TRUTH = {"f": 0.6, "k_d": 0.7, "m": 0.35}
DISTANCE, RADIUS, HALF_WIDTH, BORDER, WALL = 3.0, 0.05, 0.044, 0.0465, 3.25
STEP = 0.001 / DISTANCE
SIDE = np.arange(-60, 61) * STEP
HEIGHT = np.arange(-30, 31) * STEP


def lambert_beckmann(angle: np.ndarray, f: float, k_d: float, m: float) -> np.ndarray:
    """Kaasalainen et al. 2018, 2.1, as printed."""
    c, t = np.cos(angle), np.tan(angle)
    return f * (k_d * c + (1 - k_d) * np.exp(-(t**2) / m**2) / c**5)


def build_scan(name: str = "bent leaf", pose: bool = True) -> Scan:
    """A leaf on an upright cylinder, seen from the origin; behind it a wall."""
    row, column = (
        a.ravel() for a in np.meshgrid(range(len(HEIGHT)), range(len(SIDE)), indexing="ij")
    )
    azimuth, elevation = SIDE[column], HEIGHT[row]
    beam = np.column_stack(
        (
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        )
    )
    # |p - centre| in the horizontal plane equals the radius: a quadratic in the range.
    centre = DISTANCE + RADIUS
    flat = beam[:, 0] ** 2 + beam[:, 1] ** 2
    half = beam[:, 0] * centre
    under = half**2 - flat * (centre**2 - RADIUS**2)
    distance = (half - np.sqrt(np.maximum(under, 0.0))) / flat
    across = distance * beam[:, 1]
    on_leaf = (under > 0) & (np.abs(across) < HALF_WIDTH)
    side = np.abs(WALL * np.tan(azimuth)) * DISTANCE / WALL
    mixed = ~on_leaf & (side < BORDER)
    wall = WALL / beam[:, 0]
    chance = np.random.default_rng(1)
    distance = np.where(
        on_leaf, distance, np.where(mixed, chance.uniform(3.05, 3.2, len(beam)), wall)
    )
    xyz = beam * distance[:, None]
    normal = np.column_stack((xyz[:, 0] - centre, xyz[:, 1], np.zeros(len(xyz)))) / RADIUS
    angle = np.where(on_leaf, np.arccos(np.clip(-(normal * beam).sum(axis=1), -1, 1)), 0.2)
    light = lambert_beckmann(angle, **TRUTH)
    noise = chance.normal(1.0, 0.01, (2, len(light)))
    attributes = {
        "near": light * noise[0],
        "far": 0.5 * light * noise[1],
        "true_deg": np.rad2deg(angle),
        "on_leaf": on_leaf.astype(np.float64),
    }
    channels = (
        Channel("near", "near", 1063.0, "reflectance"),
        Channel("far", "far", 1545.0, "reflectance"),
    )
    position = Pose((0.0, 0.0, 0.0), known_by="given") if pose else None
    grid = Grid(len(HEIGHT), len(SIDE), row.astype(np.int32), column.astype(np.int32))
    return Scan(name, xyz, attributes, channels, position, grid)


@dataclass
class Desk:
    """All that a panel needs, with the scan open."""

    controller: Controller
    work: LeafWork
    documents: Documents
    show: Callable[[type[QWidget]], QWidget]

    @property
    def state(self):
        return self.controller.project.state

    def open(self, scan: Scan) -> str:
        (key,) = add_scans(self.controller.project, [scan])
        self.controller.look(current=key)
        return key

    def half(self, key: str, sign: int) -> PointSet:
        """Points of the left (-1) or right (1) half of the leaf."""
        scan = self.state.scan(key).scan
        side = scan.attributes["on_leaf"] == 1.0
        side &= sign * scan.xyz[:, 1] > 0.003
        return PointSet.from_mask(side)

    def make_halves(self, key: str) -> None:
        for sign in (-1, 1):
            points = self.half(key, sign)
            self.work.make_leaf(key, points, Explicit(points))


@pytest.fixture
def desk(qtbot) -> Iterator[Desk]:
    controller = Controller()
    work = LeafWork(controller)
    documents = Documents(controller)
    said: list[object] = []
    controller.failed.connect(said.append)

    def show(panel_type: type[QWidget]) -> QWidget:
        panel = panel_type(controller, work, documents)
        qtbot.addWidget(panel)
        panel.resize(460, 900)
        panel.show()
        qtbot.waitExposed(panel)
        return panel

    yield Desk(controller, work, documents, show)
    controller.close()
    controller.deleteLater()
    assert not said, "errors were reported: " + "; ".join(map(str, said))


@pytest.fixture
def opened(desk: Desk) -> Desk:
    """A desk with the bent leaf open and its halves as two leaves."""
    desk.make_halves(desk.open(build_scan()))
    return desk


@pytest.fixture
def make_scan() -> Callable[..., Scan]:
    return build_scan

"""The camera as plain numbers in world metres, and how hands move it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.model.scan import Vector

StandardView = Literal["top", "bottom", "front", "back", "left", "right", "iso", "iso back"]
DIRECTIONS: dict[str, tuple[Vector, Vector]] = {
    # where the viewer stands, and what is up
    "top": ((0, 0, 1), (0, 1, 0)),
    "bottom": ((0, 0, -1), (0, 1, 0)),
    "front": ((0, -1, 0), (0, 0, 1)),
    "back": ((0, 1, 0), (0, 0, 1)),
    "left": ((-1, 0, 0), (0, 0, 1)),
    "right": ((1, 0, 0), (0, 0, 1)),
    "iso": ((-1, -1, 0.8), (0, 0, 1)),
    "iso back": ((1, 1, 0.8), (0, 0, 1)),
}

MARGIN = 1.06
WIDEST = 75.0  # degrees


@dataclass(frozen=True, slots=True)
class Camera:
    """Where the viewer stands and looks.

    Attributes
    ----------
    position, focal_point, view_up : (x, y, z)
        World metres; the camera turns around the focal point.
    view_angle : float
        Degrees from the lower to the upper edge, in perspective.
    parallel_scale : float or None
        Half height of the view in metres when it is orthographic, else None.
    """

    position: Vector
    focal_point: Vector
    view_up: Vector
    view_angle: float = 30.0
    parallel_scale: float | None = None

    @property
    def distance(self) -> float:
        """Metres from the viewer to the focal point."""
        return float(np.linalg.norm(np.subtract(self.focal_point, self.position)))

    @property
    def half_height(self) -> float:
        """Half height in metres of what is seen at the focal point."""
        if self.parallel_scale is not None:
            return self.parallel_scale
        return self.distance * math.tan(math.radians(self.view_angle) / 2)

    def axes(self) -> tuple[Floats, Floats, Floats]:
        """Unit vectors to the right, up and forward."""
        forward = _unit(np.subtract(self.focal_point, self.position))
        right = np.cross(forward, self.view_up)
        if np.linalg.norm(right) < 1e-9:
            right = np.cross(forward, (0.0, 1.0, 0.0) if abs(forward[1]) < 0.9 else (1.0, 0, 0))
        right = _unit(right)
        return right, np.cross(right, forward), forward


def turn(camera: Camera, right: float, up: float) -> Camera:
    """Turn around the focal point, by radians to the right and up."""
    x, y, _ = camera.axes()
    arm = np.subtract(camera.position, camera.focal_point)
    arm, x = _rotate(arm, y, -right), _rotate(x, y, -right)
    arm, y = _rotate(arm, x, up), _rotate(y, x, up)
    return replace(camera, position=_vector(camera.focal_point + arm), view_up=_vector(y))


def pan(camera: Camera, right: float, up: float) -> Camera:
    """Move the picture with the hand, by shares of the view's height."""
    x, y, _ = camera.axes()
    step = -2.0 * camera.half_height * (right * x + up * y)
    return replace(
        camera,
        position=_vector(camera.position + step),
        focal_point=_vector(camera.focal_point + step),
    )


def make_room(camera: Camera, share: float, aspect: float) -> Camera:
    """Turn aside, so that a share of the picture at its right stays free for a legend.

    What was in the middle stands in the middle of the rest; the viewer does not move
    unless the view is orthographic, where turning would show another side.
    """
    if camera.parallel_scale is not None:
        return pan(camera, -share * aspect / 2, 0.0)
    right, _, _ = camera.axes()
    step = share * aspect * camera.half_height * right
    return replace(camera, focal_point=_vector(camera.focal_point + step))


def zoom(camera: Camera, factor: float, right: float = 0.0, up: float = 0.0) -> Camera:
    """Come closer by a factor; what lies `right` and `up` of the middle stays where it is.

    Offsets are shares of the view's height.
    """
    x, y, _ = camera.axes()
    still = camera.focal_point + 2.0 * camera.half_height * (right * x + up * y)
    scale = camera.parallel_scale
    return replace(
        camera,
        position=_vector(still + (camera.position - still) / factor),
        focal_point=_vector(still + (camera.focal_point - still) / factor),
        parallel_scale=None if scale is None else scale / factor,
    )


def centre_on(camera: Camera, point: Floats) -> Camera:
    """Turn around another point from now on; the picture slides there without turning."""
    shift = np.asarray(point) - camera.focal_point
    return replace(
        camera,
        position=_vector(camera.position + shift),
        focal_point=_vector(camera.focal_point + shift),
    )


def make_orthographic(camera: Camera, on: bool) -> Camera:
    """Switch between perspective and orthographic; what is at the focal point keeps its size."""
    if on:
        return replace(camera, parallel_scale=camera.half_height)
    if camera.parallel_scale is None:
        return camera
    back = camera.parallel_scale / math.tan(math.radians(camera.view_angle) / 2)
    _, _, forward = camera.axes()
    return replace(
        camera, position=_vector(camera.focal_point - back * forward), parallel_scale=None
    )


def look_at_points(
    points: Floats, name: str = "iso", aspect: float = 1.5, orthographic: bool = False
) -> Camera:
    """A standard view that shows all of some points.

    Parameters
    ----------
    points : (k, 3) array
        World metres.
    name : str
        One of `DIRECTIONS`.
    aspect : float
        Width of the view over its height.
    orthographic : bool

    Raises
    ------
    WrongUse
        There is no such view.
    """
    if name not in DIRECTIONS:
        raise WrongUse(f"There is no view {name}; there are: {', '.join(DIRECTIONS)}.")
    where, up = DIRECTIONS[name]
    centre = _middle(points)
    camera = Camera(_vector(centre + np.asarray(where)), _vector(centre), up)
    return fit_points(camera, points, aspect, orthographic)


def fit_points(camera: Camera, points: Floats, aspect: float, orthographic: bool = False) -> Camera:
    """Move a camera along its direction of view until the points fill the picture."""
    x, y, forward = camera.axes()
    axes = np.stack((x, y, forward), axis=1)
    inside = points @ axes
    centre = (inside.min(axis=0) + inside.max(axis=0)) / 2
    offset = inside - centre
    reach = MARGIN * np.maximum(np.abs(offset[:, 0]) / aspect, np.abs(offset[:, 1]))
    half = math.tan(math.radians(camera.view_angle) / 2)
    # Every point must fit at its own depth; a single point is seen from a metre.
    distance = float((reach / half - offset[:, 2]).max())
    distance = distance if distance > 0 else 1.0
    middle = axes @ centre
    return replace(
        camera,
        position=_vector(middle - distance * forward),
        focal_point=_vector(middle),
        view_up=_vector(y),
        parallel_scale=max(float(reach.max()), 1e-3) if orthographic else None,
    )


def look_from(scanner: Floats, points: Floats, aspect: float = 1.5) -> Camera:
    """What the scanner saw: from its position, opened just wide enough for the points.

    Steps back where that would need a fish eye, as for a scanner amid its scan.
    """
    eye = np.asarray(scanner, dtype=np.float64)
    towards = _middle(points) - eye
    if np.linalg.norm(towards) < 1e-9:
        return look_at_points(points, "iso", aspect)
    up = (0.0, 0.0, 1.0) if abs(_unit(towards)[2]) < 0.95 else (0.0, 1.0, 0.0)
    camera = Camera(_vector(eye), _vector(eye + towards), up)
    for _ in range(2):  # aim at the middle of what is seen, then measure how wide it is
        x, y, forward = camera.axes()
        arm = points - eye
        depth = arm @ forward
        if depth.min() <= 0.05 * np.linalg.norm(towards):
            return fit_points(camera, points, aspect)
        right, high = arm @ x / depth, arm @ y / depth
        aim = forward + x * (right.max() + right.min()) / 2 + y * (high.max() + high.min()) / 2
        ahead = float(np.linalg.norm(towards)) * _unit(aim)
        camera = replace(camera, focal_point=_vector(eye + ahead))
    reach = max(float(np.ptp(right)) / 2 / aspect, float(np.ptp(high)) / 2)
    angle = 2.0 * math.degrees(math.atan(MARGIN * reach))
    if angle > WIDEST:
        return fit_points(camera, points, aspect)
    return replace(camera, view_angle=max(angle, 1.0))


def _middle(points: Floats) -> Floats:
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)


def _unit(vector: Floats) -> Floats:
    length = float(np.linalg.norm(vector))
    return np.asarray(vector) / length if length > 0 else np.array([0.0, 1.0, 0.0])


def _rotate(vector: Floats, axis: Floats, angle: float) -> Floats:
    """Rodrigues' formula; `axis` has unit length."""
    cos, sin = math.cos(angle), math.sin(angle)
    return (
        vector * cos
        + np.cross(axis, vector) * sin
        + axis * float(np.dot(axis, vector)) * (1.0 - cos)
    )


def _vector(values: Floats) -> Vector:
    x, y, z = (float(v) for v in values)
    return x, y, z

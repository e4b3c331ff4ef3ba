"""A scene brought to VTK: clouds, background and camera. Knows nothing about windows."""

from __future__ import annotations

import numpy as np

# Registers the OpenGL classes behind VTK's abstract ones.
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.vtkRenderingCore import vtkRenderer

from app.core.arrays import Floats
from app.core.screen import View
from app.model.scene import Cloud, Part, Scene, differences
from app.render.camera import Camera
from app.render.cloud_actor import CloudActor
from app.render.drawings import Drawings
from app.render.lod import Block, split_blocks
from app.render.palettes import (
    BACKGROUNDS,
    MISSING,
    PLAIN,
    Background,
    colour_table,
    is_categorical,
)
from app.render.picture import PictureSource, known_values

FAIR_SAMPLE = 1000
HAZE = 0.72


class Stage:
    """One VTK renderer that shows scenes and changes only what differs.

    Attributes
    ----------
    origin : (3,) float64
        World metres that VTK's zero stands for.
    scale : float
        Device pixels per pixel; points keep their apparent size on dense screens.
    drawings : Drawings
        What lies over the points.
    """

    def __init__(self, background: Background = "light", scale: float = 1.0) -> None:
        self.renderer = vtkRenderer()
        # VTK's half would waste the depth buffer and the haze: our box is exact.
        self.renderer.SetClippingRangeExpansion(0.01)
        self.scene = Scene()
        self.origin: Floats = np.zeros(3)
        self.scale = scale
        self.background: Background = background
        self._clouds: dict[str, CloudActor] = {}
        self.drawings = Drawings(self.renderer)
        self.set_background(background)

    def show(self, scene: Scene, source: PictureSource) -> frozenset[Part]:
        """Bring a scene to the screen; return what kinds of things changed."""
        before, self.scene = self.scene, scene
        keep = {cloud.scan for cloud in scene.clouds}
        changed: set[Part] = set()
        for key in [key for key in self._clouds if key not in keep]:
            self._remove(key)
            changed.add("points")
        by_key = {cloud.scan: cloud for cloud in scene.clouds}
        for key, parts in differences(before, scene).items():
            self._update(by_key[key], parts, source)
            changed |= parts
        if changed & {"points", "mask"}:
            self.reset_clipping()
        return frozenset(changed)

    def set_background(self, background: Background) -> None:
        """Choose light or dark."""
        self.background = background
        top, bottom = BACKGROUNDS[background]
        self.renderer.GradientBackgroundOn()
        self.renderer.SetBackground2(*(part / 255.0 for part in top))
        self.renderer.SetBackground(*(part / 255.0 for part in bottom))
        self.drawings.style(background, self.scale)
        for cloud in self.scene.clouds:
            self._style(cloud)

    def set_scale(self, scale: float) -> None:
        """Set the device pixels per pixel."""
        self.scale = scale
        self.drawings.style(self.background, scale)
        for cloud in self.scene.clouds:
            self._style(cloud)

    def set_range(self, field: str, low: float, high: float) -> None:
        """Move the limits of a field ahead of the scene, while a handle is dragged."""
        for cloud in self.scene.clouds:
            if cloud.bar is not None and cloud.bar.field == field:
                shading = self._clouds[cloud.scan].shading
                shading.set_range(low, high, is_categorical(cloud.bar.map))

    def clear(self) -> None:
        """Take everything away."""
        for key in list(self._clouds):
            self._remove(key)
        self.drawings.clear()
        self.scene = Scene()

    # What is drawn of it

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Steps in which the whole scene is refined, in points."""
        return split_blocks(self.points_of_largest()[0])

    def points_of_largest(self) -> tuple[int, int]:
        """Points of the largest cloud and of all: blocks are counted by the largest."""
        sizes = [cloud.size for cloud in self._clouds.values()]
        return max(sizes, default=0), sum(sizes)

    def show_blocks(self, start: int, stop: int) -> int:
        """Draw these blocks of every cloud; return how many points that is."""
        return sum(cloud.show_blocks(start, stop) for cloud in self._clouds.values())

    def show_all(self) -> int:
        """Draw everything; return how many points that is."""
        return self.show_blocks(0, len(self.blocks))

    def draw_over(self, on: bool) -> None:
        """Whether the next frame is drawn over the last one instead of beginning anew."""
        self.renderer.SetErase(not on)
        self.renderer.SetPreserveColorBuffer(on)
        self.renderer.SetPreserveDepthBuffer(on)

    # Camera

    def bounds(self) -> Floats | None:
        """Corners (2, 3) around all points that are drawn, in world metres."""
        return _join([cloud.bounds() for cloud in self._clouds.values()])

    def extent(self) -> Floats:
        """Points (k, 3) that a camera has to show to show the scene, in world metres.

        A sample without the outermost thousandth, so that strays do not shrink everything
        else to a dot; the corners of a small scene; a cube of two metres when it is empty.
        """
        samples = [cloud.sample() for cloud in self._clouds.values()]
        sample = np.concatenate([*samples, np.empty((0, 3))])
        whole = self.bounds()
        if whole is None or len(sample) == 0:
            return _corners(np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]))
        lower, upper = np.quantile(sample, (0.001, 0.999), axis=0)
        core = sample[((sample >= lower) & (sample <= upper)).all(axis=1)]
        return core if len(core) > FAIR_SAMPLE else _corners(whole)

    def set_camera(self, camera: Camera) -> None:
        """Look from there."""
        vtk = self.renderer.GetActiveCamera()
        vtk.SetPosition(*(np.asarray(camera.position) - self.origin))
        vtk.SetFocalPoint(*(np.asarray(camera.focal_point) - self.origin))
        vtk.SetViewUp(*camera.view_up)
        vtk.SetViewAngle(camera.view_angle)
        vtk.SetParallelProjection(camera.parallel_scale is not None)
        if camera.parallel_scale is not None:
            vtk.SetParallelScale(camera.parallel_scale)
        self.reset_clipping()

    def reset_clipping(self) -> None:
        """Fit near and far planes to all points, drawn at the moment or not."""
        bounds = _join([self.bounds(), *self.drawings.bounds()])
        if bounds is not None:
            lower, upper = bounds - self.origin
            box = np.stack((lower - 1e-3, upper + 1e-3), axis=1).ravel()
            self.renderer.ResetCameraClippingRange(*box)
            camera = self.renderer.GetActiveCamera()
            near, far = camera.GetClippingRange()
            for cloud in self._clouds.values():
                cloud.shading.set_depths(-1.0 if camera.GetParallelProjection() else near, far)

    def view(self, size: tuple[int, int]) -> View:
        """The camera as a matrix, for selection and picking."""
        # The aspect of the true viewport: VTK's own may be that of an older size.
        camera = self.renderer.GetActiveCamera()
        matrix = camera.GetCompositeProjectionTransformMatrix(size[0] / size[1], -1.0, 1.0)
        rows = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
        return View.of(self.origin, rows, size)

    # Clouds

    def _update(self, cloud: Cloud, parts: frozenset[Part], source: PictureSource) -> None:
        if "points" in parts:
            self._remove(cloud.scan)
            self._add(cloud.scan, source.xyz(cloud.scan))
            parts = parts | {"mask", "colour", "range", "overlay", "style"}
        actor = self._clouds[cloud.scan]
        if "mask" in parts:
            actor.set_mask(source.alive(cloud.scan))
        if "colour" in parts:
            known = source.values(cloud.scan, cloud.bar.field) if cloud.bar else None
            actor.set_values(known_values(known))
        if "range" in parts and cloud.bar is not None:
            actor.shading.set_palette(colour_table(cloud.bar.map))
            categorical = is_categorical(cloud.bar.map)
            actor.shading.set_range(cloud.bar.low, cloud.bar.high, categorical)
        if "overlay" in parts:
            actor.set_overlay(source.overlay(cloud.scan))
        if parts & {"style", "colour", "range"}:
            self._style(cloud)

    def _add(self, key: str, xyz: Floats) -> None:
        actor = self._clouds[key] = CloudActor(xyz)
        if len(self._clouds) == 1:
            self.origin = actor.origin
            self.drawings.place(self.origin)
        actor.place(self.origin)
        for block in actor.actors:
            self.renderer.AddActor(block)

    def _remove(self, key: str) -> None:
        actor = self._clouds.pop(key, None)
        for block in actor.actors if actor is not None else ():
            self.renderer.RemoveActor(block)
            block.ReleaseGraphicsResources(self.renderer.GetRenderWindow())

    def _style(self, cloud: Cloud) -> None:
        shading = self._clouds[cloud.scan].shading
        shading.set_point_size(cloud.point_size * self.scale)
        # Without colours only haze tells what is far; with them it would falsify the scale.
        plain = cloud.bar is None
        colour = (PLAIN if plain else MISSING)[self.background]
        shading.set_missing(colour, BACKGROUNDS[self.background][1], HAZE if plain else 0.0)


def _corners(box: Floats) -> Floats:
    return np.array([[box[i, 0], box[j, 1], box[k, 2]] for i, j, k in np.ndindex(2, 2, 2)])


def _join(boxes: list[Floats | None]) -> Floats | None:
    found = np.array([box for box in boxes if box is not None])
    if len(found) == 0:
        return None
    return np.stack((found[:, 0].min(axis=0), found[:, 1].max(axis=0)))

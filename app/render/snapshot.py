"""A scene as a picture with its colour bar, without a window and without a display."""

from __future__ import annotations

import io
import os
import sys

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkWindowToImageFilter

from app.core.arrays import Floats
from app.model.scene import Scene
from app.render.camera import Camera, look_at_points, look_from
from app.render.legend import add_legend, legend_height
from app.render.palettes import Background, Bytes
from app.render.picture import PictureSource
from app.render.stage import Stage

SMOOTHING = 2


def render_snapshot(
    scene: Scene,
    source: PictureSource,
    size: tuple[int, int] = (1600, 1000),
    background: Background = "light",
    camera: Camera | None = None,
    scanner: Floats | None = None,
    legend: bool = True,
    rings: Floats | None = None,
) -> Bytes:
    """Draw a scene with all its points.

    Parameters
    ----------
    scene : Scene
    source : PictureSource
    size : (width, height)
        Pixels of the picture.
    background : {'light', 'dark'}
    camera : Camera or None
        None: what the scanner saw, or a view of everything when its position is unknown.
    scanner : (3,) array or None
        Position of the scanner in world metres.
    legend : bool
        Whether a strip with colour bar and number of points is kept at the bottom.
    rings : (k, n, 3) array or None
        Closed lines over the points, e.g. footprints, world metres.

    Returns
    -------
    (height, width, 3) uint8
    """
    stage = Stage(background, scale=SMOOTHING)
    stage.show(scene, source)
    stage.drawings.show_rings(rings)
    drawn = stage.show_all()
    width, height = size[0], size[1] - (legend_height(size) if legend else 0)
    stage.set_camera(camera or choose_camera(stage, scanner, width / height))
    image = _shrink(_render(stage, (width * SMOOTHING, height * SMOOTHING)))
    stage.clear()
    return add_legend(image, size, scene, drawn, background) if legend else image


def choose_camera(stage: Stage, scanner: Floats | None, aspect: float) -> Camera:
    """What the scanner saw, else a view of everything."""
    if scanner is None:
        return look_at_points(stage.extent(), "iso", aspect)
    return look_from(scanner, stage.extent(), aspect)


def png_bytes(image: Bytes, **texts: str) -> bytes:
    """An (h, w, 3) picture as PNG, with texts such as the title or the software."""
    from matplotlib.image import imsave

    file = io.BytesIO()
    imsave(file, np.ascontiguousarray(image), format="png", metadata=texts or None)
    return file.getvalue()


def make_window() -> vtkRenderWindow:
    """A window that is never shown; straight through EGL where there is no display."""
    window: vtkRenderWindow
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        from vtkmodules.vtkRenderingOpenGL2 import vtkEGLRenderWindow

        window = vtkEGLRenderWindow()
    else:
        window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    return window


def _render(stage: Stage, size: tuple[int, int]) -> Bytes:
    window = make_window()
    window.SetSize(*size)
    window.AddRenderer(stage.renderer)
    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.ShouldRerenderOff()
    grab.Update()
    output = grab.GetOutput()
    flat = vtk_to_numpy(output.GetPointData().GetScalars())
    image: Bytes = flat.reshape(size[1], size[0], -1)[::-1, :, :3].copy()
    window.RemoveRenderer(stage.renderer)
    window.Finalize()
    return image


def _shrink(image: Bytes) -> Bytes:
    """Average squares of pixels: smooth edges without the card's multi-sampling."""
    height, width, _ = image.shape
    n = SMOOTHING
    squares = image.reshape(height // n, n, width // n, n, 3).astype(np.uint16)
    mean: Bytes = (squares.sum(axis=(1, 3)) // (n * n)).astype(np.uint8)
    return mean

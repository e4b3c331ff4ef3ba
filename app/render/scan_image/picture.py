"""The whole scan image at the size of a picture, without a window."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray
from app.model.scene import Scene
from app.render.legend import add_legend, legend_height
from app.render.palettes import BACKGROUNDS, Background, Bytes
from app.render.picture import PictureSource, known_values
from app.render.scan_image.frame import Frame
from app.render.scan_image.image import ScanImage
from app.render.scan_image.paint import Paint

SMOOTHING = 2
STRIP = 256
WHOLE = (slice(None), slice(None))


def paint_scene(
    scene: Scene, source: PictureSource, scan: str, image: ScanImage, background: Background
) -> Paint:
    """Colours, marks and selection of a scan as a scene and its source tell them."""
    cloud = next((cloud for cloud in scene.clouds if cloud.scan == scan), None)
    paint = Paint(background)
    if cloud is not None and cloud.bar is not None:
        paint.use_colours(cloud.bar, known_values(source.values(scan, cloud.bar.field)))
    overlay = source.overlay(scan)
    paint.use_marks(overlay, len(image.alive))
    paint.select(image, overlay.selection)
    return paint


def render_scan_image(
    scene: Scene,
    source: PictureSource,
    scan: str,
    image: ScanImage,
    size: tuple[int, int] = (1600, 1000),
    background: Background = "light",
) -> Bytes:
    """Draw the scan image of one scan above the colour bar that 3-D pictures have.

    Parameters
    ----------
    scene : Scene
    source : PictureSource
    scan : str
        One of the scans of the scene.
    image : ScanImage
    size : (width, height)
        Pixels of the picture.
    background : {'light', 'dark'}

    Returns
    -------
    (height, width, 3) uint8
        The count in the legend is that of the points that pixels show.
    """
    width, height = size[0], size[1] - legend_height(size)
    frame = Frame.fit(image.layout, (width * SMOOTHING, height * SMOOTHING))
    level = frame.choose_level(image)
    colours = paint_scene(scene, source, scan, image, background).draw(image, level, WHOLE)
    picture = np.empty((height, width, 3), np.uint8)
    across = _lines(np.arange(width * SMOOTHING), frame.left, frame.wide * 2**level)
    ground = np.array(BACKGROUNDS[background][1], np.uint16)
    for first in range(0, height, STRIP):
        last = min(first + STRIP, height)
        places = np.arange(first * SMOOTHING, last * SMOOTHING)
        down = _lines(places, frame.top, frame.high * 2**level)
        picture[first:last] = _shrink(_sample(colours, down, across, ground))
    return add_legend(picture, size, scene, image.shown, background)


def _lines(places: AnyArray, start: float, side: float) -> AnyArray:
    """Which line of the level lies at the middle of each place."""
    lines: AnyArray = np.floor((places + 0.5 - start) / side).astype(np.int64)
    return lines


def _sample(colours: AnyArray, down: AnyArray, across: AnyArray, ground: AnyArray) -> AnyArray:
    rows, columns = colours.shape
    found = colours[down.clip(0, rows - 1)[:, None], across.clip(0, columns - 1)]
    parts = np.stack([(found >> shift) & 255 for shift in (16, 8, 0)], axis=-1).astype(np.uint16)
    outside = ((down < 0) | (down >= rows))[:, None] | ((across < 0) | (across >= columns))
    parts[outside] = ground
    return parts


def _shrink(parts: AnyArray) -> Bytes:
    """Average squares of pixels."""
    high, wide = (side // SMOOTHING for side in parts.shape[:2])
    squares = parts.reshape(high, SMOOTHING, wide, SMOOTHING, 3)
    mean: Bytes = (squares.sum(axis=(1, 3), dtype=np.uint16) // SMOOTHING**2).astype(np.uint8)
    return mean

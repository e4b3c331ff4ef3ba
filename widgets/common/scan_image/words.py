"""What is said of the scan image and of the place under the mouse."""

from __future__ import annotations

import math

from PySide6.QtCore import QCoreApplication

from app.model.project import Project
from app.model.scan import Scan
from app.render.legend import ANSWERS
from app.render.scan_image.image import ScanImage
from widgets.common.numbers import count_decimals, show_count, show_number


def tr(text: str) -> str:
    """Translate."""
    return QCoreApplication.translate("ScanImage", text)


def describe_image(image: ScanImage) -> str:
    """What rows and columns are, and how many."""
    layout = image.layout
    size = f"{show_count(layout.rows)} × {show_count(layout.columns)}"
    match layout.kind:
        case "scan grid":
            text = tr("Rows and columns of the file, {0} pixels").format(size)
        case "recovered grid":
            text = tr("Rows and columns recovered from the points, {0} pixels").format(size)
        case _:
            whole = float(layout.elevation[0] - layout.elevation[-1])
            step = show_number(whole / max(layout.rows - 1, 1), 3)
            text = tr("No rows and columns found: steps of {0}°, {1} pixels").format(step, size)
    if layout.merged > 1:
        text += tr(", {0} × {0} cells in each").format(layout.merged)
    return text


def describe_place(
    project: Project, scan: str, image: ScanImage, row: int, column: int, colour: str
) -> str:
    """One line about a pixel: where it is, and what it shows; computes no field."""
    whole, point = project.state.scan(scan).scan, image.point_at(row, column)
    if point < 0:
        azimuth, elevation = image.layout.azimuth[column], image.layout.elevation[row]
        parts = [
            _why_empty(image, row, column),
            _place(whole, image, row, column, -1),
            _directions(azimuth, elevation),
        ]
        return " · ".join(part for part in parts if part)
    beam = whole.xyz[point] - whole.scanner("the scan image")
    azimuth = math.degrees(math.atan2(beam[1], beam[0]))
    elevation = math.degrees(math.atan2(beam[2], math.hypot(beam[0], beam[1])))
    distance = float(image.layout.distance[point])
    parts = [
        _value(project, scan, colour, point),
        _place(whole, image, row, column, point),
        _directions(azimuth, elevation),
        f"{show_number(distance, 3)} m",
        _company(image, row, column),
    ]
    return " · ".join(part for part in parts if part)


def _place(scan: Scan, image: ScanImage, row: int, column: int, point: int) -> str:
    if image.layout.kind == "angles":
        return ""
    place = image.layout.find_cell(row, column)
    if scan.grid is not None and point >= 0:
        place = int(scan.grid.row[point]), int(scan.grid.column[point])
    return tr("Row {0}, column {1}").format(*place)


def _directions(azimuth: float, elevation: float) -> str:
    around = (azimuth + 180.0) % 360.0 - 180.0
    return tr("azimuth {0}°, elevation {1}°").format(
        show_number(around, 3), show_number(elevation, 3)
    )


def _value(project: Project, scan: str, colour: str, point: int) -> str:
    known = project.known_field(scan, colour) if colour in project.catalogue(scan) else None
    if known is None:
        return ""
    spec, value = project.catalogue(scan)[colour], float(known.values[point])
    if not known.have[point] or not math.isfinite(value):
        return tr("{0}: no value").format(spec.title)
    answers = [text for _, text in ANSWERS.get(spec.kind, ())]
    if answers:
        shown = answers[min(max(round(value), 0), len(answers) - 1)]
    elif spec.kind == "class":
        shown = show_number(value, 0)
    else:
        shown = show_number(value, count_decimals(value, None))
    unit = spec.unit if spec.unit == "°" else f" {spec.unit}"
    return f"{spec.title} {shown}{unit}".strip()


def _company(image: ScanImage, row: int, column: int) -> str:
    points = image.points_at(row, column)
    count = int(image.alive[points].sum())
    return "" if count < 2 else tr("nearest of {0} points").format(show_count(count))


def _why_empty(image: ScanImage, row: int, column: int) -> str:
    if len(image.points_at(row, column)):
        return tr("Deleted")
    if image.silent[0][row, column]:
        return tr("No return")
    return tr("Nothing recorded")

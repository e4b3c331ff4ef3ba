"""The figure of angular curves for a paper: points, means, curves and what they leave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.fitting import FitResult
from app.core.phase.angular import AngularModel
from app.formats.atomic import atomic_path, refuse_target

Kind = Literal["png", "svg", "pdf"]
KINDS: dict[str, Kind] = {".png": "png", ".svg": "svg", ".pdf": "pdf"}
ANGLE = "Incidence angle ω (°)"
MOST_PANELS, MOST_SERIES = 24, 12
# Okabe and Ito without yellow, which white paper swallows, and with Tol's wine.
COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#882255", "#e69f00", "#4d4d4d",
)  # fmt: skip
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "p")
DPI = 300


@dataclass(frozen=True, slots=True)
class DrawnCurve:
    """A curve: a model with its values, solid within the angles that it was fitted to (radians)."""

    model: AngularModel
    values: Mapping[str, float]
    angle_range: tuple[float, float]

    @classmethod
    def of(cls, result: FitResult) -> DrawnCurve:
        """The curve of a fit."""
        return cls(result.angular_model, result.values, result.angle_range)


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """Points of one channel (or leaf) with their curve.

    Attributes
    ----------
    name : str
    angle, value : (n,) arrays
        Angles in degrees.
    curve : DrawnCurve or None
    number : int
        Chooses colour and symbol, the same in all panels.
    """

    name: str
    angle: Floats
    value: Floats
    curve: DrawnCurve | None = None
    number: int = 0


@dataclass(frozen=True, slots=True)
class FigurePanel:
    """One diagram with all of its channels, and its residuals below."""

    title: str
    series: tuple[Series, ...]


@dataclass(frozen=True, slots=True)
class FigureOrder:
    """What is drawn.

    Attributes
    ----------
    panels : tuple of FigurePanel
    y_title, x_title : str
        What values and angles are, with their units.
    width : float
        Of the steps whose means are shown, degrees.
    residuals : bool
        Draw them below.
    note : str
        A line below all: the model, and how it was fitted.
    """

    panels: tuple[FigurePanel, ...]
    y_title: str
    width: float = 5.0
    residuals: bool = True
    note: str = ""
    x_title: str = ANGLE


def draw_figure(order: FigureOrder, path: Path, overwrite: bool = False) -> None:
    """Write a figure as PNG (300 dots per inch), SVG or PDF, as the file's ending tells.

    Raises
    ------
    WrongUse
        Another ending, or more panels or curves than can be read.
    BadInput
        The file cannot be written.
    """
    kind = figure_kind(path)
    refuse_target(path, overwrite)
    content = figure_bytes(order, kind)
    with atomic_path(path, overwrite) as temporary:
        temporary.write_bytes(content)


def figure_kind(path: Path) -> Kind:
    """The kind of figure that a file's ending asks for; raises `WrongUse` for another."""
    try:
        return KINDS[path.suffix.lower()]
    except KeyError:
        raise WrongUse(
            f"{path.name} is no figure that can be written.", f"Endings: {', '.join(KINDS)}."
        ) from None


def figure_bytes(order: FigureOrder, kind: Kind = "png") -> bytes:
    """The content of the file that `draw_figure` writes."""
    check_order(order)
    from app.services.lab.figure_parts import build_figure

    return save_to_bytes(build_figure(order), kind)


def save_to_bytes(figure: Any, kind: Kind) -> bytes:
    """A matplotlib figure as the content of a file, the same each time."""
    import matplotlib

    content = BytesIO()
    # No dates, and fonts that publishers take and programs can edit.
    metadata: dict[str, Any] = {
        "png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None},
    }[kind]  # fmt: skip
    with matplotlib.rc_context({"svg.hashsalt": "leafscope", "pdf.fonttype": 42}):
        figure.savefig(content, format=kind, metadata=metadata, dpi=DPI, facecolor="white")
    return content.getvalue()


def check_order(order: FigureOrder) -> None:
    """Raise `WrongUse` where nobody could read the figure."""
    if not 1 <= len(order.panels) <= MOST_PANELS:
        raise WrongUse(
            f"A figure has 1 to {MOST_PANELS} panels, not {len(order.panels)}.",
            "Draw fewer samples in each.",
        )
    most = max(len(panel.series) for panel in order.panels)
    if most > MOST_SERIES:
        raise WrongUse(
            f"{most} curves in one panel cannot be told apart; {MOST_SERIES} can.",
            "Group them by sample and channel.",
        )

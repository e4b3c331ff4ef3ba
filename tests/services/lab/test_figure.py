"""Figures: what is in them, in every form, and which are refused."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.core.phase import get_model
from app.model.fit_method import Method
from app.services.fit import FitReport, fit_groups
from app.services.lab.figure import (
    COLOURS,
    DrawnCurve,
    FigureOrder,
    FigurePanel,
    Series,
    draw_figure,
    figure_bytes,
)
from app.services.lab.figure_order import order_figure
from app.services.lab.figure_parts import MOST_DOTS, build_figure
from app.services.lab.method import fit_by
from app.services.lab.orders import PairGroup

MODEL = get_model("lambert-beckmann")


def draw(count: int, number: int = 0) -> Series:
    generator = np.random.default_rng(number)
    angle = generator.uniform(10.0, 70.0, count)
    value = MODEL.evaluate(np.deg2rad(angle), {"f": 0.5, "k_d": 0.6, "m": 0.3})
    value = value * (1.0 + 0.05 * generator.standard_normal(count))
    curve = DrawnCurve.of(fit_by(Method("bins"), MODEL, angle, value))
    return Series(f"channel {number}", angle, value, curve, number)


def order(count: int, series: int = 2) -> FigureOrder:
    panel = FigurePanel("Leaf 1", tuple(draw(count, number) for number in range(series)))
    return FigureOrder((panel,), "Reflectance (0–1)", note="Lambert–Beckmann")


def test_curves_are_solid_within_the_data_and_dashed_beyond() -> None:
    figure = build_figure(order(200, 1))
    above, below = figure.subfigs[0].axes
    solid = [
        line for line in above.lines if line.get_linestyle() == "-" and len(line.get_xdata()) > 50
    ]
    dashed = [line for line in above.lines if line.get_linestyle() == "--"]
    (curve,) = solid
    low, high = curve.get_xdata()[[0, -1]]
    assert (low, high) == pytest.approx((12.0, 68.0), abs=2.5)
    assert [line.get_xdata()[[0, -1]].tolist() for line in dashed] == [
        pytest.approx([0.0, low]),
        pytest.approx([high, 89.75]),
    ]
    assert curve.get_color() == COLOURS[0]
    assert above.get_ylabel() == "Reflectance (0–1)"
    assert below.get_xlabel() == "Incidence angle ω (°)"
    assert [text.get_text() for text in above.get_legend().get_texts()] == ["channel 0"]
    assert not above.images


def test_many_points_are_a_density() -> None:
    figure = build_figure(order(MOST_DOTS // 2 + 1))
    above, below = figure.subfigs[0].axes
    assert len(above.images) == len(below.images) == 2
    assert not [line for line in above.lines if len(line.get_xdata()) > 1000]


@pytest.mark.parametrize(
    ("kind", "start"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")]
)
def test_every_form_is_written_whole(kind: str, start: bytes, tmp_path: Path) -> None:
    path = tmp_path / f"figure.{kind}"
    draw_figure(order(50), path)
    assert path.read_bytes().startswith(start)
    with pytest.raises(BadInput, match="exists already"):
        draw_figure(order(50), path)
    assert len(list(tmp_path.iterdir())) == 1


def test_the_paper_is_white_and_large_enough_for_print() -> None:
    from matplotlib.image import imread

    picture = imread(io.BytesIO(figure_bytes(order(50))))
    assert picture.shape[1] >= 1500
    assert (picture[:5, -5:] == 1.0).all()
    used = np.unique((picture[..., :3].reshape(-1, 3) * 255).round().astype(int), axis=0)
    for colour in COLOURS[:2]:
        wanted = [int(colour[place : place + 2], 16) for place in (1, 3, 5)]
        assert (used == wanted).all(axis=1).any()


def test_what_nobody_could_read_is_refused(tmp_path: Path) -> None:
    one = order(20, 1)
    crowd = FigurePanel("", tuple(one.panels[0].series * 13))
    for wrong in (
        FigureOrder((), "y"),
        FigureOrder((crowd,), "y"),
        FigureOrder(one.panels * 25, "y"),
    ):
        with pytest.raises(WrongUse):
            draw_figure(wrong, tmp_path / "f.png")
    with pytest.raises(WrongUse, match=r"\.png, \.svg, \.pdf"):
        draw_figure(one, tmp_path / "f.jpeg")
    assert not list(tmp_path.iterdir())


def make_groups(*labels: dict[str, str]) -> list[PairGroup]:
    angle = np.linspace(0.0, 80.0, 30)
    return [PairGroup(each, angle, np.cos(np.deg2rad(angle))) for each in labels]


def fit_all(groups: list[PairGroup]) -> FitReport:
    return fit_groups([(g.labels, g.angle, g.value) for g in groups], "lambert")


def test_samples_are_panels_and_channels_colours() -> None:
    groups = make_groups(
        *({"sample": s, "channel": c} for s in ("ZGem", "rose") for c in ("1", "2"))
    )
    found = order_figure(groups, fit_all(groups), "DN")
    assert [panel.title for panel in found.panels] == ["ZGem", "rose"]
    named = [(s.name, s.number) for s in found.panels[1].series]
    assert named == [("channel 1", 0), ("channel 2", 1)]
    assert found.note == (
        "Lambert, fitted to single points; bars: standard deviation of a value per 5° step"
    )
    assert all(s.curve is not None for panel in found.panels for s in panel.series)


def test_one_label_is_one_panel_until_it_is_crowded() -> None:
    few = make_groups(*({"leaf": str(i)} for i in range(3)))
    (panel,) = order_figure(few, fit_all(few), "DN").panels
    assert [series.number for series in panel.series] == [0, 1, 2]
    many = make_groups(*({"leaf": str(i)} for i in range(13)))
    assert len(order_figure(many, fit_all(many), "DN").panels) == 13
    (alone,) = order_figure(make_groups({}), fit_all(make_groups({})), "DN").panels
    assert alone.series[0].name == "all"


def test_a_panel_without_points_says_so() -> None:
    empty = FigurePanel("Leaf 1", (Series("near", np.empty(0), np.empty(0)),))
    (axes,) = build_figure(FigureOrder((empty,), "y")).subfigs[0].axes
    assert [text.get_text() for text in axes.texts] == ["no points"]

"""Texts of a scatter diagram cover neither each other nor a dot, as far as there is room."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.services.bench.picture import Dots, Scatter, draw_scatters
from app.services.bench.scatter import draw_figure, find_front


@pytest.fixture
def panel():
    random = np.random.default_rng(0)

    def make(name, rival):
        x, y = random.uniform(1, 30, 8), random.uniform(1, 10, 8)
        texts = [f"{k}" for k in range(8)]
        return Dots(name, x.tolist(), y.tolist(), texts, [k == 3 for k in range(8)], rival)

    return Scatter("title", "seconds", "degrees", (make("ours", False), make("theirs", True)))


def test_texts_keep_clear(panel):
    figure = draw_figure([panel], 2)
    axes = figure.axes[0]
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == 16
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    spots = [axes.transData.transform(at) for d in panel.dots for at in zip(d.x, d.y, strict=True)]
    assert not any(box.contains(*spot) for box in boxes for spot in spots)
    window = axes.get_window_extent()
    assert all(window.x0 <= b.x0 and b.x1 <= window.x1 for b in boxes)


def test_front_is_what_nobody_beats():
    x, y = np.array([1.0, 2.0, 3.0, 2.5, np.nan]), np.array([3.0, 2.0, 1.0, 2.0, 0.1])
    assert find_front(x, y).tolist() == [True, True, True, False, False]


def test_one_legend_and_a_file(panel, tmp_path):
    figure = draw_figure([panel, panel, panel], 2)
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["Pareto front", "ours", "theirs"]
    path = tmp_path / "front.png"
    draw_scatters([panel], path)
    assert path.read_bytes()[1:4] == b"PNG"
    with pytest.raises(WrongUse):
        draw_scatters([], path)

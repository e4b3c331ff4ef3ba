"""Pictures and LaTeX tables of an index."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.core.channel_index import choose_index
from app.core.errors import WrongUse
from app.services.index_angle import Group, IndexAngles, compare_angles
from app.services.index_picture import draw_index_angles, draw_spread, write_latex
from app.services.synthetic_footprints import Spread

STARTS = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


@pytest.fixture(scope="module")
def found() -> IndexAngles:
    random = np.random.default_rng(1)
    angle = np.deg2rad(random.uniform(0, 70, 400))
    values = {"a": 0.5 * np.cos(angle), "b": 0.3 * np.cos(angle) ** 0.5}
    values = {name: v + random.normal(0, 0.01, 400) for name, v in values.items()}
    index = choose_index("ndi", {"a": 1063.0, "b": 1545.0})
    return compare_angles(index, [Group({"leaf": "Leaf_1"}, angle, values)], "fourier-2", None,
                          holder=False)  # fmt: skip


@pytest.mark.parametrize("suffix", STARTS)
def test_pictures_of_each_kind(found: IndexAngles, suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"p{suffix}"
    draw_index_angles(found, "Leaf_1", path)
    assert path.read_bytes().startswith(STARTS[suffix])
    rows = [{"diameter_mm": d, "n": 9, "mean": 0.2, "sd": sd, "low": 0.1, "high": 0.3,
             "points": 4.0} for d, sd in ((0.0, 0.1), (5.0, 0.05), (50.0, 0.01))]  # fmt: skip
    draw_spread(Spread(found.index, rows, 0.02, 20.0), 0.02, 20.0, path)
    assert path.read_bytes().startswith(STARTS[suffix])


def test_other_pictures_are_refused(found: IndexAngles, tmp_path: Path) -> None:
    with pytest.raises(WrongUse, match="png"):
        draw_index_angles(found, "Leaf_1", tmp_path / "p.gif")
    assert not list(tmp_path.iterdir())


def test_the_latex_table_holds_the_numbers(found: IndexAngles, tmp_path: Path) -> None:
    path = tmp_path / "t.tex"
    write_latex(found, path)
    text, row = path.read_text(encoding="utf-8"), found.rows[0]
    assert r"Leaf\_1" in text
    assert text.count("toprule") == text.count("bottomrule") == 1
    assert f"{row['A']:.4f}".replace("-", "$-$") in text
    cells = text.splitlines()[5].rstrip("\\ ").split(" & ")
    assert len(cells) == 10


def test_intervals_hold_the_values_and_shrink_with_points(found: IndexAngles) -> None:
    row = found.rows[0]
    assert row["A_low"] < row["A"] < row["A_high"]
    assert row["index_mean_low"] < row["index_mean"] < row["index_mean_high"]
    assert row["undefined"] == 0

"""Tables of panels: what is refused, in one sentence each, and what stands still."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.radiometry.panels import (
    PanelTable,
    check_panels,
    find_fixed_panels,
    make_table,
    to_fractions,
)


def table() -> PanelTable:
    return make_table(
        np.array([4.0, 4.0, 8.0, 4.0, 6.0, 8.0]),
        np.array([10.0, 20.0, 5.0, 11.0, 15.0, 6.0]),
        np.array([0.2, 0.5, 0.5, 0.2, 0.5, 0.5]),
        785.0,
        scan=["a", "a", "a", "b", "b", "b"],
        panel=["grey", "white", "far", "grey", "white", "far"],
    )


def spoil(**columns: list[float]) -> PanelTable:
    return replace(table(), **{name: np.array(values) for name, values in columns.items()})


def test_a_good_table_passes() -> None:
    check_panels(table())


@pytest.mark.parametrize(
    ("spoilt", "words"),
    [
        (spoil(reflectance=[20, 50, 50, 20, 50, 50]), "percent.*--percent"),
        (spoil(reflectance=[0.2, 0.5, 0.5, 0.3, 0.5, 0.5]), "grey has two reflectances"),
        (spoil(reflectance=[0.0, 0.5, 0.5, 0.0, 0.5, 0.5]), "Row 1.*not above 0"),
        (spoil(dn=[10, 20, np.nan, 11, 15, 6]), "Row 3, panel far, has no DN"),
        (spoil(distance=[4, 4, -8, 4, 6, 8]), "range that is not above 0"),
        (spoil(reflectance_sigma=[0, 0, 0, -1, 0, 0]), "σ of the reflectance"),
        (replace(table(), dn_sigma=np.array([1, 1, 0, 1, 1, 1.0])), "σ of the DN not above 0"),
    ],
)
def test_bad_numbers_are_told(spoilt: PanelTable, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        check_panels(spoilt)


def test_a_panel_there_twice_is_told_with_its_rows() -> None:
    twice = replace(table(), scan=np.array(["a"] * 6))
    with pytest.raises(BadInput, match=r"grey is there twice in scan a at 4 m: rows 1 and 4"):
        check_panels(twice)


def test_an_empty_table_is_refused() -> None:
    with pytest.raises(BadInput, match="no rows"):
        check_panels(table().pick(np.zeros(6, bool)))


def test_percent_becomes_fractions_once() -> None:
    percent = replace(table(), reflectance=table().reflectance * 100)
    assert to_fractions(percent).reflectance == pytest.approx(table().reflectance)
    with pytest.raises(BadInput, match="Leave --percent out"):
        to_fractions(table())


def test_fixed_panels_are_those_all_scans_saw_at_one_range() -> None:
    assert find_fixed_panels(table()) == ("grey", "far")
    assert find_fixed_panels(table().pick(table().scan == "a")) == ()


def test_places_of_scans_and_panels() -> None:
    assert table().scans == ("a", "b")
    assert table().index_panels().tolist() == [0, 1, 2, 0, 1, 2]
    assert table().pick(table().scan == "b").index_scans().tolist() == [0, 0, 0]

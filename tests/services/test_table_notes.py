"""What is said about numbers of a table: gaps, radians, negative angles."""

from __future__ import annotations

import numpy as np
import pytest

from app.services.table_notes import tell_missing, tell_negative, tell_radians

NAN = np.nan


def test_rows_without_a_number_are_counted_once() -> None:
    columns = {"w": np.array([0.0, NAN, NAN, 3.0]), "i": np.array([1.0, NAN, 2.0, 3.0])}
    assert tell_missing("t.csv", columns) == ("t.csv: 2 rows have no number in w or i.",)
    only = {"w": np.array([0.0, NAN]), "i": np.ones(2)}
    assert tell_missing("t.csv", only) == ("t.csv: 1 row has no number in w.",)
    assert tell_missing("t.csv", {"i": np.ones(3)}) == ()


@pytest.mark.parametrize(
    ("angles", "told"),
    [
        ([0.0, 0.3, 0.8, 1.57, NAN], True),
        ([-1.5, -0.5, 0.5, 1.5], True),
        ([0.0, 0.3, 1.2], False),
        ([0.0, 0.3, 0.8, 1.7], False),
        ([1.0, 1.0, 1.0, 1.0, 1.0], False),
        ([NAN], False),
    ],
)
def test_radians_are_guessed(angles: list[float], told: bool) -> None:
    said = tell_radians("w", np.array(angles))
    assert bool(said) is told
    assert all("look like radians; degrees are expected." in text for text in said)


def test_negative_angles_are_those_of_a_holder() -> None:
    (said,) = tell_negative(np.array([-10.0, 0.0, NAN]))
    assert "incidence_mean_deg" in said
    assert tell_negative(np.array([0.0, NAN])) == ()

"""CSV: every number comes back bit by bit, and no spreadsheet meets a formula."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from app.core.errors import BadInput
from app.core.progress import QUIET
from app.formats import csv_table, text
from app.formats.cloud import Cloud
from app.formats.options import ReadOptions
from app.formats.saving import save
from app.model.scan import Scan

TYPES = [np.float64, np.float32, np.int64, np.uint64, np.uint8, np.bool_]


@given(
    xyz=arrays.arrays(np.float64, (3, 3)),
    values=st.sampled_from(TYPES).flatmap(lambda dtype: arrays.arrays(dtype, 3)),
    name=st.text(min_size=1, max_size=12),
)
def test_round_trip(
    tmp_path_factory: pytest.TempPathFactory, xyz: np.ndarray, values: np.ndarray, name: str
) -> None:
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    save(path, Cloud(Scan("s", xyz, {name: values})), csv_table.write)
    (scan,) = text.read(path, ReadOptions(), QUIET)
    np.testing.assert_array_equal(scan.xyz, xyz)
    assert np.array_equal(np.signbit(scan.xyz[~np.isnan(xyz)]), np.signbit(xyz[~np.isnan(xyz)]))
    (got,) = scan.attributes.values()
    if list(scan.attributes) == [name]:
        assert got.dtype == values.dtype
        np.testing.assert_array_equal(got, values)
    else:  # no text file can hold the name, and with it goes the type
        assert name == "-" or not name.isprintable()
        np.testing.assert_allclose(got, values.astype(np.float64), rtol=1e-6, atol=1e-44)


@pytest.mark.parametrize("name", ["=1+1", "+a", "-a", "@a", "a,b", "Reflectance (dB)", "x"])
def test_names(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.csv"
    save(path, Cloud(Scan("s", np.ones((1, 3)), {name: np.ones(1)})), csv_table.write)
    with path.open(newline="") as file:
        written = next(csv.reader(file))
    assert not written[3].startswith(("=", "+", "-", "@"))
    (scan,) = text.read(path, ReadOptions(), QUIET)
    assert list(scan.attributes) == [name]


def test_words_are_refused(tmp_path: Path) -> None:
    cloud = Cloud(Scan("s", np.ones((1, 3)), {"kind": np.array(["leaf"])}))
    with pytest.raises(BadInput, match="kind holds"):
        save(tmp_path / "a.csv", cloud, csv_table.write)
    assert list(tmp_path.iterdir()) == []

"""Series of scans: made, corrected, undone, stored; what cannot be is refused."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from app.core.errors import WrongUse
from app.formats import session
from app.model.codec import decode, encode
from app.model.events import Change
from app.model.history import Entry
from app.model.operations import AddScan, PutSeries
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan
from app.model.series import Correction, HolderAxis, Series, SeriesEntry
from app.model.view_state import ViewState

AXIS = HolderAxis((4.0, 0.0, 1.2), (0.0, 0.0, 1.0), "picked")
ENTRIES = (
    SeriesEntry("scan-00001", angle_deg=0.0),
    SeriesEntry("scan-00002", angle_deg=30.0, hours=1.5, treatment="dry", label="second"),
)
SERIES = Series("series-00001", "stage", ENTRIES, "scan-00001", AXIS)
SOME = PointSet([3, 1, 2])


@pytest.fixture
def project() -> Project:
    project = Project()
    for name in ("a", "b"):
        key = project.shelve(Scan(name, np.zeros((9, 3))))
        project.do(AddScan(key, name, None))
    return project


def test_a_series_is_made_corrected_and_undone(project: Project) -> None:
    seen: list[Change] = []
    project.changed.connect(seen.append)
    project.do(PutSeries(SERIES.key, SERIES))
    assert seen[-1].aspects == {"series"}
    corrected = SERIES.correct("scan-00002", "leaf-00001", SOME)
    project.do(PutSeries(SERIES.key, corrected, "Correct a leaf in"))
    assert project.history.done[-1].title == "Correct a leaf in series stage (2 scans)"
    assert project.state.series[SERIES.key].entry("scan-00002").corrected("leaf-00001") == SOME
    project.undo()
    assert project.state.series[SERIES.key] == SERIES
    project.undo()
    assert not project.state.series
    project.redo()
    project.redo()
    assert project.state.series[SERIES.key] == corrected
    project.do(PutSeries(SERIES.key, None))
    assert project.history.done[-1].title == "Forget series"
    project.undo()
    assert project.state.series[SERIES.key] == corrected


def test_a_correction_replaces_the_one_before_it_and_goes_with_none() -> None:
    once = SERIES.correct("scan-00002", "leaf-00001", SOME)
    twice = once.correct("scan-00002", "leaf-00001", PointSet())
    assert twice.entry("scan-00002").corrections == (Correction("leaf-00001", PointSet()),)
    assert twice.entry("scan-00002").corrected("leaf-00002") is None
    assert twice.correct("scan-00002", "leaf-00001", None) == SERIES


def test_sessions_keep_series(project: Project, tmp_path: Path) -> None:
    step = PutSeries(SERIES.key, SERIES.correct("scan-00002", "leaf-00001", SOME), "Correct")
    arrays: dict[str, np.ndarray] = {}
    assert decode(encode(step, arrays, "s"), arrays) == step
    file = tmp_path / "s.leafscope"
    session.write(file, session.Session({}, [Entry("do", step)], ViewState()))
    assert session.read(file).log == [Entry("do", step)]
    project.do(step)
    again = Project()
    for key, scan in project.state.library.items():
        again.shelve(scan, key)
    again.restore(project.history.log)
    assert again.state.series == project.state.series


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"key": "series-00002"}, "no key"),
        ({"reference": "scan-00003"}, "not in the series"),
        ({"entries": (*ENTRIES, SeriesEntry("scan-00003"))}, "no scan scan-00003"),
        ({"entries": (*ENTRIES, SeriesEntry("scan-00001"))}, "twice"),
        (
            {"entries": SERIES.correct("scan-00002", "leaf-00001", PointSet([9])).entries},
            "not all in",
        ),
    ],
)
def test_what_cannot_be_is_refused(project: Project, change: dict[str, object], says: str) -> None:
    with pytest.raises(WrongUse, match=says):
        project.do(PutSeries(SERIES.key, msgspec.structs.replace(SERIES, **change)))
    assert not project.state.series


def test_numbers_that_are_none() -> None:
    with pytest.raises(WrongUse, match="angle"):
        SeriesEntry("scan-00001", angle_deg=np.nan)
    with pytest.raises(WrongUse, match="time"):
        SeriesEntry("scan-00001", hours=np.inf)

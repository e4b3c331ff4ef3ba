"""A session with a formula of one's own opens where nobody knows the formula."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import LeafscopeError
from app.core.phase.formula_model import FormulaDefinition, FormulaParameter
from app.formats import session as container
from app.formats.session import Session
from app.model.fit_method import Method
from app.model.history import Entry
from app.model.operations import SetParameters
from app.model.parameters import Curve, Parameters
from app.model.view_state import ViewState
from app.services.curves import fit_leaves, result_of, use_fit
from app.services.lab.fit_table import each_leaf, record_fits, tabulate_fits
from app.services.lab.own_models import delete_own, save_own
from app.services.leaves import leaves_from_labels
from app.services.opening import Opening, open_file
from app.services.sessions import open_session, replay, save_session

KEY = "scan-00001"
OWN = FormulaDefinition(
    "own", "a*(cos(omega) + s*omega)",
    (FormulaParameter("a", (0.1, 2.0), 0.0, scales=True), FormulaParameter("s", (0.0, 0.5))),
)  # fmt: skip


@pytest.fixture
def file(leaves_file: Path, tmp_path: Path) -> Path:
    folder = tmp_path / "data"
    shutil.copytree(leaves_file.parent, folder)
    return folder / leaves_file.name


def test_formulas_methods_and_tables_come_back(file: Path, tmp_path: Path) -> None:
    project, _ = open_file(Opening(file))
    project.set_parameters(KEY, radius=0.02)
    keys = leaves_from_labels(project, KEY, "truth_leaf")
    save_own(OWN)
    record = fit_leaves(project, KEY, keys[2:4], "own", method=Method("bins"))
    use_fit(project, record)
    robust = Method(loss="huber")
    fit_leaves(project, KEY, keys[2:4], "lambert", method=robust, fixed={"f": 0.4})
    fit_leaves(project, KEY, (), "cosine")
    table = tabulate_fits(
        project, KEY, each_leaf(project, KEY, keys[2:]), ("reflectance_1063", "reflectance_1545"),
        "lambert-beckmann",
    )  # fmt: skip
    count = len(record_fits(project, table))
    assert count == 8
    residual = project.field(KEY, "residual")
    path = tmp_path / "s.leafscope"
    save_session(project, ViewState(current=KEY), path)

    delete_own("own")
    again, _ = open_session(path)
    kept = again.state.fits[record.key]
    assert result_of(kept) == result_of(record)
    assert result_of(kept).formula == OWN
    assert kept.method == Method("bins")
    curve = again.state.scan(KEY).parameters.curve
    assert curve is not None
    assert curve.formula == OWN
    np.testing.assert_array_equal(again.field(KEY, "residual"), residual)
    assert np.isfinite(residual).any()
    verdicts = replay(path, tmp_path / "replayed")["fits"]
    assert [one["same"] for one in verdicts] == [True] * (3 + count)


def test_a_session_from_before_opens_and_its_fits_are_as_usual() -> None:
    from app.model.codec import decode, encode
    from app.model.leaf import FitRecord
    from app.model.operations import PutFit

    record = FitRecord("fit-00001", KEY, (), "near", "lambert", {})
    text = encode(PutFit("fit-00001", record), {}, "x").decode()
    old = text.replace(',"method":null,"fixed":{}', "")
    assert old != text
    back = decode(old, {})
    assert isinstance(back, PutFit)
    assert back.fit is not None
    assert back.fit.method_used == Method("bins", angles=(0.0, 80.0))


@pytest.mark.parametrize(
    "expression", ["a*__import__('os').getcwd()*omega", "a*omega" + "*s" * 400, "a*s*(omega"]
)
def test_a_hostile_formula_in_a_session_is_never_run(
    file: Path, tmp_path: Path, expression: str
) -> None:
    project, _ = open_file(Opening(file))
    bad = FormulaDefinition("own", expression, OWN.parameters)
    curve = Curve("own", {"a": 1.0, "s": 0.1}, "reflectance_1063", formula=bad)
    log = [*project.history.log, Entry("do", SetParameters(KEY, Parameters(curve=curve)))]
    source = project.state.library[KEY].source
    assert source is not None
    path = tmp_path / "bad.leafscope"
    container.write(path, Session({KEY: source}, log, ViewState()))
    opened, _ = open_session(path)
    with pytest.raises(LeafscopeError):
        opened.field(KEY, "residual", np.arange(3))

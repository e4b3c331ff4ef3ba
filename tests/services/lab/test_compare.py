"""Models side by side, and how sure their parameters are."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.core.phase import MODELS, get_model
from app.core.phase.formula_model import FormulaDefinition, FormulaParameter
from app.model.fit_method import Method
from app.services.lab.compare import compare
from app.services.lab.method import fit_by
from app.services.lab.own_models import save_own
from app.services.lab.uncertainty import describe_parameters, profile

ANGLE = np.repeat(np.arange(0.0, 81.0, 5.0), 20)
VALUE = get_model("lambert-beckmann").evaluate(
    np.deg2rad(ANGLE), {"f": 0.5, "k_d": 0.5, "m": 0.3}
) * (1.0 + 0.02 * np.random.default_rng(3).standard_normal(len(ANGLE)))
OWN = FormulaDefinition(
    "own", "a*cos(omega)**p",
    (FormulaParameter("a", (0.1, 2.0), 0.0, scales=True), FormulaParameter("p", (0.2, 3.0))),
)  # fmt: skip


def test_the_model_that_made_the_data_is_best() -> None:
    table = compare(ANGLE, VALUE)
    assert [row.model for row in table.rows] == list(MODELS)
    assert table.best is not None
    assert table.best.model == "lambert-beckmann"
    assert table.best.aicc_above == 0.0
    assert sum(row.weight or 0.0 for row in table.rows) == pytest.approx(1.0)
    n = len(ANGLE)
    for row in table.rows:
        assert row.rss is not None
        assert row.k is not None
        assert row.aic == pytest.approx(n * np.log(row.rss / n) + 2 * (row.k + 1))
        assert row.bic == pytest.approx(n * np.log(row.rss / n) + np.log(n) * (row.k + 1))
    assert table.note == ""


def test_models_of_ones_own_stand_beside_them() -> None:
    save_own(OWN)
    rows = compare(ANGLE, VALUE, method=Method("bins")).rows
    assert [row.model for row in rows] == [*MODELS, "own"]
    assert rows[-1].n == 17
    assert rows[-1].result is not None
    assert [row.model for row in compare(ANGLE, VALUE, ["lambert", OWN]).rows] == ["lambert", "own"]


def test_what_is_to_be_kept_in_mind_is_told() -> None:
    many = compare(np.tile(ANGLE, 4), np.tile(VALUE, 4), ["lambert"])
    assert "no independent measurements" in many.note
    assert "not as they are fitted" in compare(ANGLE, VALUE, ["lambert"], Method("edge")).note
    few = compare(ANGLE[:41:20], VALUE[:41:20], ["lambert", "lambert-beckmann"]).rows
    assert few[0].n == 3
    assert few[1].n is None
    assert "needs more pairs" in few[1].words[0]
    with pytest.raises(BadInput, match="no pair"):
        compare(ANGLE, VALUE, method=Method(angles=(85.0, 90.0)))


def test_parameters_in_words() -> None:
    found = fit_by(Method(), "lambert-beckmann", ANGLE, np.cos(np.deg2rad(ANGLE)))
    f, k_d, m = describe_parameters(found)
    assert (f.value, f.words) == (pytest.approx(1.0), "")
    assert k_d.at_bound
    assert "at its bound" in k_d.words
    assert (m.value, m.low) == (None, None)
    assert "undetermined" in m.words


def test_profiles_hold_the_plain_interval_where_the_curve_is_nearly_straight() -> None:
    result = fit_by(Method("bins"), "lambert-beckmann", ANGLE, VALUE)
    rows = profile(Method("bins"), "lambert-beckmann", ANGLE, VALUE)
    assert [row.name for row in rows] == ["f", "k_d", "m"]
    for row in rows:
        assert (row.low, row.high) == pytest.approx(result.interval(row.name), rel=0.05)
        assert row.words == ""


def test_profiles_say_what_the_data_do_not_limit() -> None:
    noise = 0.02 * np.random.default_rng(0).standard_normal(len(ANGLE))
    rows = profile(Method(), "lambert-beckmann", ANGLE, np.cos(np.deg2rad(ANGLE)) + noise)
    said = {row.name: row.words for row in rows}
    assert said == {
        "f": "",
        "k_d": "k_d may lie at its bound, 1.",
        "m": "The data do not limit m at all.",
    }
    for method, model, says in (
        (Method("edge"), "lambert", "least squares"),
        (Method(), OWN, "formula"),
    ):
        with pytest.raises(WrongUse, match=says):
            profile(method, model, ANGLE, VALUE)


def test_exact_models_are_named_and_not_ranked() -> None:
    table = compare(ANGLE, np.cos(np.deg2rad(ANGLE)))
    assert table.best is not None
    assert table.best.model == "lambert"
    assert table.best.exact
    assert (table.best.aic, table.best.weight) == (None, None)
    assert "Lambert has the fewest parameters" in table.note
    one = compare(ANGLE, np.cos(np.deg2rad(ANGLE)), ["lambert", "cosine"])
    assert one.note.startswith("Lambert runs through all points exactly")
    two = compare(ANGLE, np.ones(len(ANGLE)), ["cosine", "cosine"])
    assert two.best is None
    assert "None of these has fewer" in two.note


def test_too_few_pairs_for_some_are_told() -> None:
    table = compare(ANGLE[:160:20], VALUE[:160:20])
    assert table.best is None
    assert table.note.startswith("Too few pairs for the parameters of Fourier")
    assert table.note.endswith("no weights and no best.")
    assert all(row.weight is None for row in table.rows)

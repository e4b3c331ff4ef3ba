"""What rests on the curve in use: the residual, and when it must be computed anew."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from app.core.errors import BadInput, MissingChannel, WrongUse
from app.core.phase import get_model
from app.core.phase.formula_model import FormulaDefinition, FormulaParameter
from app.model.fields import Computed, Values, fingerprint
from app.model.parameters import Curve
from app.model.project import Project
from app.model.scene import default_limits, resolve
from app.model.view_state import ViewState

Build = Callable[..., tuple[Project, str]]
TRUTH = {"f": 2.0, "k_d": 0.7, "m": 0.3}
OWN = FormulaDefinition("own", "a*cos(omega)", (FormulaParameter("a", (0.1, 3.0), scales=True),))


@pytest.fixture
def seen(build: Build) -> tuple[Project, str, np.ndarray, np.ndarray]:
    """Points at known angles whose values lie a known distance from a curve."""
    angle = np.array([0.0, 10.0, 35.0, 60.0, 89.0, 90.0, np.nan])
    away = np.array([0.1, -0.2, 0.0, 0.3, -0.1, 1.0, 1.0])
    curve = get_model("lambert-beckmann").evaluate(np.deg2rad(np.nan_to_num(angle)), TRUTH)
    xyz = np.random.default_rng(1).normal(5.0, 1.0, (len(angle), 3))
    project, key = build(xyz, {"near": curve + away, "other": np.ones(len(angle))})
    held = Values.empty(
        fingerprint(project.catalogue(key), "incidence", project.subject(key)), len(angle)
    )
    held.fill(None, Computed(angle))
    project.accept(key, {"incidence": held})
    return project, key, angle, away


def use(project: Project, key: str, **changes: object) -> None:
    curve = {"model": "lambert-beckmann", "values": TRUTH, "channel": "near"} | changes
    project.set_parameters(key, curve=Curve(**curve))  # type: ignore[arg-type]


def test_the_residual_is_what_the_curve_leaves(
    seen: tuple[Project, str, np.ndarray, np.ndarray],
) -> None:
    project, key, _, away = seen
    use(project, key)
    found = project.field(key, "residual")
    np.testing.assert_allclose(found[:5], away[:5], atol=1e-12)
    assert np.isnan(found[5:]).all()
    held = project.known_field(key, "residual")
    assert held is not None
    assert held.notes["undefined"] == 2
    assert held.notes["rms"] == pytest.approx(np.sqrt((away[:5] ** 2).mean()))
    some = project.field(key, "residual", np.array([3, 5]))
    np.testing.assert_allclose(some, [0.3, np.nan], atol=1e-12)


def test_there_is_none_beyond_the_angles_of_the_curve(
    seen: tuple[Project, str, np.ndarray, np.ndarray],
) -> None:
    project, key, angle, _ = seen
    use(project, key, within=(np.deg2rad(5.0), np.deg2rad(40.0)))
    known = np.isfinite(project.field(key, "residual"))
    assert known.tolist() == [5.0 <= a <= 40.0 for a in angle]


def test_it_has_the_unit_and_title_of_the_channel_and_zero_in_the_middle(
    seen: tuple[Project, str, np.ndarray, np.ndarray],
) -> None:
    project, key, _, _ = seen
    assert project.catalogue(key)["residual"].unit == ""
    use(project, key)
    spec = project.catalogue(key)["residual"]
    assert (spec.unit, spec.kind, spec.title) == ("DN", "signed", "Residual of the curve, near")
    project.field(key, "residual")
    (cloud,) = resolve(project, ViewState(current=key, colour="residual")).clouds
    assert cloud.bar is not None
    assert cloud.bar.map == "residual"
    assert cloud.bar.low == -cloud.bar.high < 0
    assert default_limits(np.zeros(5), "signed") == (-1.0, 1.0)
    assert default_limits(np.array([1e-9, -3e-9]), "signed")[1] < 4e-9


def test_it_is_computed_anew_when_curve_or_channel_change(
    seen: tuple[Project, str, np.ndarray, np.ndarray],
) -> None:
    project, key, _, _ = seen
    use(project, key)
    first = project.field(key, "residual")
    project.set_parameters(key, ghost_threshold=0.2)
    assert project.known_field(key, "residual") is not None
    use(project, key, channel="other")
    assert project.known_field(key, "residual") is None
    assert project.catalogue(key)["residual"].title.endswith("other")
    assert not np.allclose(project.field(key, "residual")[:5], first[:5])


def test_a_curve_of_a_channel_that_is_gone_and_no_curve_say_so(
    seen: tuple[Project, str, np.ndarray, np.ndarray],
) -> None:
    project, key, _, _ = seen
    for field in ("residual", "incidence_from_intensity"):
        project.set_parameters(key, curve=None)
        with pytest.raises(BadInput, match="No angular curve"):
            project.field(key, field)
        for wrong in ("gone", "residual", "incidence_from_intensity"):
            use(project, key, channel=wrong)
            with pytest.raises(MissingChannel, match="no channel"):
                project.field(key, field)


def test_a_formula_is_a_curve_like_the_others(
    seen: tuple[Project, str, np.ndarray, np.ndarray],
) -> None:
    project, key, angle, _ = seen
    use(project, key, model="own", values={"a": 2.0}, formula=OWN)
    value = project.field(key, "near")
    expected = value[:5] - 2.0 * np.cos(np.deg2rad(angle[:5]))
    np.testing.assert_allclose(project.field(key, "residual")[:5], expected, atol=1e-12)
    found = project.field(key, "incidence_from_intensity")[2]
    assert found == pytest.approx(np.rad2deg(np.arccos(value[2] / 2.0)))
    use(project, key, model="own", values={}, formula=OWN)
    assert np.isnan(project.field(key, "residual")).all()
    bad = FormulaDefinition("own", "a*open(omega)", OWN.parameters)
    use(project, key, model="own", values={"a": 2.0}, formula=bad)
    with pytest.raises(WrongUse, match="not allowed"):
        project.field(key, "residual")

"""A preview of corrections: numbers of the command line, nothing put to use but on the copy."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.core.workflows.chain import correct
from app.model.corrections import Correction
from app.model.operations import SetDeleted
from app.model.project import Project
from app.model.scan import Scan
from app.services.corrections import apply_corrections
from app.services.leaves import leaves_from_labels
from app.services.opening import add_scans
from app.services.workflow_preview import TOGETHER, Order, average_steps, preview_workflows
from app.services.workflow_table import Wanted, compare_workflows, correct_leaves
from app.simulate.scenes import leaf_row_scan

NIR, SWIR = "reflectance_1063", "reflectance_1545"


@pytest.fixture(scope="module")
def row() -> Scan:
    return leaf_row_scan(step_deg=0.06, noise_m=0.0004, seed=2)


@pytest.fixture
def opened(row: Scan) -> tuple[Project, str]:
    project = Project()
    (key,) = add_scans(project, [row])
    leaves_from_labels(project, key, "truth_leaf")
    return project, key


def aside(project: Project) -> Project:
    copy = Project()
    copy.state = project.state
    return copy


@pytest.mark.parametrize(("source", "fit_to"), [("together", "all"), ("each", "leaf")])
def test_it_foretells_what_correcting_gives(
    opened: tuple[Project, str], source: str, fit_to: str
) -> None:
    project, key = opened
    before = project.state
    found = preview_workflows(aside(project), key, Order((NIR, SWIR), ("wf2", "wf3"), source))
    assert project.state is before
    correct_leaves(project, key, Wanted(fit_to=fit_to))
    rows = compare_workflows(project, key)
    assert [row for row in found.rows if row["leaf"] != TOGETHER] == rows
    assert found.corrections == project.state.scan(key).parameters.corrections


def test_the_row_of_all_and_the_marks_count_every_point(opened: tuple[Project, str]) -> None:
    found = preview_workflows(*opened, Order((NIR,), ("wf2",)))
    (whole,) = [row for row in found.rows if row["leaf"] == TOGETHER]
    parts = [row for row in found.rows if row["leaf"] != TOGETHER]
    for name in ("points", "wf1_n", "wf2_n", "wf2_marked"):
        assert whole[name] == sum(row[name] for row in parts)
    counts = found.marks[NIR, "wf2"]
    assert sum(counts.values()) == whole["points"]
    assert sum(counts.values()) - counts["good"] == whole["wf2_marked"]
    assert whole["wf2_cv"] == pytest.approx(whole["wf2_sd"] / whole["wf2_mean"])
    before, after = found.steps[NIR, "wf1"], found.steps[NIR, "wf2"]
    swing = [np.ptp(steps.mean[steps.angle < 50.0]) for steps in (before, after)]
    assert swing[1] < 0.7 * swing[0]


def test_typed_numbers_go_to_the_workflow_that_takes_them(opened: tuple[Project, str]) -> None:
    project, key = opened
    values = {"b": 0.9, "k_d": 0.8, "m": 0.3}
    found = preview_workflows(
        project, key, Order((NIR,), ("wf2", "wf3"), "typed", values=values, least_bracket=0.4)
    )
    assert [each.values for each in found.made] == [{"b": 0.9}, {"k_d": 0.8, "m": 0.3}]
    assert {each.least_bracket for each in found.made} == {0.4}
    leaf = project.state.leaves_of(key)[1]
    angle = np.deg2rad(project.field(key, "incidence", leaf.members.indices))
    value = project.field(key, NIR, leaf.members.indices)
    expected = correct("wf2", value, angle, {"b": 0.9}, found.made[0].limits).values
    row = next(row for row in found.rows if row["leaf"] == leaf.key)
    assert row["wf2_mean"] == pytest.approx(np.nanmean(expected))


def test_published_numbers_need_their_wavelength(opened: tuple[Project, str]) -> None:
    project, key = opened
    found = preview_workflows(aside(project), key, Order((SWIR,), ("wf2",), "published",
                                                         species="birch"))  # fmt: skip
    assert found.made[0].values == {"b": 2.3}
    with pytest.raises(WrongUse, match="1063 nm"):
        preview_workflows(aside(project), key, Order((NIR,), ("wf2",), "published",
                                                     species="birch"))  # fmt: skip


def test_without_workflows_it_shows_what_is_in_use(opened: tuple[Project, str]) -> None:
    project, key = opened
    apply_corrections(project, key, [Correction(NIR, "wf2", {"b": 1.0})])
    found = preview_workflows(aside(project), key, Order((NIR,), ()))
    assert found.made == ()
    assert "wf2_mean" in found.rows[0]


def test_some_leaves_or_the_whole_scan(opened: tuple[Project, str]) -> None:
    project, key = opened
    some = tuple(leaf.key for leaf in project.state.leaves_of(key))[:2]
    found = preview_workflows(aside(project), key, Order((NIR,), ("wf2",), leaves=some))
    assert found.made[0].leaves == some
    assert [row["leaf"] for row in found.rows] == [TOGETHER, *some]
    whole = preview_workflows(aside(project), key, Order((NIR,), ("wf2",), leaves=()))
    assert whole.made[0].leaves == ()
    assert [row["name"] for row in whole.rows] == ["whole scan"]
    assert whole.rows[0]["points"] == project.state.scan(key).shown


def test_newer_corrections_take_the_place_of_those_of_the_same_leaves(
    opened: tuple[Project, str],
) -> None:
    project, key = opened
    one, two, three = (leaf.key for leaf in project.state.leaves_of(key)[:3])

    def used() -> list[tuple[float, tuple[str, ...]]]:
        return [(c.values["b"], c.leaves) for c in project.state.scan(key).parameters.corrections]

    def apply(b: float, *leaves: str) -> None:
        made = [Correction(NIR, "wf2", {"b": b}, leaves=leaves)]
        apply_corrections(project, key, made, instead=True)

    apply(0.1, one, two)
    apply(0.2, two, three)
    assert used() == [(0.1, (one,)), (0.2, (two, three))]
    apply(0.3, one)
    assert used() == [(0.2, (two, three)), (0.3, (one,))]
    apply(0.4)
    assert used() == [(0.4, ())]


def test_nothing_to_fit_is_refused(opened: tuple[Project, str]) -> None:
    project, key = opened
    lone = project.state.leaves_of(key)[0]
    project.do(SetDeleted(key, lone.members, True))
    with pytest.raises(BadInput, match="No leaf could be corrected"):
        preview_workflows(aside(project), key, Order((NIR,), ("wf2",), leaves=(lone.key,)))


def test_means_per_step_are_those_of_the_points() -> None:
    random = np.random.default_rng(3)
    angle, value = random.uniform(0, 95, 500), random.normal(1.0, 0.1, 500)
    value[::50] = np.nan
    found = average_steps(angle, value)
    for k, low in enumerate(range(0, 80, 5)):
        inside = (angle >= low) & (angle < low + 5) & np.isfinite(value)
        assert found.mean[k] == pytest.approx(value[inside].mean())
        assert found.sd[k] == pytest.approx(value[inside].std(ddof=1))
        assert found.angle[k] == pytest.approx(angle[inside].mean())
    assert len(found.mean) == 16

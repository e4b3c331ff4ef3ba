"""Many fits at once give the numbers and words of fits one by one."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.arrays import Floats
from app.core.errors import BadInput, Cancelled, WrongUse
from app.core.fitting import FitBatch, fit, fit_many
from app.core.fitting.linear import solve_bounded
from app.core.phase import MODELS, PhaseModel
from app.core.progress import LiveProgress
from app.core.units import to_radians

STEPS = to_radians(np.arange(0.0, 81.0, 5.0))
BECKMANN = MODELS["lambert-beckmann"]


@pytest.fixture(params=MODELS.values(), ids=MODELS.keys())
def model(request: pytest.FixtureRequest) -> PhaseModel:
    return request.param


def make_values(model: PhaseModel, angle: Floats, groups: int, seed: int = 0) -> Floats:
    """Noisy curves of different sizes."""
    rng = np.random.default_rng(seed)
    curves = [model.evaluate(angle, model.random(rng, 10.0**i)) for i in range(groups)]
    noise = 1 + 0.06 * rng.standard_normal((groups, len(angle)))
    return np.array(curves) * noise


def compare(batch: FitBatch, one_by_one: list[tuple[Floats, Floats, Floats | None]]) -> None:
    for i, (angle, value, weight) in enumerate(one_by_one):
        single = fit(batch.model, angle, value, weights=weight)
        for p, name in enumerate(batch.names):
            estimate = single.parameters[name]
            assert batch.values[i, p] == pytest.approx(single.values[name], rel=1e-9, nan_ok=True)
            sd = np.nan if estimate.sd is None else estimate.sd
            assert batch.sd[i, p] == pytest.approx(sd, rel=1e-6, nan_ok=True)
            assert batch.at_bound[i, p] == estimate.at_bound
        assert batch.rss[i] == pytest.approx(single.rss, rel=1e-10)
        assert batch.n[i] == single.n
        assert batch.words(i) == single.warnings
        assert batch.result(i).values == pytest.approx(single.values, rel=1e-9, nan_ok=True)


def test_shared_angles(model: PhaseModel) -> None:
    value = make_values(model, STEPS, 12)
    compare(fit_many(model, STEPS, value), [(STEPS, row, None) for row in value])


def test_angles_and_weights_of_their_own(model: PhaseModel) -> None:
    rng = np.random.default_rng(1)
    angle = np.sort(rng.uniform(0, 1.4, (9, 20)), axis=1)
    value = np.array([make_values(model, row, 1, i)[0] for i, row in enumerate(angle)])
    weight = rng.uniform(0.5, 3.0, value.shape)
    groups = list(zip(angle, value, weight, strict=True))
    compare(fit_many(model, angle, value, weight), groups)


def test_ragged_groups_of_very_different_sizes(model: PhaseModel) -> None:
    sizes = [7, 30, 8, 2000, 31, 300, 9]
    rng = np.random.default_rng(2)
    angle = [rng.uniform(0, 1.4, size) for size in sizes]
    value = [make_values(model, a, 1, i)[0] for i, a in enumerate(angle)]
    offsets = np.concatenate(([0], np.cumsum(sizes)))
    batch = fit_many(model, np.concatenate(angle), np.concatenate(value), offsets=offsets)
    compare(batch, [(a, v, None) for a, v in zip(angle, value, strict=True)])


def test_holes_are_left_out_of_their_groups_only() -> None:
    value = make_values(BECKMANN, STEPS, 5)
    value[1, 3] = np.nan
    value[3, 0] = np.inf
    batch = fit_many(BECKMANN, STEPS, value)
    compare(batch, [(STEPS, row, None) for row in value])
    assert batch.n.tolist() == [17, 16, 17, 16, 17]


def test_a_group_without_hope_does_not_stop_the_others() -> None:
    angle = np.concatenate((STEPS, STEPS[:2], np.full(9, 0.3), STEPS))
    value = np.concatenate((np.cos(STEPS), [1.0, 0.9], np.ones(9), np.cos(STEPS)))
    batch = fit_many(BECKMANN, angle, value, offsets=[0, 17, 19, 28, 28, 45])
    assert batch.refused.tolist() == [False, True, True, True, False]
    assert "more pairs" in batch.words(1)[0]
    assert "equal" in batch.words(2)[0]
    with pytest.raises(BadInput):
        batch.result(3)
    assert np.isnan(batch.column("m")[[0, 4]]).all()
    assert any("m is undetermined" in word for word in batch.words(0))


def test_each_group_may_have_its_own_fixed_parameter() -> None:
    value = make_values(BECKMANN, STEPS, 6) / 10.0 ** np.arange(6)[:, None]
    for name, held in {"m": np.linspace(0.2, 0.4, 6), "f": np.linspace(0.8, 1.1, 6)}.items():
        batch = fit_many(BECKMANN, STEPS, value, fixed={name: held})
        for i in range(6):
            single = fit(BECKMANN, STEPS, value[i], fixed={name: held[i]})
            assert batch.values[i] == pytest.approx(
                list(single.values.values()), rel=1e-8, nan_ok=True
            )
            assert batch.words(i) == single.warnings
    assert np.isnan(batch.sd[:, 0]).all()


def test_the_compiled_scan_solves_as_the_plain_one_does() -> None:
    from app.core.kernels.fit_scan import scan_groups

    rng = np.random.default_rng(3)
    endless = (5, -np.inf, np.inf)
    for columns, low, high in ((1, 0.0, np.inf), (2, 0.0, np.inf), (2, -0.1, 0.2), endless):
        table, target = rng.normal(size=(30, 8, columns, 11)), rng.normal(size=(30, 1, 11))
        root = rng.uniform(0.5, 2.0, (30, 11))
        bounds = np.broadcast_to([[[low] * columns, [high] * columns]], (1, 2, columns)).copy()
        found = np.empty((30, 8))
        scan_groups(table, target, root, bounds, found)
        weighted = table * root[:, None, None]
        _, rest = solve_bounded(weighted, target * root[:, None], bounds[0, 0], bounds[0, 1])
        np.testing.assert_allclose(found, (rest**2).sum(axis=-1), rtol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"angle": STEPS, "value": np.ones(17)}, "table of values"),
        ({"angle": STEPS[:5], "value": np.ones((3, 17))}, "needs 17 angles"),
        ({"angle": STEPS, "value": np.ones(17), "offsets": [0, 20]}, "last offset"),
        ({"angle": STEPS, "value": np.ones(17), "offsets": [0, 9, 5, 17]}, "must not fall"),
        ({"angle": STEPS, "value": np.ones((2, 17)), "weights": -np.ones(17)}, "negative"),
        ({"angle": STEPS, "value": np.ones((2, 17)), "fixed": {"m": np.full(3, 0.2)}}, "one for"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(arguments: dict[str, object], says: str) -> None:
    with pytest.raises(BadInput, match=says):
        fit_many("lambert-beckmann", **arguments)  # type: ignore[arg-type]


def test_a_fixed_parameter_beyond_its_bounds_is_refused() -> None:
    with pytest.raises(WrongUse, match="outside"):
        fit_many(BECKMANN, STEPS, np.ones((2, 17)), fixed={"m": np.array([0.2, 3.0])})


def test_a_batch_can_be_cancelled() -> None:
    with pytest.raises(Cancelled):
        fit_many(BECKMANN, STEPS, np.ones((9, 17)), progress=LiveProgress(print, lambda: True))


def test_no_groups_are_no_fits() -> None:
    batch = fit_many(BECKMANN, STEPS, np.empty((0, 17)))
    assert len(batch) == 0
    assert batch.sd.shape == (0, 3)

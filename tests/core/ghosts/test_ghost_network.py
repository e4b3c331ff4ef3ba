"""Networks: their files fit what they are fed with, and teaching one works."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.ghosts import BEAM, context, evidence, lay_out
from app.core.ghosts.network import Stored, build_network, load_network
from app.core.kernels import ghost_evidence
from app.services.bench.ghosts.training import teach


@pytest.mark.parametrize(
    ("name", "inputs"),
    [("glance", evidence.NAMES), ("judgement", context.NAMES), ("confidence", context.NAMES)],
)
def test_files_fit(name, inputs):
    network = load_network(name)
    assert network.weights[0].shape[0] == len(inputs)
    told = network.weigh(np.random.default_rng(0).normal(size=(50, len(inputs))).astype(np.float32))
    assert told.shape == (50,)
    assert ((told >= 0) & (told <= 1)).all()


def test_kernel_writes_what_is_named():
    assert len(evidence.NAMES) == ghost_evidence.COUNT


def _weigh_by_matrices(network, rows):
    signal = rows.astype(np.float64)
    for weight, offset in zip(network.weights[:-1], network.offsets[:-1], strict=True):
        signal = np.maximum(signal @ weight + offset, 0.0)
    logit = (signal @ network.weights[-1] + network.offsets[-1])[:, 0]
    return 1.0 / (1.0 + np.exp(-logit))


@pytest.mark.parametrize(
    ("count", "inputs", "hidden"), [(1, 1, (1, 1)), (64, 5, (3, 2)), (200, 8, (7, 4))]
)
def test_network_is_the_sum_of_its_layers(count, inputs, hidden):
    random = np.random.default_rng(count)
    sizes = (inputs, *hidden, 1)
    stored = Stored(
        "",
        tuple(map(str, range(inputs))),
        tuple(
            tuple(map(tuple, random.normal(size=shape).tolist()))
            for shape in itertools.pairwise(sizes)
        ),
        tuple(tuple(random.normal(size=size).tolist()) for size in sizes[1:]),
    )
    rows = random.normal(size=(count, inputs)).astype(np.float32)
    network = build_network(stored)
    assert network.weigh(rows) == pytest.approx(_weigh_by_matrices(network, rows), rel=1e-4)


def test_layers_that_do_not_fit_are_refused():
    one = ((1.0,),)
    with pytest.raises(WrongUse, match="cannot follow"):
        build_network(Stored("", ("a",), (((1.0,), (1.0,)), one, one), ((0.0,),) * 3))
    with pytest.raises(WrongUse, match="one number"):
        build_network(Stored("", ("a",), (one, one, ((1.0, 2.0),)), ((0.0,), (0.0,), (0.0, 0.0))))
    with pytest.raises(WrongUse, match="3 layers"):
        build_network(Stored("", ("a",), (one,), ((0.0,),)))


def test_rows_of_another_length_are_refused():
    with pytest.raises(WrongUse, match="does not fit"):
        load_network("judgement").weigh(np.zeros((4, 3), np.float32))


def test_teaching_finds_a_curved_border_and_is_repeatable():
    random = np.random.default_rng(3)
    rows = random.normal(size=(6000, 2)).astype(np.float32) * [5.0, 0.1] + [3.0, 0.0]
    truth = ((rows[:, 0] - 3.0) / 5.0) ** 2 + (rows[:, 1] / 0.1) ** 2 < 1.2
    one = teach("circle", ("a", "b"), rows, truth, (12, 6), 40, 256)
    told = build_network(one).weigh(rows.astype(np.float32)) > 0.5
    assert (told == truth).mean() > 0.97
    assert teach("circle", ("a", "b"), rows, truth, (12, 6), 40, 256) == one


def test_the_quick_way_is_the_plain_one(make_scene):
    scene = make_scene()
    image = lay_out(scene.xyz, np.zeros(3), scene.grid)
    everyone = np.arange(len(scene.xyz))
    places = evidence.find_doubtful(image, everyone, 0, len(everyone))
    network = load_network("glance")
    quick = evidence.glance(image, everyone, places, BEAM, network)
    plain = _weigh_by_matrices(network, evidence.gather(image, everyone, places, BEAM))
    assert np.abs(quick - plain).max() < 1e-4

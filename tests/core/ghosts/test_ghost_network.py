"""Networks: their files fit what they are fed with, and teaching one works."""

from __future__ import annotations

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


def test_network_is_the_sum_of_its_layers():
    stored = Stored(
        "", ("a", "b"), (((1.0, -2.0), (0.5, 1.0)), ((2.0,), (3.0,))), ((0.0, 1.0), (-1.0,))
    )
    rows = np.array([[1.0, 2.0], [-1.0, 0.5]], np.float32)
    hidden = np.maximum(rows @ [[1.0, -2.0], [0.5, 1.0]] + [0.0, 1.0], 0.0)
    logit = hidden @ [2.0, 3.0] - 1.0
    assert build_network(stored).weigh(rows) == pytest.approx(1 / (1 + np.exp(-logit)), rel=1e-6)


def test_layers_that_do_not_fit_are_refused():
    with pytest.raises(WrongUse, match="cannot follow"):
        build_network(Stored("", ("a",), (((1.0,), (1.0,)),), ((0.0,),)))
    with pytest.raises(WrongUse, match="one number"):
        build_network(Stored("", ("a",), (((1.0, 2.0),),), ((0.0, 0.0),)))


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
    plain = network.weigh(evidence.gather(image, everyone, places, BEAM))
    assert np.abs(quick - plain).max() < 1e-4

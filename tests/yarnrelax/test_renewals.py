# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Normal forces of some cells of a batch are renewed while other cells keep theirs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import RelaxCell
from stitchmesh.yarnrelax.collision.captured_search import ContactSearch
from stitchmesh.yarnrelax.energies.by_term import cell_energies
from stitchmesh.yarnrelax.friction.friction import Friction, FrictionTerm
from stitchmesh.yarnrelax.model import image_table
from stitchmesh.yarnrelax.model.image_table import joined_table, renew_images
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.renewal import renew_lagging
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.stockinette import periodic_patch

FIRST = np.array([True, False])
YARNS = [periodic_patch(1, 1), periodic_patch(1, 2)]


def batch() -> tuple[YarnSimulation, FrictionTerm]:
    """Two cells at rest on their contacts, whose yarns then slip."""
    quality = replace(PRESETS["draft"], precision="float64")
    given = [(yarns, YarnMaterial.named()) for yarns in YARNS]
    cells = [RelaxCell(shear=False)] * 2
    simulation = YarnSimulation(given, quality, device_named("cpu"), [Friction(0.2)], cells=cells)
    term = simulation.terms[0]
    assert isinstance(term, FrictionTerm)
    slip(simulation, 0)
    return simulation, term


def slip(simulation: YarnSimulation, seed: int) -> None:
    """Move all control points by about a fiftieth of a radius."""
    points = simulation.state.points.numpy()
    random = np.random.default_rng(seed)
    points[: simulation.model.point_count] += 0.02 * random.normal(size=(simulation.model.point_count, 3))
    simulation.state.points.assign(points)
    simulation.search_contacts()
    simulation.accept(np.ones(2, dtype=bool))


def energies(simulation: YarnSimulation, term: FrictionTerm) -> np.ndarray:
    return cell_energies(simulation.model, simulation.state, term)


def make_another_table(simulation: YarnSimulation) -> None:
    """Make the table of images again, as a search does for yarns that have outgrown it."""
    before = simulation.model.constants.images.image.numpy()
    renew_images(simulation.model, simulation.state.points)
    assert not np.array_equal(simulation.model.constants.images.image.numpy()[: len(before)], before)
    simulation.candidates.near.invalidate()
    generation = simulation.search.generation
    simulation.search = ContactSearch(simulation.model, simulation.state, simulation.candidates)
    simulation.search.generation = generation + 1
    simulation.search_contacts()


def test_a_cell_that_is_not_renewed_keeps_its_friction_to_the_last_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also if the table of images is made again, to which the pairs that are kept refer."""
    with monkeypatch.context() as patch:
        patch.setattr(image_table, "SPREAD", 0.0)  # for few images, so that another table has more of them
        simulation, term = batch()
        never_renewed = batch()
    before = energies(simulation, term)
    make_another_table(simulation)
    renewed = renew_lagging(simulation, FIRST)
    after = energies(simulation, term)
    assert renewed.tolist() == [True, False]
    assert after[1] == before[1] > 0.0
    assert after[0] != before[0]
    slip(simulation, 1)  # images of the pairs that were kept are still the right ones
    slip(never_renewed[0], 1)
    assert energies(simulation, term)[1] == pytest.approx(energies(*never_renewed)[1], rel=1e-12)  # float64


def test_a_cell_that_is_renewed_alone_has_the_contacts_that_a_renewal_of_all_gives_it() -> None:
    some, all_ = batch(), batch()
    renew_lagging(some[0], FIRST)
    renew_lagging(all_[0], np.ones(2, dtype=bool))
    assert energies(*some)[0] == energies(*all_)[0]


def test_a_cell_has_moved_until_it_is_renewed() -> None:
    simulation, term = batch()
    assert term.has_moved(simulation.state).tolist() == [True, True]
    renew_lagging(simulation, FIRST)
    assert term.has_moved(simulation.state).tolist() == [False, True]
    assert renew_lagging(simulation, FIRST).tolist() == [False, False]


def test_a_joined_table_has_the_images_of_both_and_takes_another_one_that_has_them() -> None:
    def table(*images: tuple[int, int]) -> wp.array:
        return wp.array(np.array(images, dtype=np.int32), dtype=wp.vec2i, device="cpu")

    first, other = table((0, 0), (0, 1)), table((0, 0), (1, 0), (0, 1))
    joined, number = joined_table(first, other)
    assert joined.numpy().tolist() == [[0, 0], [0, 1], [1, 0]]
    assert joined.numpy()[number].tolist() == other.numpy().tolist()
    assert joined_table(first, joined)[0] is joined

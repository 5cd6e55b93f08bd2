# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Periodic fabrics: a cell gives the same results as its tiling, for every choice of periodic images."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from stitchmesh.lattice import Lattice
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, yarn_energies, yarn_forces
from stitchmesh.yarnrelax.collision.captured_search import ContactSearch
from stitchmesh.yarnrelax.collision.narrow_phase import make_candidates
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.image_table import (
    CONTACT_RANGE,
    SPREAD,
    corners_of,
    has_images,
    near_images,
    renew_images,
)
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import neighbour_reach
from tests.yarnrelax.one_term import on_device
from tests.yarnrelax.stockinette import flat_patch, periodic_patch, shaken, woven_cell

LEAF = YarnMaterial.named("leaf")
COARSE = {"quadrature_points": 3, "contact_samples": 3}
POINTS = 12
"""Control points per stitch."""


def tiled(cell: YarnSet, rows: int, stitches: int) -> YarnSet:
    """A tiling of a cell of one stitch: row by row, with the stitches of a row one after another."""
    assert cell.lattice is not None
    u, v = cell.lattice.periods
    curves = [cell.points + stitch * u + row * v for row in range(rows) for stitch in range(stitches)]
    size = np.arange(rows + 1) * len(cell.points) * stitches
    number = np.arange(size[-1])
    return YarnSet(
        points=np.concatenate(curves),
        start=size,
        closed=np.ones(rows, dtype=bool),
        radius=np.repeat(cell.radius, rows),
        rest_length=np.tile(cell.rest_length, rows * stitches),
        row=number // (len(cell.points) * stitches),
        face=number // len(cell.points),
        part=number % len(cell.points),
        lattice=Lattice(np.stack([stitches * u, rows * v])),
        lattice_step=np.tile([1, 0], (rows, 1)),
    )


def rolled(yarns: YarnSet, first: int) -> YarnSet:
    """The same yarn beginning at control point ``first``; the points before ``first`` move on by the lattice step."""
    assert yarns.lattice is not None and yarns.lattice_step is not None
    step = yarns.lattice.shift(yarns.lattice_step[0])
    points = np.concatenate([yarns.points[first:], yarns.points[:first] + step])
    return replace(yarns, points=points, rest_length=np.roll(yarns.rest_length, -first))


def candidate_lists(yarns: YarnSet, margin: float) -> tuple[list[set[tuple[int, int, int]]], np.ndarray, Model]:
    """The candidate list of each sample as a set of (sample, image), the samples, and the model."""
    model = on_device(yarns)
    state, candidates = make_state(model), make_candidates(model, margin)
    ContactSearch(model, state, candidates).run()
    table = model.constants.images.image.numpy()
    count, lists = candidates.count.numpy(), candidates.lists.numpy()
    entries = [lists[p, : count[p]] for p in range(model.sample_count)]
    assert all(len(np.unique(row)) == len(row) for row in entries)
    places = [(row % model.sample_count, table[row // model.sample_count]) for row in entries]
    found = [{(int(q), int(a), int(b)) for q, (a, b) in zip(*place, strict=True)} for place in places]
    return found, state.samples.numpy(), model


def all_pairs(samples: np.ndarray, model: Model, margin: float) -> list[set[tuple[int, int, int]]]:
    """The definition of the lists, applied to every image: near samples that are not neighbours along a strand."""
    yarns = model.yarns
    assert yarns.lattice is not None and yarns.lattice_step is not None
    segment = np.repeat(np.arange(model.segment_count), np.diff(model.sample_start))
    yarn, skip = yarns.segment_yarn[segment], neighbour_reach(yarns)[segment]
    count = np.diff(yarns.segment_start)[yarn]
    limit = samples[:, 3, None] + samples[None, :, 3] + margin
    result: list[set[tuple[int, int, int]]] = [set() for _ in samples]
    for a in range(-4, 5):
        for b in range(-4, 5):
            shift = yarns.lattice.shift((a, b)) / model.unit
            near = cdist(samples[:, :3], samples[:, :3] + shift) < limit
            for turns in range(-4, 5):
                on_strand = (yarn[:, None] == yarn[None, :]) & (turns * yarns.lattice_step[yarn] == (a, b)).all(axis=1)
                ahead = segment[None, :] - segment[:, None] + turns * count[:, None]
                near &= ~on_strand | np.where(ahead >= 0, ahead > skip[:, None], -ahead > skip[None, :])
            for p, q in np.argwhere(near):
                result[p].add((int(q), a, b))
    return result


@pytest.mark.parametrize(
    "yarns",
    [shaken(periodic_patch(2, 1)), woven_cell()],
    ids=["knit", "woven"],
)
def test_lists_equal_all_pairs_of_all_images(yarns: YarnSet) -> None:
    found, samples, model = candidate_lists(yarns, 0.4)
    assert found == all_pairs(samples, model, 0.4)
    assert any(a or b for row in found for _, a, b in row)


def test_a_yarn_touches_its_images_in_a_cell_smaller_than_the_contact_range() -> None:
    """Parallel images of one straight yarn, each in contact with its neighbour on either side.

    The contact energy is E / L = 2 r k [(2 / d) atan(s / d) + 2 (d^2 - 2) s + 2/3 s^3] with s = sqrt(1 - d^2)
    (``test_yarn_closed_forms``); each of the two neighbours of a strand contributes half.
    """
    radius, delta = 0.125, 0.8
    line = np.stack([np.arange(8) * 0.1, np.zeros(8), np.zeros(8)], axis=1)
    yarns = replace(
        YarnSet.from_curves([line], closed=[True], radius=radius, rest_lengths=[np.full(8, 0.1)]),
        lattice=Lattice(np.array([[0.8, 0.0, 0.0], [0.0, 2 * delta * radius, 0.0]])),
        lattice_step=np.array([[1, 0]]),
    )
    found, samples, model = candidate_lists(yarns, 0.1)
    assert found == all_pairs(samples, model, 0.1)
    for p, row in enumerate(found):
        assert {(p, 0, 1), (p, 0, -1)} <= row
        assert all(b != 0 for _, _, b in row)  # a straight strand does not touch itself
    s = np.sqrt(1 - delta**2)
    inside = 2 / delta * np.arctan(s / delta) + 2 * (delta**2 - 2) * s + 2 / 3 * s**3
    energies = yarn_energies(yarns, LEAF)
    # Samples are 0.1 radii apart. f'' is not smooth where contact ends, which gives an error of second order in that.
    assert energies["contact"] == pytest.approx(2 * radius * LEAF.k_contact * inside * 0.8, rel=0.01)
    # the yarn is straight and at its rest length, so only rounding is left
    assert energies["stretch"] + energies["length"] + energies["bend"] == pytest.approx(0.0, abs=1e-20)


def test_one_stitch_equals_its_tiling() -> None:
    cell = shaken(periodic_patch(1, 1))
    tiles = tiled(cell, 2, 3)
    one, six = yarn_energies(cell, LEAF), yarn_energies(tiles, LEAF)
    for term, energy in one.items():
        assert energy > 0.0
        assert six[term] / 6 == pytest.approx(energy, rel=1e-12)  # rounding only
    force = yarn_forces(cell, LEAF)
    scale = np.abs(force).max()
    np.testing.assert_allclose(yarn_forces(tiles, LEAF), np.tile(force, (6, 1)), atol=1e-12 * scale)


def test_one_stitch_equals_the_middle_of_a_swatch_without_a_lattice() -> None:
    cell, swatch = periodic_patch(1, 1), flat_patch(5, 5)
    middle = slice((2 * 5 + 2) * POINTS, (2 * 5 + 3) * POINTS)
    force = yarn_forces(cell, LEAF)
    # rounding of coordinates of five centimetres in the stiffest energy term
    np.testing.assert_allclose(yarn_forces(swatch, LEAF)[middle], force, atol=1e-10 * np.abs(force).max())


def test_the_first_control_point_of_a_yarn_does_not_matter() -> None:
    cell, first = shaken(periodic_patch(1, 1)), 5
    same = rolled(cell, first)
    force = yarn_forces(cell, LEAF)
    # rounding of coordinates that are larger by one period
    np.testing.assert_allclose(
        yarn_forces(same, LEAF), np.roll(force, -first, axis=0), atol=1e-11 * np.abs(force).max()
    )
    assert sum(yarn_energies(same, LEAF).values()) == pytest.approx(sum(yarn_energies(cell, LEAF).values()), rel=1e-12)


def test_the_choice_of_the_periodic_image_does_not_matter() -> None:
    cell = shaken(periodic_patch(2, 1))
    assert cell.lattice is not None
    away = cell.points.copy()
    away[POINTS:] += cell.lattice.shift((2, -1))
    force = yarn_forces(cell, LEAF)
    # rounding as above
    np.testing.assert_allclose(
        yarn_forces(replace(cell, points=away), LEAF), force, atol=1e-11 * np.abs(force).max()
    )


def test_the_choice_of_periods_does_not_matter() -> None:
    """The periods are u + v and v, so that the lattice step of a row, u, has other components."""
    cell = shaken(periodic_patch(1, 1))
    assert cell.lattice is not None
    periods = Lattice(np.array([[1, 1], [0, 1]]) @ cell.lattice.periods)
    other = replace(cell, lattice=periods, lattice_step=np.array([[1, -1]]))
    force = yarn_forces(cell, LEAF)
    # rounding of sums of periods
    np.testing.assert_allclose(yarn_forces(other, LEAF), force, atol=1e-11 * np.abs(force).max())


def test_forces_on_a_cell_are_minus_the_gradient() -> None:
    yarns = shaken(periodic_patch(1, 1))
    force = yarn_forces(yarns, LEAF, **COARSE)
    direction = np.random.default_rng(3).normal(size=yarns.points.shape)
    step = 1e-6  # central differences, as in test_evaluate
    ends = [
        sum(yarn_energies(replace(yarns, points=yarns.points + side * step * direction), LEAF, **COARSE).values())
        for side in (1, -1)
    ]
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(-(force * direction).sum(), rel=1e-6)


def test_images_are_added_when_yarns_spread_over_more_cells() -> None:
    cell = periodic_patch(1, 1)
    model = on_device(cell)
    assert has_images(model, model.upload(model.to_device(cell.points), 3))
    before = len(model.constants.images.image)
    extended = cell.points.copy()
    extended[0, 0] -= 2 * (2 * SPREAD + 5) * cell.radius.max() + np.ptp(cell.points[:, 0])
    spread, periods = model.upload(model.to_device(extended), 3), model.constants.images.periods.numpy()[None]
    assert not has_images(model, spread)
    renew_images(model, spread)
    table = model.constants.images.image.numpy()
    assert len(table) > before and not table[0].any()
    needed = near_images(corners_of(model, spread.numpy(), periods), CONTACT_RANGE)
    assert {tuple(image) for image in needed} <= {tuple(image) for image in table}
    assert has_images(model, spread)

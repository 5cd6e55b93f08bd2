# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tilings of a cell: the same curves, the same forces, and labels that continue from tile to tile."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.lattice import Lattice
from stitchmesh.yarn import UNKNOWN_FACE, YarnSet
from stitchmesh.yarn.tiling import instances, tile_yarns
from stitchmesh.yarnrelax import YarnMaterial, yarn_energies, yarn_forces
from tests.yarnrelax.stockinette import periodic_patch, woven_cell

LEAF = YarnMaterial.named("leaf")
LATTICE = Lattice([[1.0, 0.0, 0.1], [0.25, 2.0, 0.0]])


def yarn_of_step(step: tuple[int, int], count: int = 5) -> YarnSet:
    """Return one yarn of random control points that continues in its image by a lattice step, on a sheared lattice."""
    points = np.random.default_rng(2).normal(size=(count, 3))
    yarns = YarnSet.from_curves([points], closed=[True], radius=0.1, rest_lengths=[1.0 + np.arange(count)])
    labels = {"face": np.arange(count), "part": np.arange(count), "row": np.arange(count) // 3}
    natural = np.random.default_rng(8).normal(size=count)
    return replace(
        yarns, **labels, colour=[3], natural_curvature=natural, lattice=LATTICE, lattice_step=np.array([step])
    )


def numbered(cell: YarnSet) -> YarnSet:
    """Return the cell with perturbed points; the face of each point is its number, so that copies can be identified."""
    rng = np.random.default_rng(7)
    noise, natural = rng.normal(scale=0.01, size=cell.points.shape), rng.normal(size=len(cell.points))
    return replace(
        cell, points=cell.points + noise, rest_length=0.95 * cell.rest_length, face=np.arange(len(cell.points)),
        natural_curvature=natural,
    )  # fmt: skip


def corners_of_segments(yarns: YarnSet) -> NDArray[np.float64]:
    """Return the positions of the four control points of each segment [cm], shape (S, 12)."""
    corners = yarns.points[yarns.segment_points]
    return (corners if yarns.point_shift is None else corners + yarns.point_shift).reshape(-1, 12)


def ordered(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rows in lexical order of their values to nine digits."""
    return rows[np.lexsort(np.round(rows, 9).T)]


@pytest.mark.parametrize("step", [(1, 0), (-1, 0), (2, -3), (0, 0)])
def test_a_finite_piece_consists_exactly_of_the_segments_of_its_tiles(step):
    cell = yarn_of_step(step)
    piece = tile_yarns(cell, 4, 3)
    assert piece.lattice is None
    expected = [corners_of_segments(cell) + np.tile(shift, 4) for shift in instances(LATTICE, 4, 3)]
    # sums of shifts are rounded in another order
    np.testing.assert_allclose(ordered(corners_of_segments(piece)), ordered(np.concatenate(expected)), atol=1e-12)
    np.testing.assert_array_equal(np.sort(piece.rest_length), np.sort(np.tile(cell.rest_length, 12)))
    # each segment keeps its own rest length; its second control point identifies the copied segment
    source = piece.part[piece.segment_points[:, 0]]
    np.testing.assert_array_equal(piece.rest_length, cell.rest_length[source])
    np.testing.assert_array_equal(piece.natural_curvature, cell.natural_curvature[piece.part])


@pytest.mark.parametrize(
    ("step", "count", "new"),
    [((1, 0), 3, (1, 0)), ((0, -1), 4, (0, -1)), ((2, 0), 6, (1, 0)), ((1, 1), 1, (3, 4)), ((0, 0), 12, (0, 0))],
)
def test_a_larger_cell_has_larger_periods_and_its_own_steps(step, count, new):
    larger = tile_yarns(yarn_of_step(step), 4, 3, periodic=True)
    np.testing.assert_array_equal(larger.lattice.periods, LATTICE.periods * [[4], [3]])
    np.testing.assert_array_equal(larger.lattice_step, [new] * count)
    assert larger.closed.all()
    assert len(larger.points) == 60


def diagonal_cell() -> YarnSet:
    """Return a yarn with the step (1, 1): two by two tiles hold two yarns, which continue across other borders."""
    line = np.arange(12)[:, None] / 12 * [0.9, 0.75, 0.0]
    lattice = Lattice([[0.5, 0.0, 0.0], [0.4, 0.75, 0.0]])
    bare = YarnSet.from_curves([line], closed=[True], radius=0.16, rest_lengths=[np.full(12, 0.09)])
    return replace(bare, lattice=lattice, lattice_step=np.array([[1, 1]]))


@pytest.mark.parametrize(
    ("cell", "counts"), [(periodic_patch(1, 1), (2, 3)), (woven_cell(), (1, 2)), (diagonal_cell(), (2, 2))],
    ids=["one stitch", "woven", "diagonal"],
)  # fmt: skip
def test_a_cell_equals_its_tiling(cell, counts):
    cell = numbered(cell)
    larger = tile_yarns(cell, *counts, periodic=True)
    one, many = yarn_energies(cell, LEAF, device="cpu"), yarn_energies(larger, LEAF, device="cpu")
    tiles = counts[0] * counts[1]
    for term, energy in one.items():
        assert energy > 0.0
        assert many[term] / tiles == pytest.approx(energy, rel=1e-12)  # rounding only
    force = yarn_forces(cell, LEAF, device="cpu")
    source = larger.face % len(cell.points)
    np.testing.assert_array_equal(np.bincount(source), tiles)
    # rounding of coordinates in the stiffest term
    np.testing.assert_allclose(
        yarn_forces(larger, LEAF, device="cpu"), force[source], atol=1e-12 * np.abs(force).max()
    )


def test_labels_continue_from_tile_to_tile():
    piece = tile_yarns(yarn_of_step((1, 0)), 2, 3)
    first = piece.face[:13]
    # the last three control points are the first three of the next image
    np.testing.assert_array_equal(first, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 0, 1, 2])
    np.testing.assert_array_equal(piece.face[13:23], first[:10] + 10)
    np.testing.assert_array_equal(piece.row[:13], [0, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0])
    np.testing.assert_array_equal(piece.row[26:31], [4, 4, 4, 5, 5])
    assert piece.face.max() == 5 * 6 - 1


def test_points_without_a_stitch_have_the_number_of_their_yarn_as_row():
    cell = replace(yarn_of_step((1, 0)), face=np.full(5, UNKNOWN_FACE))
    piece = tile_yarns(cell, 2, 3)
    np.testing.assert_array_equal(piece.row, piece.point_yarn)
    np.testing.assert_array_equal(piece.face, UNKNOWN_FACE)


def test_impossible_tilings_are_refused():
    with pytest.raises(ParameterError, match="got 0 columns; expected a whole number from 1"):
        tile_yarns(yarn_of_step((1, 0)), 0, 3)
    with pytest.raises(ParameterError, match=r"got 1\.5 rows"):
        instances(LATTICE, 1, 1.5)
    with pytest.raises(YarnError, match="do not repeat; expected a cell on a lattice"):
        tile_yarns(tile_yarns(yarn_of_step((1, 0)), 1, 1), 2, 2)

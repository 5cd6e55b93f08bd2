# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Woven yarns pass over and under as in the matrix, generated and relaxed, and do not overlap when generated."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from stitchmesh.errors import ParameterError
from stitchmesh.periodic.weave.library import read_weave, weave_names
from stitchmesh.periodic.weave.weave import Thread, Weave
from stitchmesh.periodic.weave.yarns import taut_heights, weave_yarns
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns
from tests.nightly import at_night

RADIUS = 0.1
PLAIN = ((0, 1), (1, 0))
NEAREST = {
    "double-plain-stitched": 0.65,
    "double-cloth-exchanging": 0.6,
    "orthogonal-interlock": 0.6,
    "triple-plain-stitched": 0.45,
}
"""Smallest generated distance of yarns of layered weaves over both radii; more layers make the yarns steeper."""


def matrix_of(yarns: YarnSet, weft_count: int) -> list[list[int]]:
    """Return 1 where a weft lies above a warp at their crossing, seen from the front, otherwise 0."""
    assert yarns.lattice is not None
    across, up = yarns.lattice.periods
    curves = yarns.sampled(8)
    warps = [np.concatenate([curve + turn * up for turn in (-1, 0, 1)]) for curve in curves[weft_count:]]
    trees = [cKDTree(warp[:, :2]) for warp in warps]
    rows = []
    for curve in curves[:weft_count]:
        weft = np.concatenate([curve + turn * across for turn in (-1, 0, 1)])
        row = []
        for warp, tree in zip(warps, trees, strict=True):
            distance, nearest = tree.query(weft[:, :2])
            here = distance.argmin()
            row.append(int(weft[here, 2] > warp[nearest[here], 2]))
        rows.append(row)
    return rows


def smallest_distance(yarns: YarnSet) -> float:
    """Return the smallest distance of two yarns and their images, relative to the sum of their radii."""
    assert yarns.lattice is not None and yarns.lattice_step is not None
    curves = yarns.sampled(4)
    points, yarn = np.concatenate(curves), np.repeat(np.arange(len(curves)), [len(curve) for curve in curves])
    tree, step = cKDTree(points), yarns.lattice_step[yarn]
    smallest = np.inf
    for a, b in np.ndindex(3, 3):
        distance, near = tree.query(points + yarns.lattice.shift((a - 1, b - 1)), k=min(40, len(points)))
        along = step[:, 0] * (b - 1) == step[:, 1] * (a - 1)  # this image is a continuation of the same yarn
        other = (yarn[near] != yarn[:, None]) | ~along[:, None]
        ratio = distance / (yarns.radius[yarn][:, None] + yarns.radius[yarn[near]])
        smallest = min(smallest, ratio[other].min())
    return smallest


@pytest.mark.parametrize(("name", "quality"), [*((name, "draft") for name in weave_names()), ("satin-2x3", "standard")])
def test_generated_yarns_pass_as_in_the_matrix_and_do_not_overlap(name, quality):
    weave = read_weave(name)
    yarns = weave_yarns(weave, yarn_radius=RADIUS, quality=quality)
    assert matrix_of(yarns, len(weave.wefts)) == [list(row) for row in weave.matrix]
    assert smallest_distance(yarns) > NEAREST.get(name, 0.9)


@pytest.mark.parametrize("name", ["plain", *at_night("orthogonal-interlock")])
def test_relaxed_yarns_pass_as_in_the_matrix(name):
    weave = read_weave(name)
    relaxed = relax_yarns(weave_yarns(weave, yarn_radius=RADIUS, quality="draft"), quality="draft", device="cpu")
    assert relaxed.report["converged"]
    assert relaxed.report["min_distance_over_radius"] > 1.6
    assert matrix_of(relaxed.yarns, len(weave.wefts)) == [list(row) for row in weave.matrix]


def test_the_cell_has_the_width_of_all_warps_and_yarns_continue_in_their_images():
    warps = (Thread(spacing=2.0), Thread(), Thread())
    weave = Weave(((1, 1, 0), (0, 0, 1)), warps=warps)
    yarns = weave_yarns(weave, yarn_radius=RADIUS, spacing=(0.5, 0.7))
    assert yarns.lattice is not None and yarns.lattice_step is not None
    np.testing.assert_allclose(yarns.lattice.periods, [[2.0, 0, 0], [0, 1.4, 0]], rtol=1e-15)
    assert yarns.lattice_step.tolist() == [[1, 0]] * 2 + [[0, 1]] * 3
    middle = [curve.mean(axis=0) for curve in yarns.sampled(1)]
    np.testing.assert_allclose([y for _, y, _ in middle[:2]], [1.05, 0.35])  # the first weft on top
    np.testing.assert_allclose([x for x, _, _ in middle[2:]], [0.5, 1.25, 1.75])
    assert yarns.closed.all()
    last, first = yarns.points[yarns.start[1:] - 1], yarns.points[yarns.start[:-1]]
    step = np.linalg.norm(first + yarns.lattice.shift(yarns.lattice_step) - last, axis=1)
    assert step.max() < 0.7  # the distance to the first point of the next image is no longer than between crossings


def test_threads_give_radius_length_and_colour_of_their_yarns():
    wefts = (Thread(radius=1.5, colour=4), Thread(length=0.9))
    yarns = weave_yarns(Weave(PLAIN, wefts=wefts), yarn_radius=RADIUS)
    np.testing.assert_allclose(yarns.radius, RADIUS * np.array([1.5, 1, 1, 1]))
    assert yarns.colour.tolist() == [4, 0, 0, 0]
    strain = [yarns.strain[yarns.segment_yarn == yarn] for yarn in range(4)]
    np.testing.assert_allclose(strain[1], 1 / 0.9 - 1)
    np.testing.assert_allclose(np.concatenate([strain[0], *strain[2:]]), 0.0, atol=1e-15)


def test_a_weave_with_over_and_under_exchanged_is_the_mirror_image():
    """All heights change their signs, and nothing else changes."""
    weave = read_weave("double-plain-stitched")
    turned = Weave(tuple(map(tuple, 1 - np.array(weave.matrix))), weave.wefts, weave.warps)
    one, other = (weave_yarns(each, yarn_radius=RADIUS) for each in (weave, turned))
    np.testing.assert_allclose(other.points, one.points * [1, 1, -1], atol=1e-12)  # heights of 0.2 cm are rounded


@pytest.mark.parametrize("name", ["satin-2x3", "triple-plain-stitched"])
def test_taut_strings_are_in_equilibrium(name):
    """A string bends only at a contact, where both strings push on one another with equal force."""
    over = read_weave(name).over
    wefts, warps = taut_heights(over, np.ones(over.shape), np.ones(over.shape[1]), np.ones(over.shape[0]))
    sign = np.where(over, 1.0, -1.0)
    gap = sign * (wefts - warps) - 1.0
    push = [sign * (2 * wefts - np.roll(wefts, 1, 1) - np.roll(wefts, -1, 1)),
            -sign * (2 * warps - np.roll(warps, 1, 0) - np.roll(warps, -1, 0))]  # fmt: skip
    assert gap.min() > -1e-12  # the separation is exact except for rounding
    # relative to forces of about 1; heights change by up to 1e-4 in the last iteration
    np.testing.assert_allclose(push[0], push[1], atol=0.02)
    assert push[0].min() > -0.02
    assert np.abs(push[0][gap > 0.05]).max(initial=0.0) < 0.02


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"yarn_radius": 0.0}, "yarn radius: got 0.0 cm; expected a positive number"),
        ({"yarn_radius": RADIUS, "spacing": -1.0}, "warp spacing: got -1.0"),
        ({"yarn_radius": RADIUS, "spacing": (1.0, float("nan"))}, "weft spacing: got nan"),
        ({"yarn_radius": RADIUS, "quality": "fine"}, "quality: got 'fine'"),
    ],
)
def test_bad_sizes_are_refused(given, message):
    with pytest.raises(ParameterError, match=message):
        weave_yarns(Weave(PLAIN), **given)

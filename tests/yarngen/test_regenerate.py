# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of an edited fabric: unchanged stitches keep their relaxed positions, and changed stitches join them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stitchmesh import generate_yarns, label, read_mesh, relax_mesh, relax_yarns, tessellate
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Marks, apply_change
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.quality import quality_named
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.generate import SMALLEST_DISTANCE_OVER_RADIUS
from stitchmesh.yarngen.regenerate import regenerate_yarns, unchanged_points
from stitchmesh.yarnrelax import Relaxation
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL
from tests.gallery import GARMENTS

pytestmark = pytest.mark.decides

QUALITY = quality_named("draft")
HAT = next(path for path in GARMENTS if path.stem == "hat")


@cache
def fabric() -> StitchMesh:
    surface = read_mesh(HAT)
    return relax_mesh(tessellate(label(surface), stitch_width=3.0), surface=surface, device="cpu").fabric


def at_rest(yarns: YarnSet, own: StitchMesh, start: YarnSet | None = None) -> Relaxation:
    return relax_yarns(yarns, quality=QUALITY, keep_shape=own, device="cpu", run=Run(start=start))


@cache
def relaxed() -> YarnSet:
    return at_rest(generate_yarns(fabric(), quality=QUALITY), fabric()).yarns


def edited(stitch: Stitch) -> tuple[StitchMesh, int]:
    """The fabric with one changed stitch in its middle, and the face of that stitch."""
    face = int(np.flatnonzero((fabric().stitch == Stitch.KNIT) & (fabric().row == 6))[2])
    return apply_change(fabric(), Marks("stitch", np.array([face]), np.array([stitch]))), face


def test_without_an_edit_the_relaxed_yarns_come_back():
    yarns, start = regenerate_yarns(relaxed(), fabric(), fabric(), quality=QUALITY)
    np.testing.assert_array_equal(start.points, relaxed().points)
    np.testing.assert_array_equal(yarns.points, generate_yarns(fabric(), quality=QUALITY).points)


def test_unchanged_stitches_stay_as_relaxed_and_changed_ones_join_them():
    after, face = edited(Stitch.SLIP_BACK)
    yarns, start = regenerate_yarns(relaxed(), fabric(), after, quality=QUALITY)
    before = generate_yarns(fabric(), quality=QUALITY)
    own = unchanged_points(before, yarns, 0.02 * yarns.radius[0])
    np.testing.assert_array_equal(start.points[own >= 0], relaxed().points[own[own >= 0]])
    beside = np.unique(after.side_face[after.twin[after.sides_of(np.array([face]))]])
    assert set(yarns.face[own < 0]) <= {face, *beside.tolist()}
    assert face in yarns.face[own < 0]
    steps = np.linalg.norm(np.diff(start.points[: start.start[1]], axis=0), axis=1)
    assert steps.max() < 2 * np.median(steps)  # no jump between changed and unchanged stitches
    assert smallest_distance(start, 2 * yarns.radius[0])[0] >= SMALLEST_DISTANCE_OVER_RADIUS * yarns.radius[0]


def test_relaxing_again_takes_a_fifth_of_the_iterations():
    after, _ = edited(Stitch.PURL)
    yarns, start = regenerate_yarns(relaxed(), fabric(), after, quality=QUALITY)
    anew, again = at_rest(yarns, after), at_rest(yarns, after, start)
    assert anew.report["converged"] and again.report["converged"]
    # convergence is tested every twenty iterations, and its estimate needs four times the first of them
    assert again.report["iterations"] <= anew.report["iterations"] / 5 + 4 * ASSESSMENT_INTERVAL
    # both relaxations stop where the spacing has hardly anything left to change by
    assert again.report["energy"] == pytest.approx(anew.report["energy"], rel=2 * QUALITY.tolerance)


def test_changed_rest_lengths_and_natural_curvature_stay_and_new_yarn_is_straight():
    after, _ = edited(Stitch.PURL)
    curvature = 1.0 + np.arange(len(relaxed().points))
    changed = replace(relaxed(), rest_length=0.9 * relaxed().rest_length, natural_curvature=curvature)
    yarns, start = regenerate_yarns(changed, fabric(), after, quality=QUALITY)
    generated = generate_yarns(after, quality=QUALITY)
    np.testing.assert_allclose(yarns.rest_length, 0.9 * generated.rest_length, rtol=1e-12)  # rounding of a product
    own = unchanged_points(generate_yarns(fabric(), quality=QUALITY), yarns, 0.02 * yarns.radius[0])
    assert 0 < (own < 0).sum() < len(own)
    for made in (yarns, start):
        np.testing.assert_array_equal(made.natural_curvature, np.where(own >= 0, 1.0 + own, 0.0))


def test_yarns_of_another_quality_are_refused():
    with pytest.raises(ParameterError, match="with which the yarns were generated"):
        regenerate_yarns(relaxed(), fabric(), fabric(), quality="reference")


def test_a_start_of_other_yarns_is_refused():
    with pytest.raises(ParameterError, match=r"start: got .* expected the same yarns"):
        relax_yarns(relaxed(), device="cpu", run=Run(start=generate_yarns(fabric(), quality="standard")))

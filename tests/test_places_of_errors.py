# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Errors of inner steps name a place of the user's mesh, and a remedy that helps."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import SolverError, YarnError
from stitchmesh.mesh import BORDER, RIGHT, TOP, StitchMesh
from stitchmesh.meshrelax.dynamics import ON_SURFACE
from stitchmesh.pipeline.garment import Garment
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.stages import generate_yarns_stage
from stitchmesh.run import QUIET
from tests.gallery import grid

WIDTH = 0.5


def flat_fabric() -> StitchMesh:
    return sm.tessellate(sm.label(grid(1, 1, width=4.0, height=3.0)), stitch_width=WIDTH)


def yarns_of(fabric: StitchMesh, radius: float | None = None) -> sm.YarnSet:
    options = KnitOptions(stitch_width=WIDTH, yarn_radius=radius, quality="draft")
    return generate_yarns_stage(Garment(mesh=fabric, options=options, values={StitchMesh: fabric}), QUIET).value


@pytest.mark.decides
def test_the_thinner_yarn_of_a_message_works():
    fabric = flat_fabric()
    low = replace(fabric, vertices=fabric.vertices * [1.0, 0.05, 1.0])  # rows a twentieth as high as they should be
    with pytest.raises(YarnError, match=r"^near \(.*\) cm: face \d+: yarns start .* apart") as refused:
        yarns_of(low)
    place = np.array([float(word) for word in re.findall(r"near \((.*?)\)", str(refused.value))[0].split(", ")])
    # The place is the middle of the stitch, rounded to a millimetre.
    corners = low.face_vertex[low.sides_of(np.array([refused.value.face]))]
    assert np.abs(low.vertices[corners].mean(axis=0) - place).max() <= 0.05 + 1e-12
    radius = float(re.findall(r"\(--yarn-radius (.*)\)$", str(refused.value))[0])
    assert yarns_of(low, radius).yarn_count > 0


def test_no_thinner_yarn_is_proposed_where_none_works():
    fabric = flat_fabric()
    with pytest.raises(YarnError, match="thinner yarns fail there too: two parts of the mesh touch"):
        yarns_of(replace(fabric, vertices=fabric.vertices * [1.0, 0.001, 1.0]))


def test_a_bound_off_stitch_without_height_is_named_by_its_place():
    fabric = flat_fabric()
    top = np.flatnonzero((fabric.twin == BORDER) & (fabric.side_role == TOP))
    right = np.flatnonzero((fabric.side_role == RIGHT) & (fabric.twin != BORDER))
    side = int(right[np.isin(fabric.side_next[right], top)][0])
    foot, head = fabric.face_vertex[side], fabric.face_vertex[fabric.side_next[side]]
    points = fabric.vertices.copy()
    points[head] = points[foot]
    with pytest.raises(YarnError, match=r"^near \(.*\) cm: face \d+: is bound off, but has no height at one side"):
        yarns_of(replace(fabric, vertices=points))


def test_stitches_pressed_to_a_point_are_named_by_the_place_that_they_had():
    fabric = flat_fabric()
    point = sm.Mesh.from_polygons(np.eye(3) * 1e-3, [[0, 1, 2]])
    with pytest.raises(SolverError, match=r"near \[.*\] cm stitches were pressed to a line or a point") as refused:
        # With more iterations the stitches come to rest even on this point.
        sm.relax_mesh(fabric, surface=point, max_iterations=ON_SURFACE.patience)
    place = np.array([float(word) for word in re.findall(r"\[(.*)\]", str(refused.value))[0].split(", ")])
    assert (place >= fabric.vertices.min(axis=0)).all() and (place <= fabric.vertices.max(axis=0)).all()

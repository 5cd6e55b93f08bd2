# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conversion of rings to a spiral, and back."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.editing.spiral import make_rings, make_spiral, ring_stacks
from stitchmesh.errors import ParameterError
from stitchmesh.io.meshes import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.courses import find_courses
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.clearance import smallest_distance
from tests.gallery import ROOT, closed_cone, grid, tube, two_tubes
from tests.shaping.surfaces import in_triangles

ROUND = {
    "tube": lambda: tube(8, 2, radius=2.0),
    "narrowing tube": lambda: tube(8, 3, radius=4.0, top_radius=2.0),
    "closed cone": lambda: closed_cone(6),
}


def knitted(name: str) -> StitchMesh:
    return tessellate(label(ROUND[name]()), stitch_width=0.6)


@pytest.mark.parametrize("name", ROUND)
def test_a_spiral_is_one_yarn_with_two_ends(name):
    fabric = knitted(name)
    yarns = generate_yarns(make_spiral(fabric), quality="draft")
    assert yarns.yarn_count == 1 and not yarns.closed[0]
    assert set(range(fabric.face_count)) == set(yarns.face)
    if name == "tube":  # yarns of rings start more than a radius apart too
        assert smallest_distance(yarns, within=2 * yarns.radius[0])[0] > yarns.radius[0]


@pytest.mark.parametrize("name", ROUND)
def test_converting_a_spiral_back_restores_the_rings(name):
    fabric = knitted(name)
    again = make_rings(make_spiral(fabric))
    for field in fields(StitchMesh):
        if field.name != "vertices":
            np.testing.assert_array_equal(getattr(again, field.name), getattr(fabric, field.name), err_msg=field.name)
    assert again.vertices.shape == fabric.vertices.shape
    if name == "tube":
        # wales are straight and evenly divided, so the step down equals the step up except for rounding
        np.testing.assert_allclose(again.vertices, fabric.vertices, atol=1e-13)


def test_a_spiral_has_one_additional_vertex_and_one_free_wale_side_at_each_end():
    fabric = knitted("narrowing tube")
    turned = make_spiral(fabric)
    assert len(turned.vertices) == len(fabric.vertices) + 1
    free = np.flatnonzero(turned.is_wale & (turned.twin == BORDER))
    assert sorted(turned.side_role[free]) == [1, 3]
    assert sorted(turned.row[turned.side_face[free]]) == [0, fabric.row.max()]
    (course,) = find_courses(turned, climbing=True)
    assert not course.closed


def test_the_step_of_a_spiral_is_distributed_over_all_stitches():
    """On an even tube, each vertex lies above its neighbour by the wale length over the number of stitches."""
    fabric = knitted("tube")
    turned = make_spiral(fabric)
    around = int((fabric.row == 0).sum())
    wale = fabric.side_length[fabric.is_wale].mean()
    ends = turned.vertices[turned.face_vertex[turned.side_next]] - turned.vertices[turned.face_vertex]
    rise = np.abs(ends[~turned.is_wale][:, 1])
    np.testing.assert_allclose(rise, wale / around, rtol=1e-9)  # rounding


def test_every_stack_of_rings_is_converted_or_only_the_chosen_one():
    fabric = tessellate(label(two_tubes()), stitch_width=0.6)
    assert len(ring_stacks(fabric)) == 2
    assert generate_yarns(make_spiral(fabric), quality="draft").yarn_count == 2
    seam = int(np.flatnonzero(fabric.row == 1)[2])
    turned = make_spiral(fabric, seam)
    assert len(turned.vertices) == len(fabric.vertices) + 1
    # the seam runs along the left wale side of that face, where the previous row ends
    before = turned.side_face[turned.twin[turned.left_wale[seam]]]
    assert turned.row[before] == turned.row[seam] - 1


@pytest.mark.parametrize(("name", "spirals"), [("tea_cozy", 2), ("sweater", 4)])
def test_spirals_of_a_garment_share_no_vertex_and_become_rings_again(name, spirals):
    """Garments whose tubes end in other tubes, in slits and in flat rows."""
    fabric = tessellate(label(read_mesh(ROOT / "assets" / "meshes" / f"{name}.obj")), stitch_width=1.6)
    turned = make_spiral(fabric)
    assert len(turned.vertices) == len(fabric.vertices) + spirals
    np.testing.assert_array_equal(make_rings(turned).twin, fabric.twin)
    np.testing.assert_array_equal(make_rings(turned).face_vertex, fabric.face_vertex)


def test_flat_rows_stay_unchanged():
    fabric = tessellate(label(grid(1, 1, width=4.0, height=3.0)), stitch_width=0.5)
    assert make_spiral(fabric) is fabric and make_rings(fabric) is fabric


def test_a_seam_without_two_rings_is_refused():
    fabric = tessellate(label(grid(1, 1, width=4.0, height=3.0)), stitch_width=0.5)
    with pytest.raises(ParameterError, match="face 3 does not run through two rings"):
        make_spiral(fabric, 3)
    with pytest.raises(ParameterError, match="got face 9999; the mesh has faces 0 to"):
        make_spiral(fabric, 9999)


def test_the_last_round_at_a_tip_of_found_rows_stays_a_ring_and_loops_hold():
    shaped = sm.shape_fabric(in_triangles(closed_cone(12)), stitch_width=0.8, progress=False)
    rings = sm.relax_mesh(shaped.fabric, surface=shaped.surface.mesh).fabric
    turned = make_spiral(rings)
    assert len(turned.vertices) == len(rings.vertices) + 1
    last = set(ring_stacks(rings)[0][-1].faces)
    assert last in [set(stack[-1].faces) for stack in ring_stacks(turned)]
    sm.check_loops(turned, sm.generate_yarns(turned))
    assert (make_rings(turned).twin == rings.twin).all()

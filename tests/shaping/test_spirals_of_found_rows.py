# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rounds of found rows become spirals by the same operation as those of modelled rows."""

from __future__ import annotations

import pytest

import stitchmesh as sm
from stitchmesh.editing.ring_rows import ring_stacks
from stitchmesh.editing.spiral import make_spiral, unspiral
from stitchmesh.mesh import Mesh, StitchMesh
from tests.gallery import closed_cone, tube
from tests.shaping.surfaces import closed_ball, in_triangles


def relaxed(mesh: Mesh, width: float) -> StitchMesh:
    shaped = sm.shape_fabric(mesh, stitch_width=width, progress=False)
    return sm.relax_mesh(shaped.fabric, surface=shaped.surface.mesh).fabric


def test_a_narrowing_tube_is_one_yarn():
    rings = relaxed(in_triangles(tube(24, 6, radius=3.0, top_radius=2.5)), 0.9)
    yarns = sm.generate_yarns(make_spiral(rings))
    assert len(ring_stacks(rings)[0]) > 5
    assert yarns.yarn_count == 1 and not yarns.closed[0]


@pytest.mark.parametrize("mesh", [closed_ball(24, 20), in_triangles(closed_cone(12))], ids=["ball", "cone"])
def test_the_last_round_at_a_tip_stays_a_ring_and_loops_hold(mesh):
    rings = relaxed(mesh, 0.8)
    turned = make_spiral(rings)
    assert len(turned.vertices) == len(rings.vertices) + 1
    last = set(ring_stacks(rings)[0][-1].faces)
    assert last in [set(stack[-1].faces) for stack in ring_stacks(turned)]
    sm.check_loops(turned, sm.generate_yarns(turned))
    assert (unspiral(turned).twin == rings.twin).all()

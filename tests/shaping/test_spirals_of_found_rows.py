# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rounds of found rows become spirals by the same operation as those of modelled rows."""

from __future__ import annotations

import stitchmesh as sm
from stitchmesh.editing.ring_rows import ring_stacks
from stitchmesh.editing.spiral import make_spiral, unspiral
from tests.gallery import closed_cone
from tests.shaping.surfaces import in_triangles


def test_the_last_round_at_a_tip_stays_a_ring_and_loops_hold():
    shaped = sm.shape_fabric(in_triangles(closed_cone(12)), stitch_width=0.8, progress=False)
    rings = sm.relax_mesh(shaped.fabric, surface=shaped.surface.mesh).fabric
    turned = make_spiral(rings)
    assert len(turned.vertices) == len(rings.vertices) + 1
    last = set(ring_stacks(rings)[0][-1].faces)
    assert last in [set(stack[-1].faces) for stack in ring_stacks(turned)]
    sm.check_loops(turned, sm.generate_yarns(turned))
    assert (unspiral(turned).twin == rings.twin).all()

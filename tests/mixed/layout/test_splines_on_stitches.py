# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Feet and heights of B-spline yarns: the yarns where they were, on garments too, and along with a cloth that moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.from_stitches import cloth_from_stitches
from stitchmesh.mixed.layout.spline_yarns import lay_splines
from stitchmesh.yarngen import generate_yarns
from tests.mixed.cloth.test_cloth_from_stitches import garment
from tests.mixed.splines.jersey import RADIUS, jersey
from tests.mixed.triangles.derivatives import rotation
from tests.nightly import at_night


@pytest.mark.parametrize("name", ["hat", *at_night("sweater")])
def test_control_points_of_a_garment_have_feet_and_heights(name):
    fabric = garment(name)
    cloth = cloth_from_stitches(fabric, stitch_width=1.6, course_height=1.2)
    curves = generate_yarns(fabric, quality="draft")
    yarns = lay_splines(cloth, fabric, curves)
    radius = curves.radius.mean()
    # rounds of the foot reduce its error by the height over the radius of curvature; a few points lie at sharp folds
    apart = np.linalg.norm(yarns.world(cloth) - curves.points, axis=1)
    assert np.percentile(apart, 99) < 1e-3 * radius and apart.max() < radius
    inside = curves.face >= 0
    assert np.percentile(np.abs(yarns.height[inside]), 99) < 4.0 * radius
    assert abs(yarns.height[inside].mean()) < 0.2 * radius  # loops stand out to both sides alike


def test_yarns_turn_with_their_cloth_and_are_stretched_with_it():
    cloth, yarns, _pinned = jersey()
    turn = rotation()
    turned = yarns.world(cloth, cloth.vertices @ turn.T + 2.0)
    np.testing.assert_allclose(turned, yarns.world(cloth) @ turn.T + 2.0, atol=1e-12)  # rounding of 3 cm
    np.testing.assert_allclose(yarns.world(cloth), yarns.curves.points, atol=1e-12)
    scale = np.array([1.2, 0.9, 1.0])
    np.testing.assert_allclose(yarns.world(cloth, cloth.vertices * scale), yarns.curves.points * scale, atol=1e-12)
    assert 1.5 * RADIUS < yarns.height.max() < 6.0 * RADIUS and not yarns.rest_sliding.any()


def test_yarns_of_another_fabric_are_refused():
    fabric = garment("hat")
    cloth = cloth_from_stitches(fabric, stitch_width=1.6, course_height=1.2)
    with pytest.raises(ParameterError, match="belongs to no stitch"):
        unknown = generate_yarns(fabric, quality="draft")
        lay_splines(cloth, fabric, replace(unknown, face=np.full(len(unknown.points), -1)))
    with pytest.raises(ParameterError, match="triangles"):
        small, _yarns, _pinned = jersey()
        lay_splines(small, fabric, generate_yarns(fabric, quality="draft"))

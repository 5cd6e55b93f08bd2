# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The surface of a moving body on the device, and bodies that cut through themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.vertex_motion import MovingMesh
from stitchmesh.simulation.bodies.mesh_features import mesh_features
from stitchmesh.yarnrelax.motion.moving_surface import MovingSurface
from stitchmesh.yarnrelax.motion.self_cuts import refuse_self_cuts
from tests.yarnrelax.energies.test_body import BOX, box, ring, sphere
from tests.yarnrelax.one_term import on_device


def test_a_surface_between_two_frames_has_the_features_of_the_mesh_there() -> None:
    ball = sphere(2.0)
    ends = [ball, replace(ball, vertices=ball.vertices * [1.5, 0.8, 1.0] + [0.3, 0.0, 0.0])]
    model = on_device(ring(4.0, 0.0, 8, 1.0))
    surface = MovingSurface(model, MovingMesh.of_frames(ends, [0.0, 2.0]))
    surface.clock.assign(np.array([0.0, 0.5]))
    surface.begin(0)
    between = replace(ball, vertices=0.75 * ends[0].vertices + 0.25 * ends[1].vertices)
    expected = mesh_features(between)
    # float64: rounding of coordinates of size 1, larger in directions by their division by lengths of 0.1
    np.testing.assert_allclose(surface.constants.corners.numpy(), expected.corners.reshape(-1, 3), atol=1e-14)
    np.testing.assert_allclose(surface.constants.outward.numpy(), expected.outward.reshape(-1, 3), atol=1e-12)


def two_boxes(apart: float) -> Mesh:
    """Two boxes with sides of 2 cm in one mesh, the second one moved along x and a little aside."""
    first = box().vertices
    faces = BOX + [[vertex + 8 for vertex in face] for face in BOX]
    return Mesh.from_polygons(np.concatenate([first, first + np.array([apart, 0.3, 0.2])]), faces)


def test_a_body_that_cuts_through_itself_is_refused_and_one_whose_parts_come_close_is_not() -> None:
    apart = [3.0, 2.01, 1.9]
    moving = MovingMesh.of_frames([two_boxes(width) for width in apart], [0.0, 0.1, 0.2])
    with pytest.raises(ParameterError, match=r"frame 2 \(0.2 s\), near .* cm: face \d+ cuts through face \d+"):
        refuse_self_cuts(moving, device_named("cpu"))

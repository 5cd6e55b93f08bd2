# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cloth that starts partly inside a body."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from scipy.spatial.transform import Rotation

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.contact import dressing
from stitchmesh.mixed.contact.body import SolidBody
from stitchmesh.mixed.contact.body_distance import BodyContact
from stitchmesh.mixed.contact.dressing import moved_outside
from stitchmesh.mixed.contact.motion import RigidMotion
from tests.mixed.contact.bodies import ball, box
from tests.mixed.contact.sheets import cpu, sheet, state_of


def test_points_of_a_cloth_move_out_of_a_ball():
    turn = RigidMotion(np.zeros(1), np.array([[0.0, 0.0, 0.3]]), Rotation.from_rotvec([0, 0, 0.4]).as_matrix()[None])
    cloth = sheet(10, 3.0)
    body = SolidBody(ball(0.8, 3), turn)
    points, _links = cloth.points(0.1, spacing=0.25)
    moved, depth = moved_outside(points, cloth.vertices, body, 0.05, cpu())
    contact = BodyContact(points, body, scalar=wp.float64, device=cpu())
    before, after = contact.distances(state_of(cloth.vertices)), contact.distances(state_of(moved))
    assert depth == pytest.approx(-before.min()) and depth > 0.3
    assert after.min() >= 0.25 * 0.05
    outside = np.linalg.norm(cloth.vertices[:, :2], axis=1) > 1.2  # their triangles are away from the ball
    assert (moved[outside] == cloth.vertices[outside]).all()
    again, no_depth = moved_outside(points, moved, body, 0.05, cpu())
    assert (again == moved).all() and no_depth == 0.0


def test_refuses(monkeypatch):
    cloth = sheet(1, 0.2)
    points, _links = cloth.points(0.1, spacing=np.inf)
    with pytest.raises(ParameterError, match=r"clearance of 0\.0 cm; expected a positive number"):
        moved_outside(points, cloth.vertices, SolidBody(box((1.0, 1.0, 1.0))), 0.0, cpu())
    deep = sheet(10, 3.0)
    fine, _links = deep.points(0.1, spacing=0.25)
    monkeypatch.setattr(dressing, "OUTWARD_ROUNDS", 1)  # one move is not enough
    with pytest.raises(ParameterError, match=r"^ball: \d+ of \d+ points, up to .* cm deep, find no way out"):
        moved_outside(fine, deep.vertices, SolidBody(ball(1.0, 2), name="ball"), 0.05, cpu())

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation after edits that make borders which the surface does not have, and around an edit only."""

from __future__ import annotations

import logging

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.meshrelax import relax_mesh, relax_mesh_around_edit
from stitchmesh.meshrelax.bobbles import carried, find_bobbles
from stitchmesh.meshrelax.relax import RINGS, changed_faces
from stitchmesh.meshrelax.sub_quads import edge_ends
from tests.meshrelax.fabrics import grid_fabric, rotation, tube_chord_points

pytestmark = pytest.mark.decides

ROWS, AROUND = 20, 32


def tube_and_surface() -> tuple[StitchMesh, StitchMesh]:
    fabric = grid_fabric(tube_chord_points(16, 2, np.linspace(0.0, 10.0, ROWS + 1), 4.0), wrap=True)
    return fabric, grid_fabric(tube_chord_points(16, 1, np.linspace(0.0, 10.0, 6), 4.0), wrap=True)


def edited(fabric: StitchMesh, name: str, **arguments: object) -> StitchMesh:
    return apply_edit(fabric, Edit(name, arguments)).fabric


def middle_face() -> int:
    return AROUND * (ROWS // 2) + 5


def test_a_bobble_is_found_by_its_slits() -> None:
    fabric, _ = tube_and_surface()
    found = find_bobbles(edited(fabric, "bobble", face=middle_face()))
    assert found.count == 1 and len(found.faces) == 5 and len(found.raised) == 6
    sides = fabric.sides_of(np.array([middle_face()]))
    assert found.corners[0].tolist() == fabric.face_vertex[sides].tolist()
    assert (found.raised >= len(fabric.vertices)).all()
    assert find_bobbles(fabric).count == 0


def test_fabric_around_a_bobble_relaxes_as_around_a_plain_stitch() -> None:
    fabric, surface = tube_and_surface()
    plain = relax_mesh(fabric, surface=surface, tolerance=1e-6).fabric
    made = edited(fabric, "bobble", face=middle_face())
    even = relax_mesh(made, surface=surface, tolerance=1e-6)
    relaxed, report = even.fabric, even.report
    assert report.converged
    # At a residual of 1e-6, the longest wave of strain, 20 rows of 0.5 cm, has an error of about 1e-5 cm.
    np.testing.assert_allclose(relaxed.vertices[: len(fabric.vertices)], plain.vertices, atol=1e-4)
    raised = np.isin(edge_ends(made), find_bobbles(made).raised).any(axis=1)
    assert relaxed.stretch is not None
    np.testing.assert_array_equal(np.isnan(relaxed.stretch), raised)


def test_the_vertices_of_a_bobble_follow_its_corners() -> None:
    """They follow every similarity of the corners exactly, up to rounding."""
    fabric, _ = tube_and_surface()
    made = edited(fabric, "bobble", face=middle_face())
    found = find_bobbles(made)
    moved = 1.7 * made.vertices @ rotation(3) + [1.0, -2.0, 3.0]
    np.testing.assert_allclose(carried(found, made.vertices, moved), moved[found.raised], atol=1e-12)


def test_two_separated_rows_move_apart_on_the_surface() -> None:
    """Stitches at rest cover 0.9 of the surface, so that rows with a free border leave a gap; they did not converge."""
    fabric, surface = tube_and_surface()
    side = int(fabric.left_wale[middle_face()] - 1)
    made = relax_mesh(edited(fabric, "ungraft", side=side), surface=surface)
    relaxed, report = made.fabric, made.report
    assert report.converged
    heights = sorted(relaxed.vertices[relaxed.face_vertex[loop], 2].mean() for loop in relaxed.boundary_loops)
    np.testing.assert_allclose([heights[0], heights[-1]], [0.0, 10.0], atol=1e-9)
    assert heights[2] - heights[1] > 0.3
    radius = np.linalg.norm(relaxed.vertices[:, :2], axis=1)
    assert np.ptp(radius) < 0.05  # Free borders stay on the surface, which has flat triangles.


def test_vertices_that_are_held_keep_their_places() -> None:
    fabric, surface = tube_and_surface()
    even = relax_mesh(fabric, surface=surface).fabric
    after = edited(even, "insert_row", face=middle_face())
    made = relax_mesh_around_edit(even, after)
    relaxed, report = made.fabric, made.report
    assert report.converged
    rows = np.unique(after.row[changed_faces(even, after)])
    assert rows.tolist() == [ROWS // 2, ROWS // 2 + 1]
    moved = np.flatnonzero((relaxed.vertices != after.vertices).any(axis=1))
    touched = np.unique(after.row[np.isin(after.face_vertex, moved).nonzero()[0] // 4])
    assert touched.min() >= rows[0] - RINGS - 1 and touched.max() <= rows[1] + RINGS + 1
    heights = np.unique(np.round(relaxed.vertices[:, 2], 1))
    assert np.diff(heights).min() > 0.3  # The inserted row was 0.25 high between rows of 0.5.
    assert len(changed_faces(fabric, edited(fabric, "change_stitch", faces=[middle_face()], stitch="p"))) == 0
    cut = edited(fabric, "ungraft", side=int(fabric.left_wale[middle_face()] - 1))
    assert np.unique(cut.row[changed_faces(fabric, cut)]).tolist() == [ROWS // 2, ROWS // 2 + 1]


@pytest.mark.parametrize("moving", [np.ones(3, dtype=bool), np.ones(AROUND * (ROWS + 1))])
def test_an_array_of_moving_vertices_that_does_not_fit_is_refused(moving) -> None:
    fabric, surface = tube_and_surface()
    with pytest.raises(ParameterError, match="expected one truth value for each of 672 vertices"):
        relax_mesh(fabric, surface=surface, moving=moving)


def test_a_relaxation_that_has_not_converged_says_so_in_one_line(caplog) -> None:
    fabric, surface = tube_and_surface()
    fabric = edited(fabric, "insert_row", face=middle_face())
    with caplog.at_level(logging.WARNING):
        report = relax_mesh(fabric, surface=surface, tolerance=1e-9, max_iterations=1).report
    assert not report.converged and report.tolerance == 1e-9
    assert report.remedy == "allow more iterations (max_iterations, by default 300)"
    (line,) = [record.message for record in caplog.records]
    assert f"residual {report.residual:.2g} (expected 1e-09) after 1 iterations; {report.remedy}" in line
    assert "\n" not in line
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        assert relax_mesh(fabric, surface=surface).report.remedy == ""
    assert not caplog.records

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.meshrelax import MeshRelaxOptions, relax_mesh
from tests.meshrelax.fabrics import grid_fabric, rectangle_points, rotation, tube_chord_points

pytestmark = pytest.mark.decides


def distorted_swatch() -> tuple[StitchMesh, Mesh]:
    """12 x 15 stitches of rest size 1 x 0.8 on their flat rectangle, with smooth displacements."""
    points = rectangle_points(12, 15, 12.0, 12.0)
    x, y = points[..., 0] / 12.0, points[..., 1] / 12.0
    points[..., 0] += 1.5 * np.sin(np.pi * x) * np.cos(2.0 * np.pi * y)
    points[..., 1] += 1.5 * np.sin(2.0 * np.pi * y) * np.cos(np.pi * x)
    return grid_fabric(points), grid_fabric(rectangle_points(3, 3, 12.0, 12.0))


def uneven_tube() -> tuple[StitchMesh, Mesh]:
    """A tube of 16 sides with 32 stitches around and 20 rows of different heights."""
    climb = np.linspace(0.0, 1.0, 21)
    fabric = grid_fabric(tube_chord_points(16, 2, 10.0 * (climb + 0.1 * np.sin(2 * np.pi * climb)), 4.0), wrap=True)
    return fabric, grid_fabric(tube_chord_points(16, 1, np.linspace(0.0, 10.0, 6), 4.0), wrap=True)


def test_a_distorted_swatch_relaxes_to_its_rest_shape() -> None:
    """The stitches fit the rectangle exactly, so that every edge can reach its rest length."""
    fabric, surface = distorted_swatch()
    before = fabric.vertices.copy()
    made = relax_mesh(fabric, surface=surface, options=MeshRelaxOptions(aspect=0.8, alpha=1.0), tolerance=1e-6)
    relaxed, report = made.fabric, made.report
    assert report.converged
    np.testing.assert_array_equal(fabric.vertices, before)
    for name in ("face_start", "face_vertex", "twin", "n_bottom", "n_top", "stitch", "row"):
        np.testing.assert_array_equal(getattr(relaxed, name), getattr(fabric, name))
    assert relaxed.stretch is not None
    # A force of 1e-6, accumulated over the longest wave of strain (15 stitches), is a strain of about 1e-5.
    np.testing.assert_allclose(relaxed.stretch, 1.0, atol=1e-4)
    expected = rectangle_points(12, 15, 12.0, 12.0).reshape(-1, 3)
    np.testing.assert_allclose(relaxed.vertices, expected, atol=1e-3)
    assert report.rms_stretch == pytest.approx(1.0, abs=1e-4)


def test_a_tube_relaxes_to_equal_rows_on_the_cylinder_and_keeps_its_borders() -> None:
    fabric, surface = uneven_tube()
    made = relax_mesh(fabric, surface=surface, options=MeshRelaxOptions(aspect=1.0), tolerance=1e-5)
    relaxed, report = made.fabric, made.report
    assert report.converged
    radius = np.linalg.norm(relaxed.vertices[:, :2], axis=1)
    # The cubic B-spline of a regular 16-gon of radius 4 has the radius 4 (4 + 2 cos(pi/8)) / 6 at its vertices.
    np.testing.assert_allclose(radius, 4.0 * (4.0 + 2.0 * np.cos(np.pi / 8.0)) / 6.0, rtol=2e-3)
    height = relaxed.vertices[:, 2].reshape(21, 32)
    np.testing.assert_allclose(height[[0, -1]], [[0.0] * 32, [10.0] * 32], atol=1e-12)
    np.testing.assert_allclose(np.diff(height, axis=0), 0.5, rtol=2e-3)  # Facets of the surface, as above.


def test_stretch_is_length_over_rest_length() -> None:
    fabric, surface = uneven_tube()
    made = relax_mesh(fabric, surface=surface, options=MeshRelaxOptions(aspect=0.8, alpha=0.9))
    relaxed, report = made.fabric, made.report
    assert relaxed.stretch is not None
    length = relaxed.side_length[relaxed.edge_side] / relaxed.stretch
    wale = relaxed.is_wale[relaxed.edge_side]
    assert np.ptp(length[wale]) < 1e-12 and np.ptp(length[~wale]) < 1e-12
    assert length[wale][0] / length[~wale][0] == pytest.approx(0.8)
    assert report.max_stretch == relaxed.stretch.max()


def test_the_result_follows_a_rigid_motion_of_the_input() -> None:
    """Results agree up to the tolerance, because patches of the preconditioner and ties of triangles depend on axes."""
    fabric, surface = uneven_tube()
    turn, shift = rotation(2), np.array([30.0, -10.0, 5.0])
    moved = replace(fabric, vertices=fabric.vertices @ turn + shift)
    moved_surface = replace(surface, vertices=surface.vertices @ turn + shift)
    first = relax_mesh(fabric, surface=surface, tolerance=1e-5).fabric
    second = relax_mesh(moved, surface=moved_surface, tolerance=1e-5).fabric
    # At a residual of 1e-5, the longest wave still has an error of about 1e-4 of a stitch of 0.7 cm.
    np.testing.assert_allclose(second.stretch, first.stretch, atol=1e-3)
    np.testing.assert_allclose(second.vertices[0] - shift, first.vertices[0] @ turn, atol=2e-3)


def test_vertices_in_the_same_place_are_separated() -> None:
    """A collapsed stitch must not cause a division by zero, and must expand again."""
    fabric, surface = distorted_swatch()
    points = rectangle_points(12, 15, 12.0, 12.0)
    points[7, 6] = points[7, 7] - [1e-9, 0.0, 0.0]
    made = relax_mesh(
        replace(fabric, vertices=points.reshape(-1, 3)), surface=surface,
        options=MeshRelaxOptions(aspect=0.8, alpha=1.0),
    )  # fmt: skip
    relaxed, report = made.fabric, made.report
    assert report.converged
    assert np.isfinite(relaxed.vertices).all()
    assert relaxed.stretch is not None and relaxed.stretch.min() > 0.9


@pytest.mark.parametrize("wrong", [{"aspect": np.nan}, {"alpha": 1.5}, {"tolerance": 0.0}, {"max_iterations": -1}])
def test_the_message_names_what_is_out_of_range(wrong: dict[str, float]) -> None:
    fabric, surface = distorted_swatch()
    options = {name: wrong[name] for name in ("aspect", "alpha") if name in wrong}
    others = {name: value for name, value in wrong.items() if name not in options}
    with pytest.raises(ParameterError, match=next(iter(wrong))):
        relax_mesh(fabric, surface=surface, options=MeshRelaxOptions(**options), **others)  # type: ignore[arg-type]

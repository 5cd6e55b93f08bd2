# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Meshes of trimesh, meshio and pyvista go in, and meshes, fabrics, yarns and swatches come out as them."""

from __future__ import annotations

from dataclasses import asdict
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import pyvista
import trimesh

import stitchmesh as sm
from stitchmesh.errors import LabelError, MeshError, ParameterError
from stitchmesh.quality import quality_named
from tests.fuzz.reader import small_yarns
from tests.gallery import tube

TUBE = tube(8, 3, radius=2.0, height=1.5)


@pytest.mark.parametrize("convert", [sm.to_pyvista, sm.to_meshio])
def test_polygons_come_back_as_they_went(convert):
    again = sm.as_mesh(convert(TUBE))
    np.testing.assert_array_equal(again.vertices, TUBE.vertices)
    assert again.polygons == TUBE.polygons
    assert sm.label(convert(TUBE)).face_count == sm.label(TUBE).face_count


def test_triangles_come_back_as_they_went_and_points_at_one_place_are_one_vertex():
    triangles = sm.to_trimesh(TUBE)
    assert len(triangles.faces) == 2 * TUBE.face_count and len(triangles.vertices) == len(TUBE.vertices)
    apart = triangles.copy()
    apart.unmerge_vertices()
    for given in (triangles, apart):
        again = sm.as_mesh(given, unit="mm")
        assert (len(again.vertices), again.face_count) == (len(TUBE.vertices), 2 * TUBE.face_count)
        np.testing.assert_allclose(np.ptp(again.vertices, axis=0), 0.1 * np.ptp(TUBE.vertices, axis=0), rtol=1e-12)


def test_strips_second_order_and_points_of_a_plane_are_understood():
    flat = np.array([[0, 0], [1, 0], [0, 1], [1, 1]], dtype=float)
    points = np.pad(flat, ((0, 0), (0, 1)))
    assert sm.as_mesh(pyvista.PolyData(points, strips=[4, 0, 1, 2, 3])).polygons == [[0, 1, 2], [1, 3, 2]]
    assert sm.as_mesh(meshio.Mesh(flat, [("line", [[0, 1]]), ("triangle", [[0, 1, 2]])])).polygons == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        (np.eye(3), ParameterError, "label: got .*expected a Mesh .*trimesh.Trimesh, meshio.Mesh, pyvista.PolyData"),
        (trimesh.Trimesh(), MeshError, "label: the trimesh.Trimesh has no faces"),
        (pyvista.PolyData(np.eye(3)), MeshError, "the pyvista.PolyData has no faces"),
        (meshio.Mesh(np.eye(4)[:, :3], [("tetra", [[0, 1, 2, 3]])]), MeshError, "meshio.Mesh: got tetra cells"),
    ],
)
def test_what_is_no_surface_is_refused_in_a_line(given, error, message):
    with pytest.raises(error, match=message):
        sm.label(given)


def test_meshes_of_libraries_are_knitted_and_written_where_a_folder_is_given(tmp_path):
    rough = sm.Quality(**(asdict(quality_named("draft")) | {"max_iterations": 1}))  # The yarns are made, not at rest.
    made = {}
    for place, folder in (("nowhere", None), ("folder", tmp_path)):
        made[place] = sm.knit(
            sm.to_trimesh(TUBE), stitch_width=1.0, auto=True, quality=rough, device="cpu", folder=folder
        )
    np.testing.assert_array_equal(made["nowhere"].yarns.points, made["folder"].yarns.points)
    np.testing.assert_array_equal(sm.read_yarns(tmp_path / "yarns.h5").points, made["folder"].yarns.points)
    assert sm.read_stitches(tmp_path / "stitches.h5").face_count == made["folder"].fabric.face_count


def test_a_mesh_of_triangles_is_refused_with_the_way_to_rows():
    with pytest.raises(LabelError, match=r"auto=True.*these are triangles"):
        sm.knit(sm.to_trimesh(TUBE))


@pytest.mark.parametrize("periodic", [False, True])
def test_yarns_are_polylines_of_their_length_and_tubes_in_their_colours(periodic):
    yarns = small_yarns(periodic)
    swatch = SimpleNamespace(yarns=yarns)  # A swatch is a value with yarns.
    lines, edges, tubes = sm.to_pyvista(swatch), sm.to_meshio(swatch), sm.to_trimesh(swatch)
    length = yarns.lengths.sum()
    ends = edges.points[edges.cells[0].data]
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(length, rel=0.03)  # Chords of arcs.
    assert lines.n_lines == len(yarns.closed)
    np.testing.assert_array_equal(edges.point_data["radius"], yarns.radius[edges.point_data["yarn"]])
    assert tubes.visual.vertex_colors.shape[0] == len(tubes.vertices)
    far = np.linalg.norm(np.asarray(lines.points)[None] - tubes.vertices[:, None], axis=2).min(axis=1)
    # Sections of tubes lie between points of the polyline.
    assert far.min() == pytest.approx(yarns.drawn_radius.min(), rel=0.05)
    with pytest.raises(ParameterError, match="expected a Mesh, a StitchMesh, a YarnSet, or a value with yarns"):
        sm.to_trimesh(3)

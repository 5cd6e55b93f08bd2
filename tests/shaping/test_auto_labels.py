# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows of large panels on any surface: legal, divided into the stitches of the surface, and edited as modelled rows."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import MeshError, ParameterError
from stitchmesh.labeling import PartialLabeling
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.shaping.auto_stitches import levels_of_part, shaping_surface
from stitchmesh.shaping.panel_rows import evenly, higher_bands
from stitchmesh.shaping.rows import StitchSize
from tests.gallery import ROOT, grid, tube
from tests.nightly import at_night
from tests.shaking import shaken
from tests.shaping.surfaces import closed_ball, in_triangles

MESHES = ROOT / "assets" / "meshes"
WIDTH = {"hat": 1.6, "sock": 1.4, "tea_cozy": 1.4, "glove": 0.7}
"""Widths of stitches [cm] at which a garment has less than two thousand of them."""


def euler(mesh: Mesh) -> int:
    return len(mesh.vertices) - len(mesh.edge_side) + mesh.face_count


def garment(name: str) -> Mesh:
    return in_triangles(sm.read_mesh(MESHES / f"{name}.obj"))


def labeled(mesh: Mesh, width: float, **options: int) -> StitchMesh:
    return sm.auto_labels(mesh, stitch_width=width, progress=False, **options)


def test_a_tube_has_as_many_stitches_as_without_panels():
    mesh = in_triangles(tube(40, 10, radius=4.0))
    panels = labeled(mesh, 0.8)
    assert (panels.stitch == Stitch.PANEL).all() and (panels.n_bottom == 1).all() and (panels.n_top == 1).all()
    # 31 stitches around are five panels, but a round has at least six; 16 courses are three rows.
    assert len(np.unique(panels.row)) == 3 and panels.face_count == 3 * 6
    stitches, direct = sm.tessellate(panels, stitch_width=0.8), sm.auto_stitches(mesh, stitch_width=0.8)
    assert stitches.face_count == direct.face_count
    assert (stitches.n_bottom == 1).all()


def test_a_flat_piece_has_rows_with_two_ends():
    panels = labeled(in_triangles(grid(6, 8)), 0.5)
    assert len(panels.boundary_loops) == 1 and panels.face_count == 2 * len(np.unique(panels.row))


@pytest.mark.decides
@pytest.mark.parametrize("name", ["glove", *at_night("sock", "tea_cozy")])
def test_triangulated_garments_keep_their_topology_through_panels_and_stitches(name):
    mesh = garment(name)
    panels = labeled(mesh, WIDTH[name])
    stitches = sm.tessellate(panels, stitch_width=WIDTH[name])
    for made in (panels, stitches):
        assert euler(made) == euler(mesh) and len(made.boundary_loops) == len(mesh.boundary_loops)
    assert max(stitches.n_bottom.max(), stitches.n_top.max()) <= 3
    # Panels are about as many stitches wide and courses high as asked; in narrow limbs, they are smaller.
    assert 6**2 / 3 < stitches.face_count / panels.face_count < 2 * 6**2


@pytest.mark.decides
def test_a_closed_surface_is_open_at_two_tips_only_however_it_is_rounded():
    mesh = closed_ball(24, 20)
    panels = labeled(mesh, 0.9)
    assert euler(panels) == euler(mesh) - 2 and len(panels.boundary_loops) == 2
    moved = labeled(Mesh.from_polygons(shaken(mesh.vertices, 0), mesh.face_vertex.reshape(-1, 3).tolist()), 0.9)
    for name in ("face_vertex", "twin", "n_bottom", "n_top", "row"):
        np.testing.assert_array_equal(getattr(moved, name), getattr(panels, name))


def test_rounds_are_multiples_of_what_a_pattern_repeats():
    panels = labeled(in_triangles(tube(40, 10, radius=4.0)), 0.8, multiple=4)
    stitches = sm.tessellate(panels, stitch_width=0.8)
    assert {int(np.sum(stitches.row == row)) for row in np.unique(stitches.row)} == {32}


def test_the_lines_of_higher_bands_are_some_of_all_lines_and_limbs_keep_theirs():
    size = StitchSize(2.0, 1.54)
    _, surface, up = shaping_surface(garment("sweater"), size, (0.0, 1.0, 0.0), ())
    courses, _, _ = levels_of_part(surface, (), up, size, lambda done, note: None)
    few = higher_bands(courses, 6)
    kept = {line for band in few.bands for line in band.below + band.above}
    joints = [band for band in few.bands if len(band.below) > 1 or len(band.above) > 1]
    assert few.lines is courses.lines and len(kept) < 0.3 * len(courses.lines)
    assert sum(len(band.below) for band in joints) - len(joints) == 2  # Each of two sleeves joins the body.
    beside = {line for band in courses.bands if len(band.below) > 1 for line in band.above}
    assert beside == {line for band in joints for line in band.above}  # The next line stays, and the graft is short.


def test_panels_of_a_garment_are_edited_as_modelled_rows_and_their_loops_hold_one_another():
    mesh = garment("hat")
    panels = labeled(mesh, 1.8)
    flipped = PartialLabeling.of_rows(panels).flip_row(0).finish()
    assert flipped.mismatched.any() and not panels.mismatched.any()
    assert sm.tessellate(flipped, stitch_width=1.8).mismatched.any()
    relaxed = sm.relax_mesh(sm.tessellate(panels, stitch_width=1.8), surface=mesh).fabric
    sm.check_loops(relaxed, sm.generate_yarns(relaxed, quality="draft"))


def test_parts_are_labeled_one_after_another():
    near = in_triangles(tube(16, 4, radius=2.0))
    vertices = np.concatenate([near.vertices, near.vertices + np.array([10.0, 0.0, 0.0])])
    faces = np.concatenate([near.face_vertex, near.face_vertex + len(near.vertices)]).reshape(-1, 3)
    both, alone = labeled(Mesh.from_polygons(vertices, faces.tolist()), 0.6), labeled(near, 0.6)
    assert both.face_count == 2 * alone.face_count and both.row.max() == 2 * alone.row.max() + 1


@pytest.mark.parametrize(("total", "parts", "expected"), [(6, 1, [6]), (7, 2, [4, 3]), (31, 6, [5, 5, 6, 5, 5, 5])])
def test_stitches_are_divided_evenly(total, parts, expected):
    assert evenly(total, parts).tolist() == expected


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"panel_size": 1}, ParameterError, "panel size: got 1; expected 2 or more stitches"),
        ({"multiple": 0}, ParameterError, "multiple"),
        ({"stitch_width": 50.0}, MeshError, "room for"),
    ],
)
def test_what_cannot_be_labeled_is_refused_in_one_line(options, error, words):
    with pytest.raises(error, match=words) as caught:
        sm.auto_labels(in_triangles(tube(16, 4)), **{"stitch_width": 1.0, **options})
    assert "\n" not in str(caught.value)

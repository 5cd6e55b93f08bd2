# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of whole fabrics: routes, closed rings, row ends and distances."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.labeling import label
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.bind_off import with_bind_off
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.embedding import place_parts
from stitchmesh.yarngen.row_ends import finish_row_ends
from stitchmesh.yarngen.tracing import TIED, link_ends, trace
from tests.gallery import FLAT_AND_ROUND, closed_cone, grid, torus, tube
from tests.nightly import at_night

pytestmark = pytest.mark.decides

QUALITIES = ("draft", *at_night("standard", "reference"))
FLAT = ("one quad", "flat", "pentagons")
"""Meshes of the gallery with flat rows."""


def panel(bottom: int, top: int) -> StitchMesh:
    """Two courses of ``bottom`` stitches, one course that changes to ``top`` stitches, and two more courses."""
    height, wide = 0.77, max(bottom, top)
    a, b = (wide - bottom) / 2, (wide - top) / 2
    levels = [(a, bottom, 0.0), (a, bottom, 1.5), (b, top, 3.0), (b, top, 4.0)]
    vertices = [[x, y * height, 0.0] for left, n, y in levels for x in (left, left + n)]
    mesh = Mesh.from_polygons(vertices, [[0, 1, 3, 2], [2, 3, 5, 4], [4, 5, 7, 6]])
    counts = {(0, 1): bottom, (2, 3): bottom, (4, 5): top, (6, 7): top, (0, 2): 2, (2, 4): 1, (4, 6): 2}
    return tessellate(label(mesh, seeds=[(0, 1)]), stitch_width=1.0, counts=counts)


def fabric_of(name: str) -> StitchMesh:
    return tessellate(label(FLAT_AND_ROUND[name]()), stitch_width=0.5)


@pytest.mark.parametrize("name", FLAT_AND_ROUND)
def test_every_part_belongs_to_exactly_one_yarn_which_crosses_course_sides_twice_and_wale_sides_once(name):
    """Two crossings on each course side between faces, one on each wale side. Yarns of round fabrics are rings."""
    fabric = fabric_of(name)
    whole = with_bind_off(fabric)
    parts = place_parts(whole, 0.05, 12)
    link = link_ends(whole, parts, finish_row_ends(whole))
    joined = np.flatnonzero(link != TIED)
    assert (link[link[joined]] == joined).all(), "links are mutual"
    yarns = trace(link)
    assert sorted(entry // 2 for yarn, _ in yarns for entry in yarn) == list(range(len(link) // 2))
    assert all(closed for _, closed in yarns) == (name not in FLAT)
    count = np.bincount(parts.end_side.ravel(), minlength=whole.side_count)
    inner = whole.twin >= 0
    assert (count[whole.is_wale] == 1).all()
    assert (count[inner & ~whole.is_wale] == 2).all()
    assert (count[~inner & ~whole.is_wale] == 0).all()


def test_a_flat_piece_is_one_yarn_with_two_ends_and_a_tube_is_a_ring_for_each_row_and_one_for_the_bind_off():
    for courses in (4, 5):
        fabric = tessellate(label(grid(1, 1, width=4.0, height=3.0)), stitch_width=0.5, counts={(0, 2): courses})
        yarns = generate_yarns(fabric, quality="draft")
        assert yarns.yarn_count == 1 and not yarns.closed.any()
    fabric = fabric_of("tube")
    yarns = generate_yarns(fabric, quality="draft")
    assert yarns.closed.all() and yarns.yarn_count == fabric.row.max() + 2
    for first, last in pairwise(yarns.start):
        assert len(set(yarns.row[first:last])) == 1


def test_rows_of_opposite_wale_direction_are_linked_by_rings_of_their_own():
    """Between two tubes knitted towards each other, each pair of neighbouring stitches shares one small closed ring."""
    labeled = label(tube(8, 2), flip=[8])
    fabric = tessellate(labeled, stitch_width=1.0)
    around = int((fabric.row == 0).sum())
    yarns = generate_yarns(fabric)
    assert yarns.closed.all()
    faces = [set(yarns.face[a:b]) for a, b in pairwise(yarns.start)]
    assert sum(len(each) == 4 for each in faces) == around


def test_a_closed_torus_needs_no_cast_on():
    fabric = tessellate(label(torus(8, 12), seeds=[(0, 1)]), stitch_width=0.4)
    assert Stitch.CAST_ON not in fabric.stitch
    yarns = generate_yarns(fabric, yarn_radius=0.03)
    assert yarns.closed.all() and yarns.yarn_count == fabric.row.max() + 1


@pytest.mark.parametrize("quality", QUALITIES)
@pytest.mark.parametrize(
    ("bottom", "top", "radii"), [(6, 6, 1.0), (2, 4, 1.0), (1, 3, 1.0), (4, 2, 0.75), (3, 9, 0.5), (9, 3, 0.5)]
)
def test_yarns_start_apart(bottom, top, radii, quality):
    """Touching yarns are two radii apart; every stitch among plain stitches keeps at least one radius.

    Two decreases side by side that lean towards each other keep three quarters of it. Triple increases and decreases
    side by side are the densest fabric.
    """
    yarns = generate_yarns(panel(bottom, top), yarn_radius=0.125, quality=quality)
    distance, point = smallest_distance(yarns, within=0.25)
    assert radii * 0.125 < distance < 0.25, f"near control point {point}"


@pytest.mark.parametrize("quality", QUALITIES)
def test_knit_and_purl_in_any_order_start_at_least_one_radius_apart(quality):
    fabric = tessellate(label(grid(1, 1, width=8.0, height=8 * 0.77)), stitch_width=1.0)
    rng = np.random.default_rng(5)
    mixed = np.where(rng.random(fabric.face_count) < 0.5, Stitch.PURL, Stitch.KNIT)
    fabric = replace(fabric, stitch=np.where(fabric.stitch == Stitch.KNIT, mixed, fabric.stitch))
    distance, _ = smallest_distance(generate_yarns(fabric, yarn_radius=0.125, quality=quality), 0.25)
    assert 0.125 < distance < 0.25


def test_bind_off_adds_a_face_for_each_top_border_side():
    fabric = tessellate(label(tube(8, 2)), stitch_width=0.5)
    whole = with_bind_off(fabric)
    assert whole.face_count - fabric.face_count == (fabric.row == fabric.row.max()).sum()
    np.testing.assert_array_equal(whole.stitch[: fabric.face_count], fabric.stitch)
    # a tube stays a tube
    assert len(whole.vertices) - len(whole.edge_side) + whole.face_count == 0
    assert with_bind_off(tessellate(label(closed_cone(6)), stitch_width=0.5)).face_count > 0


def test_a_coarse_mesh_has_no_yarns_yet():
    with pytest.raises(YarnError, match="face 0: is a panel"):
        generate_yarns(label(grid(2, 2)))


@pytest.mark.parametrize(("radius", "message"), [(0.0, "positive"), (np.nan, "positive"), (0.3, "too thick")])
def test_a_yarn_radius_must_be_positive_and_fit_the_stitches(radius, message):
    with pytest.raises(ParameterError, match=message):
        generate_yarns(fabric_of("flat"), yarn_radius=radius)


def test_a_loop_that_nothing_holds_is_refused():
    fabric = fabric_of("flat")
    inner = int(np.flatnonzero(fabric.row == 1)[0])
    stitch = fabric.stitch.copy()
    stitch[inner] = Stitch.CAST_ON
    with pytest.raises(YarnError, match="meets no other yarn; put a stitch there that holds the loop"):
        generate_yarns(replace(fabric, stitch=stitch))


def test_yarns_that_start_in_one_place_are_refused():
    """Stitches that are compressed to a hundredth of their width overlap."""
    fabric = tessellate(label(grid(1, 1, width=4.0, height=3.0)), stitch_width=0.5)
    squeezed = fabric.vertices * [1.0, 0.01, 1.0]
    with pytest.raises(YarnError, match=r"face \d+: yarns start 0\.\d+ radii apart, expected at least 0.25") as refused:
        generate_yarns(replace(fabric, vertices=squeezed))
    assert str(refused.value).startswith(f"face {refused.value.face}:")


def slit_tube() -> Mesh:
    """A tube of four rows whose two middle rows are open along one wale: one vertex in the slit is duplicated."""
    whole, seam = tube(8, 4, radius=4.0, height=2.0), 2 * 8
    vertices = np.concatenate([whole.vertices, whole.vertices[[seam]] - [0.6, 0.0, 0.0]])
    faces = whole.face_vertex.reshape(-1, 4).copy()
    left_of_slit = np.arange(len(faces)) % 8 == 7
    faces[(faces == seam) & left_of_slit[:, None]] = len(whole.vertices)
    return Mesh.from_polygons(vertices, faces.tolist())


def test_the_yarn_continues_across_the_foot_and_the_head_of_a_slit():
    """Rows that end at the slit are joined to each other, so that no yarn has a loose end."""
    labeled = label(slit_tube())
    assert len(labeled.boundary_loops) == 3
    assert generate_yarns(tessellate(labeled, stitch_width=0.5)).closed.all()

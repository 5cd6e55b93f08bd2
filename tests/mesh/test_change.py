# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Changes of a stitch mesh: removed and added faces, exact inverses, and invalid changes."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from stitchmesh import label, tessellate
from stitchmesh.errors import LabelError, MeshError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Marks, Patch, apply_change, inverse_change
from stitchmesh.mesh.patch_builder import NewFace, PatchBuilder, edge_of
from stitchmesh.mesh.stitch import Stitch
from tests.gallery import grid, tube


def fabric(*, with_stretch: bool = True) -> StitchMesh:
    made = tessellate(label(tube(8, 3)), stitch_width=0.8)
    stretch = np.random.default_rng(1).uniform(0.8, 1.2, len(made.edge_side)) if with_stretch else None
    return replace(made, stretch=stretch)


def assert_same(first: StitchMesh, second: StitchMesh) -> None:
    for part in fields(StitchMesh):
        a, b = getattr(first, part.name), getattr(second, part.name)
        if a is None or b is None:
            assert a is b, part.name
        else:
            np.testing.assert_array_equal(a, b, err_msg=part.name)


def sides_and_corners(mesh: StitchMesh, face: int) -> tuple[list[int], list[int]]:
    sides = mesh.sides_of(np.array([face])).tolist()
    return sides, mesh.face_vertex[sides].tolist()


def more_loops(mesh: StitchMesh, face: int) -> Patch:
    """Split the edge between a knit stitch and the stitch above it into two: the stitches become ky and d12k."""
    low, a = sides_and_corners(mesh, face)
    above = int(mesh.side_face[mesh.twin[low[2]]])
    high, b = sides_and_corners(mesh, above)
    builder = PatchBuilder(mesh)
    builder.remove(face)
    builder.remove(above)
    middle = builder.vertex(mesh.vertices[a[2:4]].mean(axis=0))
    e, f = [edge_of(mesh, side) for side in low], [edge_of(mesh, side) for side in high]
    left, right = ("left",), ("right",)
    rows = mesh.row[[face, above]].tolist()
    builder.put(NewFace([a[0], a[1], a[2], middle, a[3]], [e[0], e[1], right, left, e[3]], 1, 2, Stitch.KY, rows[0],
                        twist=(1, -1)))  # fmt: skip
    builder.put(NewFace([b[0], middle, *b[1:]], [left, right, *f[1:]], 2, 1, Stitch.D12K, rows[1]))
    return builder.patch()


def inner_knit(mesh: StitchMesh) -> int:
    """A knit stitch with other stitches above and below it."""
    return int(np.flatnonzero((mesh.stitch == Stitch.KNIT) & (mesh.row == 2))[0])


def test_a_patch_adds_its_faces_and_leaves_the_other_faces_unchanged():
    mesh = fabric()
    face = inner_knit(mesh)
    changed = apply_change(mesh, more_loops(mesh, face))
    assert len(changed.vertices) == len(mesh.vertices) + 1 and changed.face_count == mesh.face_count
    assert changed.stitch[face] == Stitch.KY and changed.n_top[face] == 2
    assert (changed.stitch != mesh.stitch).sum() == 2
    tops = changed.sides_of(np.array([face]))[2:4]
    assert changed.twist[tops].tolist() == [-1, 1]  # Top sides run from right to left.
    assert np.isnan(changed.stretch).sum() == 2  # The two added edges have no stretch.
    everything = {part.name: getattr(changed, part.name) for part in fields(StitchMesh)}
    assert_same(StitchMesh(**everything), changed)  # The constructor checks the whole mesh.


@pytest.mark.parametrize("with_stretch", [True, False])
def test_a_patch_and_its_inverse_restore_every_array(with_stretch):
    mesh = fabric(with_stretch=with_stretch)
    patch = more_loops(mesh, inner_knit(mesh))
    changed = apply_change(mesh, patch)
    back = inverse_change(mesh, patch)
    assert_same(apply_change(changed, back), mesh)
    again = inverse_change(changed, back)
    assert_same(apply_change(apply_change(changed, back), again), changed)


def test_removed_faces_and_vertices_are_restored_with_their_numbers():
    """A row of a flat piece is removed from the middle of the numbering and restored."""
    mesh = tessellate(label(grid(3, 4)), stitch_width=0.5)
    builder = PatchBuilder(mesh)
    for face in np.flatnonzero(mesh.row == mesh.row.max()):
        builder.remove(int(face))
    patch = builder.patch()
    assert len(patch.removed_vertices) == (mesh.row == mesh.row.max()).sum() + 1
    smaller = apply_change(mesh, patch)
    assert smaller.row.max() == mesh.row.max() - 1
    assert_same(apply_change(smaller, inverse_change(mesh, patch)), mesh)


def test_invalid_marks_are_refused_and_change_nothing():
    mesh = fabric()
    face = inner_knit(mesh)
    before = {part.name: getattr(mesh, part.name) for part in fields(StitchMesh)}
    with pytest.raises(LabelError, match=rf"face {face}: .* \(k2tog\) on 1 bottom and 1 top sides; it needs 2 and 1"):
        apply_change(mesh, Marks("stitch", np.array([face]), np.array([Stitch.D12K])))
    with pytest.raises(LabelError, match="has a twist; only top sides"):
        apply_change(mesh, Marks("twist", mesh.face_start[[face]], np.array([1])))
    with pytest.raises(MeshError, match=f"change of yarn: there is no face {mesh.face_count}; expected 0 to"):
        apply_change(mesh, Marks("yarn", np.array([mesh.face_count]), np.array([1])))
    assert all(getattr(mesh, name) is value for name, value in before.items())


def test_a_patch_of_another_mesh_is_refused():
    mesh = fabric()
    patch = more_loops(mesh, inner_knit(mesh))
    small = tessellate(label(grid(1, 1)), stitch_width=0.5)
    with pytest.raises(MeshError, match="there is no face"):
        apply_change(small, patch)


def test_faces_that_meet_only_in_a_vertex_are_refused():
    """Two stitches share only a corner after the stitches between them are removed."""
    mesh = tessellate(label(grid(2, 2)), stitch_width=1.0, stitch_height=1.0)
    builder = PatchBuilder(mesh)
    corner = int(np.flatnonzero(np.bincount(mesh.face_vertex) == 4)[0])
    around = np.unique(mesh.side_face[mesh.face_vertex == corner])
    opposite = [face for face in around[1:] if len(np.intersect1d(
        mesh.side_edge[mesh.sides_of(around[:1])], mesh.side_edge[mesh.sides_of(np.array([face]))])) == 0]  # fmt: skip
    builder.remove(int(around[0]))
    builder.remove(int(opposite[0]))
    with pytest.raises(MeshError, match=r"vertex .*separate parts of the surface meet"):
        apply_change(mesh, builder.patch())


def test_an_edge_with_three_sides_is_refused():
    mesh = fabric()
    face = inner_knit(mesh)
    sides, corners = sides_and_corners(mesh, face)
    builder = PatchBuilder(mesh)
    edges = [edge_of(mesh, side) for side in sides]
    builder.put(NewFace(corners, edges, 1, 1, Stitch.KNIT, 2))
    with pytest.raises(MeshError, match="would belong to 3 faces"):
        builder.patch()

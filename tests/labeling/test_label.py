# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Labeling: rows on irregular meshes, on every garment and on a real skirt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import LabelError, ParameterError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import direction, label, start_labeling
from stitchmesh.mesh import BORDER, StitchMesh
from tests.gallery import FLAT_AND_ROUND, GARMENTS, closed_cone, grid, odd_corner, pentagon_row, shared, torus, tube
from tests.shaking import shaken

pytestmark = pytest.mark.decides


def assert_rows(fabric: StitchMesh) -> None:
    """Check that faces joined across wale edges have the same row and the same wale direction."""
    inner = np.flatnonzero(fabric.is_wale & (fabric.twin != BORDER))
    faces, across = fabric.side_face[inner], fabric.side_face[fabric.twin[inner]]
    assert (fabric.row[faces] == fabric.row[across]).all()
    assert not fabric.mismatched[fabric.is_wale].any(), "the wale direction changes within a row"
    assert sorted(set(fabric.row)) == list(range(fabric.row.max() + 1))


@pytest.mark.parametrize("path", GARMENTS, ids=lambda path: path.stem)
def test_every_garment_is_labeled_without_seeds(path):
    fabric = label(read_mesh(path))
    assert_rows(fabric)
    assert (fabric.n_bottom == 1).all() and (fabric.n_top == 1).all()


def test_a_real_skirt_has_the_nineteen_rows_it_was_modelled_with():
    fabric = label(read_mesh(shared("meshes/makehuman-helper-skirt.obj"), unit="dm"))
    assert_rows(fabric)
    assert np.bincount(fabric.row).tolist() == [36] * 19
    assert not fabric.mismatched.any()


def test_the_longest_border_is_the_cast_on():
    fabric = label(tube(8, 3, radius=2.0, top_radius=4.0))
    first = fabric.row[fabric.side_face[fabric.boundary_loops[0]]]
    widest = max(fabric.boundary_loops, key=lambda loop: fabric.side_length[loop].sum())
    assert (fabric.row[fabric.side_face[widest]] == 0).all() and len(set(first)) == 1
    assert (fabric.side_role[widest] == 0).all()


def test_a_flat_piece_is_knitted_upwards_from_its_lowest_side():
    fabric = label(grid(4, 3))
    bottom = fabric.corner_position[fabric.face_start[:-1], 1]
    np.testing.assert_array_equal(fabric.row, bottom.astype(int))


def test_a_pentagon_between_quads_gets_two_top_edges():
    fabric = label(pentagon_row(), seeds=[(0, 1)])
    assert sorted(zip(fabric.n_bottom.tolist(), fabric.n_top.tolist(), strict=True)) == [(1, 1)] * 4 + [(1, 2)] * 2


def test_triangles_at_a_pole_end_their_row():
    fabric = label(closed_cone(6))
    last = fabric.row == fabric.row.max()
    assert (fabric.n_top[last] == 0).all() and (fabric.n_bottom[last] == 1).all()


def test_a_seed_chooses_the_border_that_rows_start_from():
    mesh = tube(8, 3)
    fabric = label(mesh, seeds=[(8 * 3 + 1, 8 * 3)])
    assert (fabric.face_vertex[fabric.side_role == 0].max()) >= 8 * 3
    assert (fabric.row[-8:] == 0).all()


def test_a_seed_at_a_former_wale_edge_turns_the_rows_by_a_right_angle():
    mesh = grid(4, 3)
    assert np.bincount(label(mesh).row).tolist() == [4, 4, 4]
    assert np.bincount(label(mesh, seeds=[(0, 5)]).row).tolist() == [3, 3, 3, 3]


def test_flipping_a_row_reverses_only_its_own_direction():
    mesh = tube(8, 3)
    plain, flipped = label(mesh), label(mesh, flip=[8])
    row = plain.row[8]
    # The row has 8 edges at each of its two course seams, and each edge has two mismatched sides.
    assert flipped.mismatched.sum() == 2 * 2 * 8
    others = [(f.side_role == 0) & (f.row[f.side_face] != row) for f in (plain, flipped)]
    assert set(plain.face_vertex[others[0]]) == set(flipped.face_vertex[others[1]])


def test_a_closed_mesh_is_seeded_by_an_edge_loop():
    mesh = torus(6, 8)
    with pytest.raises(LabelError, match="no border to start from"):
        label(mesh)
    fabric = label(mesh, seeds=[(0, 1)])
    assert_rows(fabric)
    assert np.bincount(fabric.row).tolist() == [6] * 8
    assert not fabric.mismatched.any()


def test_the_message_for_a_mesh_without_rows_names_the_faces_and_a_remedy():
    conflict = r"face \d+ and \d+: edge \d+-\d+ would be both wale and course.*start at another edge"
    with pytest.raises(LabelError, match=conflict):
        label(odd_corner())


def test_a_seed_that_is_not_an_edge_and_a_face_that_does_not_exist_are_refused():
    for seed in ((0, 99), 1000, (0, 4)):
        with pytest.raises(ParameterError, match=r"no edge joins|there is no side"):
            label(grid(2, 2), seeds=[seed])
    with pytest.raises(ParameterError, match="face 77 does not exist"):
        label(grid(2, 2), flip=[77])


@pytest.mark.parametrize("name", FLAT_AND_ROUND)
def test_every_mesh_of_the_gallery_has_rows_which_are_the_same_if_it_is_moved_and_shaken(name: str) -> None:
    """Borders and seams of one length, which the meshes of the gallery have, differ in their last bits then."""
    mesh = FLAT_AND_ROUND[name]()
    expected = label(mesh)
    assert_rows(expected)
    for seed in range(4):
        moved = mesh.vertices + seed * np.array([100.0, -50.0, 7.0])
        found = label(replace(mesh, vertices=shaken(moved, seed)))
        for field in ("face_vertex", "row", "n_bottom", "twin"):
            np.testing.assert_array_equal(getattr(found, field), getattr(expected, field))


def test_seams_that_match_as_far_as_they_mismatch_are_alike_however_shaken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their balance is zero but for rounding, and the sign of what rounding leaves would turn rows over."""
    mesh = tube(8, 2)
    labels = start_labeling(mesh).label_all()
    seam = np.flatnonzero((mesh.twin > np.arange(mesh.side_count)) & (labels.edge_label[mesh.side_edge] == 0))
    top = np.zeros(mesh.side_count, dtype=bool)
    top[[*seam, *mesh.twin[seam[: len(seam) // 2]]]] = True
    monkeypatch.setattr(direction, "is_top", lambda mesh, sides, left, right: top[sides])
    for seed in range(10):
        shake = replace(mesh, vertices=shaken(mesh.vertices, seed))
        assert direction._neighbours(shake, labels) == [(0, 1, 0)]

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cloths from texture coordinates: islands, seams, scale, mirrored islands, and files that are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import BORDER
from stitchmesh.mixed.cloth.from_obj import cloth_from_obj
from tests.gallery import SHARED


def write_obj(path: Path, vertices, texture, faces) -> Path:
    """Write an OBJ file; each corner of a face is (vertex, texture coordinate), from 0."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices, dtype=float).tolist()]
    lines += [f"vt {u!r} {v!r}" for u, v in np.asarray(texture, dtype=float).tolist()]
    lines += ["f " + " ".join(f"{v + 1}/{t + 1}" for v, t in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def lens(path: Path, unit: float) -> Path:
    """Two cones of 24 triangles on one ring of radius 3 cm, both seen from above, so that the lower one is mirrored.

    Texture coordinates are in ``unit`` cm; a cone is a disc of radius 5 cm.
    """
    angle = 2 * np.pi * np.arange(24) / 24
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    vertices = [*np.column_stack([3 * ring, np.zeros(24)]), [0.0, 0.0, 4.0], [0.0, 0.0, -4.0]]
    disc = np.concatenate([5 * ring, np.zeros((1, 2))])
    texture = np.concatenate([disc, disc + np.array([15.0, 0.0])]) / unit
    sides = [(k, (k + 1) % 24) for k in range(24)]
    upper = [[(a, a), (b, b), (24, 24)] for a, b in sides]
    lower = [[(b, 25 + b), (a, 25 + a), (25, 49)] for a, b in sides]
    return write_obj(path, vertices, texture, upper + lower)


def cylinder(path: Path, *, around: int = 12, rows: int = 4) -> Path:
    """A tube of radius 2 and height 4, cut open along a line of its one island, which is 1 wide in the texture."""
    angle = 2 * np.pi * np.arange(around) / around
    vertices = [[2 * np.sin(a), 4 * r / rows, 2 * np.cos(a)] for r in range(rows + 1) for a in angle]
    texture = [[k / around, r / rows / np.pi] for r in range(rows + 1) for k in range(around + 1)]

    def corner(r: int, k: int) -> tuple[int, int]:
        return r * around + k % around, r * (around + 1) + k

    faces = [
        [corner(r, k), corner(r, k + 1), corner(r + 1, k + 1), corner(r + 1, k)]
        for r in range(rows)
        for k in range(around)
    ]
    return write_obj(path, vertices, texture, faces)


def test_the_islands_of_a_lens_are_its_panels_and_its_ring_is_their_seam(tmp_path):
    cloth = cloth_from_obj(lens(tmp_path / "lens.obj", 10.0), texture_unit=10.0, seam_angle=30.0)
    assert cloth.panel_names == ("island 0", "island 1") and cloth.seam_count == 1
    assert len(cloth.seam_edges) == 24 and cloth.seam_edges[0, 0] == cloth.seam_edges[-1, 1]
    assert (cloth.panel[cloth.seam_sides // 3] == [0, 1]).all()
    assert not cloth.vertices[cloth.seam_edges][..., 2].any()
    np.testing.assert_allclose(cloth.seam_angle, np.radians(30.0))
    assert (cloth.twin != BORDER).all()
    polygon = 0.5 * 24 * np.sin(2 * np.pi / 24)
    np.testing.assert_allclose(cloth.rest_area.sum(), 2 * polygon * 5.0**2, rtol=1e-12)


def test_the_scale_is_that_of_the_median_edge(tmp_path):
    path = cylinder(tmp_path / "tube.obj")
    cloth = cloth_from_obj(path)
    assert len(cloth.panel_names) == 1 and cloth.seam_count == 1 and len(cloth.seam_edges) == 4  # it meets itself
    ends = cloth.vertices[cloth.side_vertices]
    space = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    rest = np.linalg.norm(np.diff(cloth.side_rest, axis=1)[:, 0], axis=1)
    np.testing.assert_allclose(np.median(space / rest), 1.0, rtol=1e-12)
    given = cloth_from_obj(path, texture_unit=4 * np.pi)
    np.testing.assert_allclose(np.ptp(given.rest[..., 1]), 4.0, rtol=1e-12)
    inches = cloth_from_obj(path, unit="inch")
    np.testing.assert_allclose(inches.rest, 2.54 * cloth.rest, rtol=1e-12)


def test_texture_coordinates_with_the_same_numbers_are_one(tmp_path):
    path = write_obj(
        tmp_path / "pair.obj",
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
        [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]],
        [[(0, 0), (1, 1), (2, 2)], [(0, 3), (2, 4), (3, 5)]],
    )
    assert cloth_from_obj(path).seam_count == 0


def test_vertices_that_are_written_twice_are_joined_on_demand(tmp_path):
    flat = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 1e-7], [2, 0, 0], [2, 1, 0], [1, 1, 0]]
    texture = [[0, 0], [1, 0], [1, 1], [0, 1], [5, 0], [6, 0], [6, 1], [5, 1]]
    path = write_obj(tmp_path / "twice.obj", flat, texture, [[(k, k) for k in range(4)], [(k, k) for k in range(4, 8)]])
    assert cloth_from_obj(path).seam_count == 0
    joined = cloth_from_obj(path, weld=1e-5)
    assert joined.seam_count == 1 and len(joined.vertices) == 6 and len(joined.panel_names) == 2


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
REFUSED = {
    r"line 9: corner '1' has no texture coordinates; expected v/vt; unwrap": SQUARE + "f 1 2 3\n",
    "line 9: texture coordinate 9 does not exist; the file has 4": SQUARE + "f 1/9 2/2 3/3\n",
    "line 9: vertex 7 does not exist": SQUARE + "f 7/1 2/2 3/3\n",
    "line 9: got a face of 2 corners": SQUARE + "f 1/1 2/2\n",
    "line 1: got 'vt 0 x'; expected 'vt u v'": "vt 0 x\n",
    "got 4 vertices and no faces": SQUARE,
    "line 9: a triangle has no area in the texture": SQUARE + "f 1/1 2/2 3/2\n",
    "line 10: a triangle is turned over in the texture, unlike most of island 0":
        SQUARE + "f 1/1 2/2 3/3\nf 1/1 3/3 4/2\n" + "v 2 0 0\nvt 2 0\nf 2/2 5/5 3/3\n",
    "both faces pass it in the same direction": SQUARE + "f 1/1 2/2 3/3\nf 1/1 4/4 3/3\n",
}  # fmt: skip


@pytest.mark.parametrize("message", REFUSED)
def test_files_that_are_refused(message, tmp_path):
    path = tmp_path / "cloth.obj"
    path.write_text(REFUSED[message])
    with pytest.raises(StitchMeshError, match=message) as caught:
        cloth_from_obj(path)
    assert "\n" not in str(caught.value)


def test_an_island_that_overlaps_itself_is_refused(tmp_path):
    turns = 2.2 * 2 * np.pi * np.arange(25) / 24
    inner = [[np.cos(a), np.sin(a), a] for a in turns]
    outer = [[2 * np.cos(a), 2 * np.sin(a), a] for a in turns]
    faces = [[(k, k), (25 + k, 25 + k), (26 + k, 26 + k), (k + 1, k + 1)] for k in range(24)]
    path = write_obj(tmp_path / "screw.obj", inner + outer, np.array(inner + outer)[:, :2], faces)
    with pytest.raises(StitchMeshError, match="island 0: its border crosses or touches itself at the faces of lines"):
        cloth_from_obj(path)


def test_a_texture_unit_that_is_refused(tmp_path):
    with pytest.raises(StitchMeshError, match=r"texture unit: got 0\.0"):
        cloth_from_obj(lens(tmp_path / "lens.obj", 1.0), texture_unit=0.0)


def test_a_real_body_without_texture_coordinates_is_refused_with_its_line():
    path = SHARED / "meshes" / "makehuman-body.obj"
    if not path.exists():
        pytest.skip("the body is not in the folder beside the project (shared)")
    with pytest.raises(StitchMeshError, match=r"line \d+: corner '4849' has no texture coordinates"):
        cloth_from_obj(path)

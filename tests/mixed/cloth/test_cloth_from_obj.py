# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cloths from texture coordinates: islands, seams, scale, mirrored islands, and files that are refused."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import BORDER
from stitchmesh.mixed.cloth.from_obj import cloth_from_obj
from stitchmesh.mixed.layout.weave import lay_weave
from tests.gallery import SHARED
from tests.mixed.cloth.textured_shapes import cylinder, globe, write_obj
from tests.mixed.layout.test_weave import PLAIN, check_yarns


def test_the_islands_of_a_globe_are_its_panels_and_the_equator_is_its_seam(tmp_path):
    cloth = cloth_from_obj(globe(tmp_path / "globe.obj", unit=10.0), texture_unit=10.0, seam_angle=30.0)
    assert cloth.panel_names == ("island 0", "island 1") and cloth.seam_count == 1
    assert len(cloth.seam_edges) == 24 and cloth.seam_edges[0, 0] == cloth.seam_edges[-1, 1]
    assert (cloth.panel[cloth.seam_sides // 3] == [0, 1]).all()
    assert (np.abs(cloth.vertices[cloth.seam_edges][..., 2]) < 1e-12).all()
    np.testing.assert_allclose(cloth.seam_angle, np.radians(30.0))
    assert (cloth.twin != BORDER).all()
    polygon = 0.5 * 24 * np.sin(2 * np.pi / 24)
    np.testing.assert_allclose(cloth.rest_area.sum(), 2 * polygon * (5 * np.pi / 2) ** 2, rtol=1e-12)


def test_the_scale_is_that_of_the_median_edge(tmp_path):
    path = cylinder(tmp_path / "tube.obj")
    cloth = cloth_from_obj(path)
    ends = cloth.vertices[cloth.side_vertices]
    space = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    rest = np.linalg.norm(np.diff(cloth.side_rest, axis=1)[:, 0], axis=1)
    np.testing.assert_allclose(np.median(space / rest), 1.0, rtol=1e-12)
    given = cloth_from_obj(path, texture_unit=4 * np.pi)
    np.testing.assert_allclose(np.ptp(given.rest[..., 1]), 4.0, rtol=1e-12)
    inches = cloth_from_obj(path, unit="inch")
    np.testing.assert_allclose(inches.rest, 2.54 * cloth.rest, rtol=1e-12)


def test_an_island_that_meets_itself_has_a_seam(tmp_path):
    cloth = cloth_from_obj(cylinder(tmp_path / "tube.obj"))
    assert len(cloth.panel_names) == 1 and cloth.seam_count == 1 and len(cloth.seam_edges) == 4
    assert np.count_nonzero(cloth.twin == BORDER) == 24


def test_a_weave_on_a_globe(tmp_path):
    cloth = cloth_from_obj(globe(tmp_path / "globe.obj"), texture_unit=1.0)
    yarns = lay_weave(cloth, PLAIN, ends=4.0, picks=4.0)
    check_yarns(cloth, yarns)
    distance = np.linalg.norm(yarns.world(cloth), axis=1)
    assert 4.8 < distance.min() and distance.max() < 5.0 + 1e-12  # chords of 15 degrees
    assert np.count_nonzero(yarns.side == 0) > 100


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


def test_vertices_without_faces_are_left_out(tmp_path):
    path = write_obj(tmp_path / "t.obj", [[9, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0], [1, 0], [0, 1]],
                     [[(1, 0), (2, 1), (3, 2)]])  # fmt: skip
    assert len(cloth_from_obj(path).vertices) == 3


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
REFUSED = {
    r"line 9: corner '1' has no texture coordinates; expected v/vt; unwrap": SQUARE + "f 1 2 3\n",
    r"line 9: corner '1//1' has no texture coordinates": SQUARE + "f 1//1 2//1 3//1\n",
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


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"texture_unit": 0.0}, "texture unit: got 0.0"),
        ({"weld": -1.0}, "weld: got -1.0"),
        ({"seam_angle": np.inf}, "seam angle"),
        ({"unit": "yard"}, "unit"),
    ],
)
def test_arguments_that_are_refused(fields, message, tmp_path):
    with pytest.raises(StitchMeshError, match=message):
        cloth_from_obj(globe(tmp_path / "globe.obj"), **fields)


def test_a_real_body_without_texture_coordinates_is_refused_with_its_line():
    path = SHARED / "meshes" / "makehuman-body.obj"
    if not path.exists():
        pytest.skip("the body is not in the folder beside the project (shared)")
    with pytest.raises(StitchMeshError, match=r"line \d+: corner '4849' has no texture coordinates"):
        cloth_from_obj(path)

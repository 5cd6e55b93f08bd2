# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files with soups, as modelling programs write them."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import FileError, MeshError
from stitchmesh.io import read_mesh
from stitchmesh.io.meshes import FORMATS, read_polygons, read_repaired_mesh
from stitchmesh.mesh.repair import RepairOptions
from tests.mesh.repair.soups import actions, cut, ring, shape

TEXTURED = """
v 0 0 0
v 1 0 0
v 0 1 0
v 1 0 0
v 0 1 0
v 1 1 0
vt 0 0
f 1/1/1 2/1/1 3/1/1
f 4/1/1 6/1/1 5/1/1
f 4/1/1 6/1/1 5/1/1
f 1/1/1 2/1/1
f 1/1/1 1/1/1 3/1/1
"""
TWO_CORNERS = {
    "m.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\n",
    "m.off": "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n",
    "m.ply": "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n",
}
"""Files with a face of two corners."""


def test_an_obj_file_with_a_seam_of_its_texture_is_read(tmp_path):
    path = tmp_path / "m.obj"
    path.write_text(TEXTURED)
    repaired = read_repaired_mesh(path, unit="m")
    assert repaired.mesh.polygons == [[0, 1, 2], [1, 3, 2]]
    np.testing.assert_array_equal(np.ptp(repaired.mesh.vertices, axis=0), [100.0, 100.0, 0.0])
    assert actions(repaired) == {"faces without area": 2, "duplicate faces": 1, "welded vertices": 2}


@pytest.mark.parametrize("suffix", [".obj", ".stl"])
def test_soups_of_a_format_with_vertices_and_of_one_without_are_repaired(tmp_path, suffix):
    path = tmp_path / f"m{suffix}"
    vertices, faces = cut(*ring())
    FORMATS[suffix].write(path, vertices, [*faces, faces[4], [faces[7][0], faces[7][0], faces[7][1]]])
    repaired = read_repaired_mesh(path)
    assert shape(repaired.mesh) == (240, 480, 0, [])
    assert actions(repaired)["duplicate faces"] == 1
    with pytest.raises(MeshError):
        read_mesh(path)


@pytest.mark.parametrize("name", TWO_CORNERS)
def test_a_face_of_two_corners_is_an_error_for_meshes_and_is_left_out_by_a_repair(tmp_path, name):
    path = tmp_path / name
    path.write_text(TWO_CORNERS[name])
    with pytest.raises(FileError, match=r"at least (3|3 and the corners)"):
        read_mesh(path)
    assert read_polygons(path)[1] == [[0, 1, 2], [0, 1]]
    assert actions(read_repaired_mesh(path)) == {"faces without area": 1}


def test_options_reach_the_repair_and_errors_name_the_file(tmp_path):
    path = tmp_path / "m.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1.1 0 0\nv 0 1.1 0\nv 1 1 0\nf 1 2 3\nf 4 6 5\n")
    assert len(read_repaired_mesh(path).components) == 2
    assert len(read_repaired_mesh(path, options=RepairOptions(weld_distance=0.2)).components) == 1
    path.write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
    with pytest.raises(MeshError, match=r"m.obj: mesh: none of the 1 faces has an area"):
        read_repaired_mesh(path)

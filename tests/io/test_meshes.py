# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes: written meshes are read again, and each kind of malformed file has an error message of its own."""

from __future__ import annotations

import os
import struct
from pathlib import Path

import meshio
import numpy as np
import pytest

from stitchmesh.errors import FileError, MeshError, ParameterError
from stitchmesh.io import read_mesh, write_mesh
from stitchmesh.io.mesh_formats.cells import used_points
from stitchmesh.io.meshes import FORMATS
from stitchmesh.mesh import Mesh
from tests.io.refusals import refused

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "meshes"

# Two triangles, a quad and a pentagon around one vertex. The coordinates have no finite decimal form.
VERTICES = np.array(
    [
        [0, 0, 0],
        [1, 0, 1 / 3],
        [1.2, 0.9, 0],
        [0.1, 1, 0],
        [-1, 0.7, np.pi],
        [-1, -1, 1e-17],
        [0, -1.1, 1e5],
        [0.9, -0.8, 0],
    ]
)
FACES = [[0, 1, 2], [0, 2, 3], [0, 3, 4, 5], [0, 5, 6, 7, 1]]


def polygons() -> Mesh:
    return Mesh.from_polygons(VERTICES / 7, FACES)


def read_text(tmp_path: Path, text: str, name: str = "m.obj", **options: str) -> Mesh:
    path = tmp_path / name
    path.write_text(text)
    return read_mesh(path, **options)


TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def test_obj_round_trip_is_the_identity(tmp_path):
    mesh = polygons()
    write_mesh(tmp_path / "m.obj", mesh)
    again = read_mesh(tmp_path / "m.obj")
    np.testing.assert_array_equal(again.vertices, mesh.vertices)
    assert again.polygons == FACES


@pytest.mark.parametrize(("unit", "scale"), [("mm", 0.1), ("dm", 10), ("m", 100), ("inch", 2.54)])
def test_read_meshes_are_in_centimetres(tmp_path, unit, scale):
    mesh = read_text(tmp_path, TRIANGLE + "f 1 2 3\n", unit=unit)
    np.testing.assert_array_equal(mesh.vertices, np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) * scale)
    write_mesh(tmp_path / "n.obj", mesh, unit=unit)
    # A multiplication and a division give an error of at most one rounding.
    np.testing.assert_allclose(read_mesh(tmp_path / "n.obj", unit=unit).vertices, mesh.vertices, rtol=3e-16)


def test_obj_corners_may_have_every_form_of_the_format_and_precede_their_vertices(tmp_path):
    text = (
        "# a comment\nmtllib a.mtl\no thing\ng part\nusemtl wool\ns off\n\nf 1/1 2/1/1 3//1\n"
        "v 0 0 0 1.0 0.5\nv 1 0 0\nvt 0 0\nvn 0 0 1\nv 1 1 0\nv 0 1 0  # corner\nf -4 \\\n  -2 4\nl 1 2\n"
    )
    assert read_text(tmp_path, text).polygons == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        (TRIANGLE, "got 3 vertices and no faces"),
        (TRIANGLE + "f 1 2\n", "line 4: got a face of 2 corners; expected at least 3"),
        (TRIANGLE + "f 1 2 4\n", "line 4: vertex 4 does not exist; the file has 3 vertices"),
        (TRIANGLE + "f 0 1 2\n", "line 4: vertex 0 does not exist; OBJ counts from 1"),
        (TRIANGLE + "f 1 2 x\n", "line 4: got corner 'x'"),
        (TRIANGLE + "f 1 2 3/a\n", "line 4: got corner '3/a'"),
        ("v 0 0 0\nv 1 0\n", "line 2: got 'v 1 0'"),
        ("v 0 0 0\nv 1 nan 0\n", "line 2: got 'v 1 nan 0'; coordinates must be finite"),
        ("hello world\n", "line 1: unknown element 'hello'"),
        ("v 0 0 0\n\nv 0 0 \\\n", "line 3: got 'v 0 0'"),
    ],
)
def test_each_malformed_obj_gets_its_message(tmp_path, text, message):
    with refused(tmp_path / "m.obj", message):
        read_text(tmp_path, text)


def test_the_error_of_a_bad_surface_names_the_file(tmp_path):
    with pytest.raises(MeshError, match=r"^.*m\.obj: vertex 3: no face uses it"):
        read_text(tmp_path, TRIANGLE + "v 5 5 5\nf 1 2 3\n")


def test_missing_files_folders_and_unknown_suffixes_are_errors(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        read_mesh(tmp_path / "none.obj")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(FileError, match="is a folder"):
        read_mesh(tmp_path / "folder.obj")
    with pytest.raises(FileError, match=r"unknown format '.xyz'; expected one of .obj"):
        read_mesh(tmp_path / "m.xyz")
    with pytest.raises(FileError, match="has no suffix"):
        read_mesh(tmp_path / "m")
    with pytest.raises(ParameterError, match="got 'furlong'; expected one of mm, cm, dm, m, inch"):
        read_mesh(tmp_path / "m.obj", unit="furlong")
    with pytest.raises(FileError, match=r"unknown format '.xyz'; expected one of .obj .off .ply .vtp .* .stl .glb"):
        write_mesh(tmp_path / "m.xyz", polygons())
    with pytest.raises(FileError, match="has no suffix"):
        write_mesh(tmp_path / "m", polygons())


def test_an_unreadable_file_is_an_error(tmp_path, monkeypatch):
    def refuse(path, flags):
        raise PermissionError(13, "Permission denied", os.fspath(path))

    monkeypatch.setattr("stitchmesh.io.contents.os.open", refuse)  # The tests may run as a user who can read all files.
    with pytest.raises(FileError, match="no permission to read it"):
        read_mesh(tmp_path / "m.obj")


def write_by_meshio(path: Path, faces: list[list[int]], file_format: str, **options: object) -> None:
    blocks: list[tuple[str, list[list[int]]]] = []
    for face in faces:
        kind = {3: "triangle", 4: "quad"}.get(len(face), "polygon")
        if not blocks or blocks[-1][0] != kind:
            blocks.append((kind, []))
        blocks[-1][1].append(face)
    meshio.Mesh(VERTICES / 7, blocks).write(path, file_format=file_format, **options)


@pytest.mark.parametrize(
    ("name", "file_format", "binary"),
    [("m.ply", "ply", True), ("m.vtk", "vtk", True), ("m.vtu", "vtu", True)],
)
def test_meshio_keeps_the_order_of_polygons(tmp_path, name, file_format, binary):
    write_by_meshio(tmp_path / name, FACES, file_format, binary=binary)
    mesh = read_mesh(tmp_path / name)
    np.testing.assert_array_equal(mesh.vertices, VERTICES / 7)
    assert mesh.polygons == FACES


@pytest.mark.parametrize(("name", "file_format"), [("m.msh", "gmsh22"), ("m.mesh", "medit")])
def test_meshio_keeps_triangles_and_quads(tmp_path, name, file_format):
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4, 5], [0, 5, 6, 7]]
    write_by_meshio(tmp_path / name, faces, file_format)
    assert read_mesh(tmp_path / name).polygons == faces


def test_equal_points_of_a_binary_stl_become_one_vertex(tmp_path):
    write_by_meshio(tmp_path / "m.stl", [[0, 1, 2], [0, 2, 3]], "stl", binary=True)
    mesh = read_mesh(tmp_path / "m.stl")
    assert len(mesh.vertices) == 4
    assert len(mesh.boundary_loops) == 1
    # The format holds float32.
    np.testing.assert_allclose(mesh.corner_position[:3], VERTICES[[0, 1, 2]] / 7, rtol=1e-7)


PLY = """ply
format ascii 1.0
comment made by hand
element vertex 4
property float x
property float y
property float z
property uchar red
element face 2
property uchar flag
property list uchar int vertex_index
end_header
0 0 0 9
1 0 0 9
1 1 0 9
0 1 0 9
7 3 0 1 2
7 3 0 2 3
"""


def test_other_ply_properties_are_ignored(tmp_path):
    assert read_text(tmp_path, PLY, "m.ply").polygons == [[0, 1, 2], [0, 2, 3]]


def test_big_endian_ply_is_read(tmp_path):
    head = PLY[: PLY.index("end_header")].replace("ascii", "binary_big_endian").encode() + b"end_header\n"
    vertices = b"".join(struct.pack(">3fB", x, y, 0, 9) for x, y in [(0, 0), (1, 0), (1, 1), (0, 1)])
    faces = struct.pack(">BB3i", 7, 3, 0, 1, 2) + struct.pack(">BB3i", 7, 3, 0, 2, 3)
    (tmp_path / "m.ply").write_bytes(head + vertices + faces)
    mesh = read_mesh(tmp_path / "m.ply")
    assert mesh.polygons == [[0, 1, 2], [0, 2, 3]]
    np.testing.assert_array_equal(mesh.vertices[2], [1, 1, 0])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("ply\n", "plx\n", "has no complete PLY header"),
        ("format ascii 1.0\n", "", "the header has no format line"),
        ("format ascii", "format morse", "line 2: got 'format morse 1.0'"),
        ("element vertex 4", "element vertex four", "line 4: got 'element vertex four'"),
        ("float z", "float w", "vertices have the properties x y w red; expected x, y and z"),
        ("vertex_index", "corners", "faces have no list vertex_indices or vertex_index"),
        ("element face 2", "element face 2000000000", "ends within face 0 of 2000000000"),
        ("7 3 0 2 3", "7 3 0 2", "ends within face 1 of 2"),
        ("7 3 0 2 3", "7 2 0 2", "face 1 has 2 corners; expected at least 3"),
        ("7 3 0 2 3", "7 3 0 2 4", "face 1 has the vertices [0, 2, 4]; expected numbers from 0 to 3"),
        ("1 1 0 9", "1 nan 0 9", "vertex 2 is [1.0, nan, 0.0]; coordinates must be finite"),
        ("1 1 0 9", "1 one 0 9", "vertex 2: could not convert"),
    ],
)
def test_each_malformed_ply_gets_its_message(tmp_path, old, new, message):
    with refused(tmp_path / "m.ply", message):
        read_text(tmp_path, PLY.replace(old, new, 1), "m.ply")


@pytest.mark.parametrize("suffix", sorted(set(FORMATS) - {".usdc", ".usd", ".vtk"}))
def test_random_bytes_in_every_format_give_one_line_and_no_output(tmp_path, capfd, suffix):
    path = tmp_path / f"m{suffix}"
    path.write_bytes(b"\x00\xff" * 50)
    with refused(path):
        read_mesh(path)
    assert capfd.readouterr() == ("", "")


def test_cells_that_are_not_polygons_are_errors(tmp_path):
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    meshio.Mesh(points, [("tetra", [[0, 1, 2, 3]])]).write(tmp_path / "m.vtu")
    with pytest.raises(FileError, match="got tetra cells"):
        read_mesh(tmp_path / "m.vtu")
    meshio.Mesh(points, [("line", [[0, 1]])]).write(tmp_path / "n.vtu")
    with pytest.raises(FileError, match="has no faces"):
        read_mesh(tmp_path / "n.vtu")


def test_the_error_names_points_that_are_not_finite(tmp_path):
    points = VERTICES[:3].copy()
    points[1, 2] = np.nan
    meshio.Mesh(points, [("triangle", [[0, 1, 2]])]).write(tmp_path / "m.vtu")
    with pytest.raises(FileError, match="point 1 is"):
        read_mesh(tmp_path / "m.vtu")


OFF = "OFF # four kinds of things\n\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 .5 0\n4 0 1 2 3\n3 1 4 2 255 0 0\n"


def test_off_keeps_polygons_and_ignores_colours(tmp_path):
    assert read_text(tmp_path, OFF, "m.off").polygons == [[0, 1, 2, 3], [1, 4, 2]]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("OFF", "ON", "line 1: expected the word OFF"),
        ("5 2 0", "5 0 0", "line 3: got 5 vertices and 0 faces"),
        ("5 2 0", "5 3 0", "got 7 lines for 5 vertices and 3 faces; the file was cut short"),
        ("1 1 0", "1 nan 0", "line 6: got '1 nan 0'; expected three finite coordinates"),
        ("1 1 0", "1 1", "line 6: got '1 1'"),
        ("3 1 4 2", "3 1 5 2", "line 10: vertex 5 does not exist; expected 0 to 4"),
        ("4 0 1 2 3", "5 0 1 2 3", "line 9: got '5 0 1 2 3'"),
    ],
)
def test_each_malformed_off_gets_its_message(tmp_path, old, new, message):
    with refused(tmp_path / "m.off", message):
        read_text(tmp_path, OFF.replace(old, new, 1), "m.off")


@pytest.mark.skipif(not DATA.exists(), reason="the shared data folder is not there")
@pytest.mark.parametrize(
    ("name", "faces", "borders"), [("helper-skirt", 684, 2), ("helper-tights", 2650, 3), ("body", 13378, 0)]
)
def test_published_garments_are_read(name, faces, borders):
    mesh = read_mesh(DATA / f"makehuman-{name}.obj", unit="dm")
    assert mesh.face_count == faces
    assert len(mesh.boundary_loops) == borders
    assert (np.diff(mesh.face_start) == 4).all()


TEXT_STL = """solid two
facet normal 0 0 1
  outer loop
    vertex 0 0 0
    vertex 1 0 0
    vertex 1 1 0
  endloop
endfacet
facet normal 0 0 1
  OUTER LOOP
    VERTEX 0 0 0
    vertex 1e0 1 0
    vertex 0 1 0.5
  endloop
endfacet
endsolid two
"""


def test_a_text_of_stl_is_read_and_its_equal_corners_become_one_vertex(tmp_path):
    (tmp_path / "m.stl").write_text(TEXT_STL)
    mesh = read_mesh(tmp_path / "m.stl")
    np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])
    np.testing.assert_array_equal(mesh.face_vertex, [0, 1, 2, 0, 2, 3])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("vertex 1 0 0", "vertex 1 0", "line 5: got 'vertex 1 0'; expected 'vertex' and three numbers"),
        ("vertex 1 0 0", "vertex 1 0 nan", "point 1 is [1.0, 0.0, nan]; coordinates must be finite"),
        ("vertex 1 0 0", "vertex 1 0 1e300", "point 1 is [1.0, 0.0, 1e+300]; coordinates must be finite, and at most"),
        ("    vertex 1 0 0\n", "", "line 6: a facet does not have three corners; STL holds triangles"),
        ("facet normal", "facets", "line 2: got 'facets 0 0 1'; expected a line of an STL file"),
        ("  endloop\nendfacet\nendsolid two\n", "vertex 0 0 1\n", "ends within a facet; the file was cut short"),
    ],
)
def test_each_damage_of_a_text_of_stl_gets_its_message(tmp_path, old, new, message):
    (tmp_path / "m.stl").write_text(
        new.join(TEXT_STL.rsplit(old, 1)) if "endsolid" in old else TEXT_STL.replace(old, new, 1)
    )
    with refused(tmp_path / "m.stl", message):
        read_mesh(tmp_path / "m.stl")


def test_a_binary_stl_with_a_wrong_count_is_an_error(tmp_path):
    content = bytes(80) + (99_999_999).to_bytes(4, "little") + bytes(50)
    (tmp_path / "m.stl").write_bytes(content)
    with pytest.raises(FileError, match="99999999 triangles need 5000000034 bytes, the file has 134"):
        read_mesh(tmp_path / "m.stl")


def test_a_number_of_elements_that_the_file_cannot_hold_is_an_error(tmp_path):
    (tmp_path / "m.msh").write_text("# a file\n$Nodes\n99999999999\n0 0 0\n")
    with pytest.raises(FileError, match="states 99999999999 elements in"):
        read_mesh(tmp_path / "m.msh")


@pytest.mark.parametrize("point", [9, -1])
def test_a_face_with_a_point_that_is_missing_is_refused_beside_cells_that_are_left_out(point):
    with pytest.raises(MeshError, match=f"grid.vtk: a face names point {point}; expected 0 to 2"):
        used_points("grid.vtk", np.zeros((3, 3)), [[0, 1, point]])

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Readers of meshes read all that they understand, say in one line what they left out, and drop no geometry."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista

from stitchmesh.errors import FileError
from stitchmesh.io import read_mesh
from stitchmesh.mesh import Mesh
from tests.gallery import shared

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0.5, 0], [1, 2, 0.25]])
QUAD, TRIANGLE = [0, 1, 2, 3], [1, 4, 2]
CASES = {
    "03-tube-simulator-keywords.obj": (128, [16, 16, 16]),
    "04-tube-corner-lists.ply": (128, [16, 16, 16]),
    "05-tube-polydata.vtk": (128, [16, 16, 16]),
    "05-tube-strips.vtp": (64, [10, 8, 10]),
    "06-tube-glued-head.off": (128, [16, 16, 16]),
    "06-tube-no-head.off": (128, [16, 16, 16]),
    "06-tube-texture-head.off": (128, [16, 16, 16]),
    "14-tube-skinned.glb": (64, [20, 16, 20]),
    "14-tube-morph.glb": (64, [10, 16, 10]),
}
"""Faces and extents [cm] of tubes in files that were refused, or read in part."""


def read_text(folder: Path, name: str, text: str) -> Mesh:
    (folder / name).write_text(text)
    return read_mesh(folder / name)


@pytest.mark.parametrize("name", CASES)
def test_tubes_in_files_of_public_reports_are_whole(name):
    faces, extent = CASES[name]
    mesh = read_mesh(shared(f"cases/field/{name}"))
    assert mesh.face_count == faces
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), extent, rtol=1e-6)  # Rounding of float32.


def test_obj_lines_of_unknown_words_are_left_out_in_one_line(tmp_path, caplog):
    text = "v 0 0 0\nny 1 2 3\nv 1 0 0\nny 1 2 3\nv 0 1 0\ng all\nf 1 2 3\nl 1 2\n"
    assert read_text(tmp_path, "m.obj", text).polygons == [[0, 1, 2]]
    said = "left out lines, which the surface does not need: ny (2), l (1)"
    assert caplog.messages == [f"{tmp_path / 'm.obj'}: {said}"]


PLY = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
"""


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n", []),
        ("0 0 0 7 7\n1 0 0 7 7\n1 1 0\n0 1 0 7\n4 0 1 2 3 9 9\n",
         ["numbers behind those that the header names, in rows"]),
        ("0 0\n0 1\n0 0 1 1 0 0 1\n0\n4 0 1\n2 3\n", []),
    ],
)  # fmt: skip
def test_rows_of_a_ply_in_text_may_be_longer_than_the_header_says_or_go_on(tmp_path, caplog, rows, said):
    assert read_text(tmp_path, "m.ply", PLY + rows).polygons == [QUAD]
    needless = "which the surface does not need: vertex (3), face (1)"
    assert caplog.messages == [f"{tmp_path / 'm.ply'}: left out {one}, {needless}" for one in said]


def test_strips_of_a_ply_are_triangles_and_other_elements_are_left_out(tmp_path, caplog):
    edge = "element edge 1\nproperty int a\nend_header"
    head = PLY.replace("element face 1", "element tristrips 1").replace("end_header", edge)
    for strips in ("4 0 1 3 2", "5 0 1 3 2 -1", "7 0 1 3 -1 1 2 3"):
        mesh = read_text(tmp_path, "m.ply", head + f"0 0 0\n1 0 0\n1 1 0\n0 1 0\n{strips}\n5\n")
        assert mesh.polygons == [[0, 1, 3], [1, 2, 3]]
    assert caplog.messages[-1].endswith("left out elements, which the surface does not need: edge (1)")


OFF_BODY = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"


HEADS = ["OFF 4 1 0\n", "OFF4 1 0\n", "4 1 0\n", "STCNOFF 4 1\n"]


@pytest.mark.parametrize("head", HEADS)
def test_heads_of_off(tmp_path, head):
    assert read_text(tmp_path, "m.off", head + OFF_BODY).polygons == [QUAD]


@pytest.mark.parametrize("head", ["4OFF\n", "nOFF\n3\n", "OFF BINARY\n"])
def test_off_of_other_dimensions_and_binary_off_are_refused_by_name(tmp_path, head):
    with pytest.raises(FileError, match=f"line 1: got '{head.strip().splitlines()[0]}'; expected OFF in text"):
        read_text(tmp_path, "m.off", head + "4 1 0\n" + OFF_BODY)


MEDIT = """MeshVersionFormatted 2 Dimension 3 # in one line
Vertices 4 0 0 0 7 1 0 0 7 1 1 0 7 0 1 0 7 Corners 2 1 3 Edges 1 1 2 5
Quadrilaterals 1 1 2 3 4 9 End"""


def test_medit_is_words_between_any_white_space(tmp_path, caplog):
    words = MEDIT.replace("# in one line", "").split()
    for text in (MEDIT, "\n".join(words), " ".join(words)):
        mesh = read_text(tmp_path, "m.mesh", text)
        assert mesh.polygons == [QUAD] and np.array_equal(mesh.vertices, POINTS[:4])
    assert caplog.messages[0].endswith("left out elements, which the surface does not need: Corners (2), Edges (1)")
    flat = "MeshVersionFormatted 1\nDimension\n2\nVertices\n3\n0 0 1\n1 0 1\n0 1 1\nTriangles\n1\n1 2 3 0\n"
    assert np.array_equal(read_text(tmp_path, "m.mesh", flat).vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("MeshVersion", "Version", "expected the word MeshVersionFormatted first"),
        ("Vertices 4", "Vertices 99999999999", "states 99999999999 elements"),
        ("Dimension 3", "Dimension 9", "it has 9 dimensions"),
        ("1 2 3 4 9", "1 2 3 5 9", r"face 0 names the vertices \[1, 2, 3, 5\]; expected numbers from 1 to 4"),
        ("Quadrilaterals 1", "Quadrilaterals 0", "has no faces"),
        ("1 1 0 7", "1 nan 0 7", "coordinates must be finite"),
    ],
)
def test_each_malformed_medit_file_gets_its_message(tmp_path, old, new, message):
    with pytest.raises(FileError, match=message):
        read_text(tmp_path, "m.mesh", MEDIT.replace(old, new, 1))


def vtk_text(version: str, polygons: str) -> str:
    points = " ".join(f"{x:g}" for x in POINTS[:5].ravel())
    head = f"# vtk DataFile Version {version}\na title\nASCII\nDATASET POLYDATA\n"
    field = "FIELD FieldData 1\ntime 1 2 double\n0.5\n1\nMETADATA\nINFORMATION 0\n\n"
    return f"{head}{field}POINTS 5 float\n{points}\n\n{polygons}\nPOINT_DATA 5\nSCALARS s float\n"


OLD, NEW = "LINES 1 3\n2 0 1\nPOLYGONS 2 9\n4 0 1 2 3\n3 1 4 2\n", (
    "POLYGONS 3 7\nOFFSETS vtktypeint64\n0 4 7\nCONNECTIVITY vtktypeint64\n0 1 2 3 1 4 2\n"
)


@pytest.mark.parametrize(("version", "cells"), [("3.0", OLD), ("5.1", NEW)])
def test_poly_data_in_vtks_legacy_text(tmp_path, caplog, version, cells):
    assert read_text(tmp_path, "m.vtk", vtk_text(version, cells)).polygons == [QUAD, TRIANGLE]
    assert [message.split(": ", 2)[2] for message in caplog.messages] == (["lines (1)"] if cells is OLD else [])


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("suffix", [".vtk", ".vtp"])
def test_polygons_and_strips_of_another_program(tmp_path, binary, suffix):
    written = pyvista.PolyData(POINTS, faces=[4, *QUAD], strips=[4, 1, 4, 2, 5])
    written.save(tmp_path / f"m{suffix}", binary=binary)
    mesh = read_mesh(tmp_path / f"m{suffix}")
    assert mesh.polygons == [QUAD, [1, 4, 2], [4, 5, 2]]
    np.testing.assert_array_equal(mesh.vertices, POINTS)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("POINTS 5", "POINTS 99999999999", "it states 299999999997 numbers, and"),
        ("POINTS 5", "POINTS 4", "got the word 2"),
        ("POLYGONS 2 9", "POLYGONS 9 9", "cut short or altered"),
        ("3 1 4 2", "3 1 5 2", r"a face names the points \[1, 5, 2\]; expected three or more from 0 to 4"),
        ("POLYGONS", "POLYTOPES", "got the word POLYTOPES"),
        ("DATASET POLYDATA", "DATASET POLYWATER", "is not a valid vtk file"),
    ],
)
def test_each_malformed_legacy_vtk_file_gets_its_message(tmp_path, old, new, message):
    with pytest.raises(FileError, match=message):
        read_text(tmp_path, "m.vtk", vtk_text("3.0", OLD).replace(old, new, 1))


def test_cells_of_second_order_become_polygons_through_the_middles_of_their_sides(tmp_path):
    middles = [(POINTS[a] + POINTS[b]) / 2 for a, b in ((0, 1), (1, 2), (2, 0))]
    meshio.Mesh([*POINTS[:3], *middles], [("triangle6", [[0, 1, 2, 3, 4, 5]])]).write(tmp_path / "m.vtu")
    assert read_mesh(tmp_path / "m.vtu").polygons == [[0, 3, 1, 4, 2, 5]]


def test_solids_beside_a_surface_are_left_out_with_their_points(tmp_path, caplog):
    cells = [("tetra", [[0, 1, 3, 5]]), ("triangle", [TRIANGLE])]
    for suffix, form in ((".vtu", "vtu"), (".msh", "gmsh22")):
        path = tmp_path / f"m{suffix}"
        meshio.write(path, meshio.Mesh(POINTS, cells), file_format=form)
        mesh = read_mesh(path)
        assert mesh.polygons == [[0, 2, 1]] and np.array_equal(mesh.vertices, POINTS[[1, 2, 4]])
        assert caplog.messages[-1] == f"{path}: left out cells, which the surface does not need: tetra (1)"

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Writing of polygon meshes in every format: the mesh is read again, or a message says what the format cannot hold."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.cli.main import main
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io import read_mesh, read_stitches, read_yarns, write_mesh, write_stitches
from stitchmesh.io.any_file import read_any
from stitchmesh.io.meshes import FORMATS
from stitchmesh.labeling import label
from stitchmesh.mesh import Mesh
from tests.gallery import ROOT, tube

MESHES = ROOT / "assets" / "meshes"
ALL = sorted(set(FORMATS) - {".usd", ".usdc"})  # USD is read in a process of its own, which takes half a second.
POLYGONS = [suffix for suffix in ALL if FORMATS[suffix].most_corners is None]
FLOAT32 = {".stl", ".glb", ".gltf"}
ROUNDING = 6e-8
"""Largest relative rounding error of float32."""
L_SHAPE = np.array([[3, 0, 0], [3, 1, 0], [1, 1, 0], [1, 3, 0], [0, 3, 0], [0, 0, 0]], dtype=float)
"""A hexagon with one reflex corner: triangles around a corner overlap, except around this and the opposite one."""


def area(mesh: Mesh) -> float:
    return float(np.linalg.norm(mesh.face_vector_area, axis=1).sum())


def mixed() -> Mesh:
    """Return triangles, a quad and a pentagon around one vertex, in an order in which the number of corners changes."""
    angle = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False) + 0.1
    rim = np.stack([np.cos(angle), np.sin(angle), 0.3 * np.cos(3 * angle)], axis=1) / 7
    vertices = np.concatenate([np.zeros((1, 3)), rim])
    return Mesh.from_polygons(vertices, [[0, 1, 2], [0, 2, 3, 4, 5], [0, 5, 6], [0, 6, 7, 8], [0, 8, 1]])


@pytest.mark.parametrize("suffix", sorted(FLOAT32))
def test_a_garment_in_a_format_of_triangles_is_read_with_the_same_vertices_and_borders(tmp_path, suffix):
    mesh = read_mesh(MESHES / "hat.obj")
    path = tmp_path / f"mesh{suffix}"
    write_mesh(path, mesh)
    again = read_mesh(path)
    assert [p.name for p in tmp_path.iterdir()] == [path.name], "nothing else is left"
    # The vertices are in the order in which the faces use them.
    assert len(again.vertices) == len(mesh.vertices)
    assert len(again.boundary_loops) == len(mesh.boundary_loops)
    assert np.diff(again.face_start).max() == 3
    # The two triangles of a quad that is not flat have another area than the vector area of the quad.
    assert area(again) == pytest.approx(area(mesh), rel=0.02)
    nearest = np.linalg.norm(again.vertices[:, None] - mesh.vertices, axis=2).min(axis=0)
    # Three coordinates, and the conversion from metres.
    assert nearest.max() <= 4 * ROUNDING * np.abs(mesh.vertices).max()


@pytest.mark.parametrize("suffix", POLYGONS)
def test_polygons_keep_their_number_of_corners(tmp_path, suffix, caplog):
    write_mesh(tmp_path / f"m{suffix}", mixed())
    again = read_mesh(tmp_path / f"m{suffix}")
    np.testing.assert_allclose(again.vertices, mixed().vertices, rtol=ROUNDING if suffix == ".usda" else 0.0, atol=0.0)
    assert again.polygons == mixed().polygons
    assert not caplog.records


@pytest.mark.parametrize(("suffix", "count"), [(".stl", 2), (".glb", 2), (".msh", 1), (".mesh", 1)])
def test_larger_faces_are_divided_with_a_warning(tmp_path, suffix, count, caplog):
    path = tmp_path / f"m{suffix}"
    with caplog.at_level(logging.WARNING, logger="stitchmesh"):
        write_mesh(path, mixed())
    (line,) = [record.getMessage() for record in caplog.records]
    assert line.startswith(f"{path}: the format holds triangles") and f"{count} larger faces are divided" in line
    again = read_mesh(path)
    corners = sorted(np.diff(again.face_start).tolist())
    assert corners == ([3] * 8 if count == 2 else [3] * 6 + [4])
    assert len(again.vertices) == 9 and len(again.boundary_loops) == 1


def test_the_triangles_of_a_concave_face_do_not_overlap(tmp_path):
    """The area of triangles around the first corner would be larger, because such triangles overlap."""
    write_mesh(tmp_path / "m.stl", Mesh.from_polygons(L_SHAPE, [list(range(6))]))
    assert area(read_mesh(tmp_path / "m.stl")) == pytest.approx(5.0, rel=1e-6)  # float32


def test_gltf_is_in_metres(tmp_path):
    import trimesh

    write_mesh(tmp_path / "m.glb", tube(8, 2, radius=2.0, height=1.5))
    stored = trimesh.load_scene(tmp_path / "m.glb", process=False).to_mesh()
    assert np.ptp(stored.vertices, axis=0).max() == pytest.approx(0.04, rel=1e-6)  # float32
    with pytest.raises(ParameterError, match="fixes or states its unit; leave the unit out"):
        read_mesh(tmp_path / "m.glb", unit="mm")
    with pytest.raises(ParameterError, match="fixes or states its unit; leave the unit out"):
        write_mesh(tmp_path / "n.glb", tube(8, 2), unit="m")
    assert not (tmp_path / "n.glb").exists()


def test_repeated_points_of_other_programs_become_one_vertex(tmp_path):
    """In the file each corner of each face has a normal of its own, and therefore a vertex of its own."""
    import trimesh

    box = trimesh.creation.box()
    box.unmerge_vertices()
    box.export(tmp_path / "box.glb")
    mesh = read_mesh(tmp_path / "box.glb")
    assert (len(mesh.vertices), mesh.face_count, len(mesh.boundary_loops)) == (8, 12, 0)


def test_vtp_holds_yarns_or_a_mesh(tmp_path):
    import pyvista

    write_mesh(tmp_path / "mesh.vtp", mixed())
    assert type(read_any(tmp_path / "mesh.vtp")) is Mesh
    assert pyvista.read(tmp_path / "mesh.vtp").n_faces == 5
    with pytest.raises(FileError, match="has no lines; expected polylines"):
        read_yarns(tmp_path / "mesh.vtp")


def test_unknown_points_in_vtp_are_errors(tmp_path):
    import pyvista

    data = pyvista.PolyData(np.eye(3), faces=[3, 0, 1, 7])
    data.save(tmp_path / "m.vtp", binary=False)
    with pytest.raises(FileError, match="a face names point 7; the file has 3 points"):
        read_mesh(tmp_path / "m.vtp")
    pyvista.PolyData(np.eye(3)).save(tmp_path / "n.vtp")
    with pytest.raises(FileError, match=r"has no faces; expected a polygon mesh"):
        read_mesh(tmp_path / "n.vtp")


@pytest.mark.parametrize("suffix", [".stl", ".glb"])
def test_coordinates_beyond_float32_are_errors_and_the_old_file_stays(tmp_path, suffix):
    path = tmp_path / f"m{suffix}"
    path.write_bytes(b"old")
    with pytest.raises(FileError, match="too large for the format's float32"):
        write_mesh(path, Mesh.from_polygons(np.array([[0, 0, 0], [1e41, 0, 0], [0, 1e41, 0]]), [[0, 1, 2]]))
    assert path.read_bytes() == b"old" and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("suffix", [".obj", ".msh", ".usda"])
def test_a_path_that_cannot_be_written_gives_a_message_of_one_line(tmp_path, suffix):
    (tmp_path / f"folder{suffix}").mkdir()
    with pytest.raises(FileError, match="is a folder"):
        write_mesh(tmp_path / f"folder{suffix}", tube(6, 2))
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="choose another folder"):
        write_mesh(tmp_path / "file" / f"m{suffix}", tube(6, 2))


def test_convert_writes_the_faces_of_a_stitch_mesh(tmp_path, capsys):
    write_stitches(tmp_path / "rows.h5", label(tube(8, 2)))
    assert main(["convert", str(tmp_path / "rows.h5"), str(tmp_path / "rows.ply")]) == 0
    assert read_mesh(tmp_path / "rows.ply").polygons == read_stitches(tmp_path / "rows.h5").polygons
    assert main(["convert", str(tmp_path / "rows.h5"), str(tmp_path / "rows.doc")]) == 2
    said = capsys.readouterr().err
    assert "unknown format '.doc'; expected one of .h5 .smobj .k .obj .off .ply" in said and said.count("\n") == 1
    assert not Path(tmp_path / "rows.doc").exists()

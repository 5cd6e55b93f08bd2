# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The readers of meshes, stitches and yarns, each with small undamaged files."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import stitchmesh as sm
from stitchmesh.errors import FileError, MeshError, ParameterError, YarnError
from stitchmesh.io import read_mesh, read_stitches, read_yarns, write_mesh, write_stitches, write_yarns
from stitchmesh.io.any_file import read_any
from stitchmesh.io.stitch_formats.face_libraries import read_face_library
from stitchmesh.io.stitch_formats.face_meshes import read_face_mesh
from stitchmesh.io.yarns import BCC_CURVES
from stitchmesh.mesh import Mesh
from stitchmesh.yarn import YarnSet
from tests.faces.face_files import EVERY_RECORD, LIBRARY
from tests.fuzz import mutations as damage
from tests.fuzz import structures
from tests.fuzz.reader import Reader, Seeds, cube, joined, later, rebuilt, small_fabric, small_yarns, written
from tests.fuzz.structures import GLB, JSON, USD, XML
from tests.io.yarn_sets import ODD_POINTS, store_points_oddly


def _ascii_ply(folder: Path) -> list[bytes]:
    head = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    head += b"property uchar red\nelement face 2\nproperty list uchar int vertex_index\nend_header\n"
    return [head + b"0 0 0 9\n1 0 0 9\n1 1 0.5 9\n0 1 0 9\n3 0 1 2\n3 0 2 3\n"]


def _ascii_stl(folder: Path) -> list[bytes]:
    corners = [([0, 0, 0], [1, 0, 0], [1, 1, 0]), ([0, 0, 0], [1, 1, 0], [0, 1, 0.5])]
    lines = ["solid two"]
    for triangle in corners:
        lines += ["  facet normal 0 0 1", "    outer loop"]
        lines += [f"      vertex {x} {y} {z}" for x, y, z in triangle] + ["    endloop", "  endfacet"]
    return ["\n".join([*lines, "endsolid two", ""]).encode()]


def _vtp_variants(folder: Path) -> list[bytes]:
    """Return a polyline and a polygon in each encoding of the format."""
    import pyvista
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    points, found = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]], np.float32), []
    for data in (pyvista.PolyData(points, lines=[4, 0, 1, 2, 3]), pyvista.PolyData(points, faces=[4, 0, 1, 2, 3])):
        data.point_data["radius"] = np.full(4, 0.1)
        for mode, compressor in (("Ascii", "None"), ("Binary", "None"), ("Binary", "ZLib"), ("Appended", "None")):
            writer = vtkXMLPolyDataWriter()
            writer.SetInputData(data)
            writer.SetFileName(str(folder / "seed.vtp"))
            getattr(writer, f"SetDataModeTo{mode}")()
            getattr(writer, f"SetCompressorTypeTo{compressor}")()
            writer.SetEncodeAppendedData(0)
            writer.Write()
            found.append((folder / "seed.vtp").read_bytes())
    return found


def _odd_hdf5(folder: Path) -> list[bytes]:
    """Return files of yarns with chunked, virtual, external, linked and very large datasets."""
    path, found = folder / "seed.h5", []
    for kind in ODD_POINTS:
        write_yarns(path, small_yarns())
        store_points_oddly(path, kind, "/etc/passwd")
        found.append(path.read_bytes())
    return found


def _labeling(folder: Path) -> list[bytes]:
    return written(sm.write_labeling, lambda: sm.start_labeling(cube()), suffix=".h5")(folder)


def _checkpoint(folder: Path) -> list[bytes]:
    """Return the checkpoint of a relaxation, made by hand; the states of solvers have the same form."""
    from stitchmesh.yarnrelax.assessment import Assessment
    from stitchmesh.yarnrelax.checkpoint import CheckpointState, write_state
    from stitchmesh.yarnrelax.loop_state import LoopState

    class Held:
        def numpy(self) -> np.ndarray:
            return np.arange(18.0, dtype=np.float32).reshape(6, 3)

    last = Assessment(0.5, {"stretch": 1.0})
    entry = {"iteration": 1, "seconds": 0.1, "residual": 0.5, "energies": {"stretch": 1.0}}
    state = CheckpointState(LoopState(5, last, 0.1, 3, 1.0, np.inf, {"good_points": Held()}), 0.5, [entry])  # type: ignore[list-item]
    return written(lambda path, value: write_state(path, {"yarns": "1"}, value), state, suffix=".smc")(folder)


def _frame(folder: Path) -> list[bytes]:
    """Return the file of a frame of mixed yarns and triangles."""
    from stitchmesh.mixed.output.frames import DrapeFrame, Frames

    points = np.arange(12.0).reshape(4, 3)
    Frames(folder).add(DrapeFrame(0.5, points, points, points[:, :2], np.zeros(2, dtype=np.int64), np.ones(4)))
    return [next(folder.rglob("0000.smc")).read_bytes()]


def _read_checkpoint_yarns(path: Path) -> object:
    from stitchmesh.yarnrelax.checkpoint_yarns import checkpoint_yarns

    return checkpoint_yarns(path, YarnSet.from_curves([np.arange(18.0).reshape(6, 3)], closed=[True], radius=0.1))


def _usd(suffix: str) -> Reader:
    def seeds(folder: Path) -> list[bytes]:
        """Return yarns in this suffix, and for text also a layer that names files outside its folder."""
        linked = small_yarns(), dataclasses.replace(small_yarns(), colour=[1, 0])
        found = written(write_yarns, *linked, suffix=suffix)(folder)
        if suffix == ".usda":
            head = b"#usda 1.0\n(\n    subLayers = [@../../../../etc/passwd@, @/dev/zero@]\n)\n"
            prim = b'def Xform "yarns"'
            found.append(head + found[0].partition(b")\n")[2])
            found.append(found[0].replace(prim, prim + b" (references = @/etc/passwd@)"))
        return found

    kinds = USD if suffix == ".usda" else damage.BINARY
    return Reader(suffix, _read_usd, seeds, kinds, (FileError, YarnError, ParameterError), has_own_process=True)


def _read_usd(path: Path) -> object:
    """Do in this process what ``read_yarns`` does in a child, whose start takes longer than the reading."""
    from stitchmesh.io.yarn_formats.usd_curves import curves_of_stage
    from stitchmesh.io.yarns import yarns_of_usd

    return yarns_of_usd(curves_of_stage(path))


def _usd_mesh_seeds(folder: Path) -> list[bytes]:
    """Return a cube that moves, as text and with a transform that moves too."""
    from stitchmesh.io.mesh_sequences import write_moving_mesh
    from stitchmesh.mesh.vertex_motion import MovingMesh, VertexMotion

    body = cube()
    moving = MovingMesh(body, VertexMotion(np.array([0.0, 0.5]), np.array([body.vertices, body.vertices + 0.1])))
    found = written(write_moving_mesh, moving, suffix=".usda")(folder)
    head, _, rest = found[0].partition(b"    int[] faceVertexCounts")
    turned = b'    double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 9: (1, 2, 3) }\n'
    turned += b'    uniform token[] xformOpOrder = ["xformOp:translate"]\n'
    return [*found, head + turned + b"    int[] faceVertexCounts" + rest]


def _read_usd_mesh(path: Path) -> object:
    """Do in this process what ``read_moving_mesh`` does in a child, whose start takes longer than the reading."""
    from stitchmesh.io.mesh_formats.usd_mesh import packed_mesh, samples_of
    from stitchmesh.io.mesh_sequences import moving_mesh_of_samples

    return moving_mesh_of_samples(path, *samples_of(packed_mesh(str(path))))


def _sewing_patterns(folder: Path) -> list[bytes]:
    """Return two squares with a common edge: with the texture coordinates of their panels, and in two groups."""
    squares = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n"
    panels = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 3 0\nvt 4 0\nvt 4 1\nvt 3 1\n"
    textured = f"{squares}{panels}f 1/1 2/2 3/3 4/4\nf 2/5 5/6 6/7 3/8\n"
    return [textured.encode(), f"{squares}g front\nf 1 2 3 4\ng back\nf 2 5 6 3\n".encode()]


def _meshes(suffix: str, kinds: Sequence[damage.Mutation], *seeds: Seeds) -> Reader:
    own = written(write_mesh, cube, suffix=suffix)
    return Reader(suffix, read_mesh, joined(own, *seeds), kinds, (FileError, MeshError))


def hdf5(read: Callable[[Path], object], own: Seeds, *others: Seeds) -> Reader:
    """Return a reader of HDF5 files; a first file, as it is written, and files with other structures are damaged."""
    return Reader(".h5", read, joined(rebuilt(own, structures.hdf5_structure, 60), *others), structures.HDF5)


def _by_meshio(suffix: str) -> Reader:
    own = written(write_mesh, cube, suffix=suffix)
    return Reader(suffix, _read_meshio, own, damage.MIXED, (FileError, MeshError), has_own_process=True)


def _read_meshio(path: Path) -> object:
    """Do in this process what ``read_mesh`` does in a child, whose start takes longer than the reading."""
    from stitchmesh.io.mesh_formats.by_meshio import packed_polygons, polygons_of

    return Mesh.from_polygons(*polygons_of(packed_polygons(str(path), path)))


def _nested_glb(folder: Path) -> list[bytes]:
    """Return a scene of two meshes in nodes within each other, as another program writes it."""
    import trimesh

    scene = trimesh.Scene()
    box, turn = trimesh.creation.box((1, 2, 3)), trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    scene.add_geometry(box, node_name="a", transform=turn)
    scene.add_geometry(trimesh.creation.icosphere(1), node_name="b", parent_node_name="a", transform=turn)
    return [bytes(scene.export(file_type="glb"))]


def _posed_glb(folder: Path) -> list[bytes]:
    """Return a scene whose points are moved by a morph target and carried by two joints."""
    from tests.io.test_glb import skinned, write

    tree, buffer = skinned()
    tree["meshes"][0] |= {"weights": [0.5]}
    tree["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}]
    return [write(folder / "posed.glb", tree, buffer).read_bytes()]


def _moving_glb(folder: Path) -> list[bytes]:
    """Return a square that morph targets lift, and points that turning joints carry."""
    from tests.io.test_glb import skinned, write
    from tests.io.test_moving_files import animated, square

    lifted = animated(*square(), (0, "weights", [0.0, 0.25], [0.0, 1.0]))
    turned = animated(*skinned(), (1, "rotation", [0.0, 0.25], [[0, 0, 0, 1], [0, 0, 1, 0]]))
    return [write(folder / "moving.glb", *content).read_bytes() for content in (lifted, turned)]


def _usd_skin(folder: Path) -> list[bytes]:
    """Return a square that a joint and a blend shape move."""
    from tests.io.test_moving_files import SKELETON

    return [SKELETON.encode()]


def _poly_data(folder: Path) -> list[bytes]:
    """Return polygons and a strip in VTK's legacy format, in text and binary, of the old and the new version."""
    from tests.io.test_read_all_that_is_understood import NEW, OLD, vtk_text

    head = b"# vtk DataFile Version 3.0\ncube\nBINARY\nDATASET POLYDATA\nPOINTS 4 float\n"
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]], ">f4").tobytes()
    strip = b"\nTRIANGLE_STRIPS 1 5\n" + np.array([4, 0, 1, 3, 2], ">i4").tobytes() + b"\n"
    return [vtk_text("3.0", OLD).encode(), vtk_text("5.1", NEW).encode(), head + points + strip]


def _read_poly_data(path: Path) -> object:
    """Leave out files that are no poly data any more: meshio reads them in a child, whose start takes long."""
    from stitchmesh.io.mesh_formats.vtk_legacy import HEAD

    if not HEAD.match(path.read_bytes()):
        raise FileError(f"{path}: is no poly data")
    return read_mesh(path)


CHECKPOINT = (*damage.BINARY, *[damage.inside_checkpoint] * 20)
READ_VIEWED = later("stitchmesh.app.pages.view.opened.read_viewed")
YARN_ERRORS = (FileError, ParameterError)
"""Errors of yarns: a radius that cannot be estimated is a ``ParameterError``."""

GEOMETRY_READERS: dict[str, Reader] = {
    "obj mesh": _meshes(".obj", damage.TEXT),
    "repaired mesh": Reader(".obj", sm.read_repaired_mesh, written(write_mesh, cube, suffix=".obj"), damage.TEXT,
                            (FileError, MeshError)),
    "off": _meshes(".off", damage.TEXT),
    "ply": _meshes(".ply", damage.MIXED, _ascii_ply),
    "stl": _meshes(".stl", damage.MIXED, _ascii_stl),
    "vtp": Reader(".vtp", read_any, joined(written(write_yarns, small_yarns, suffix=".vtp"), _vtp_variants),
                  XML, (FileError, MeshError, ParameterError)),
    "vtk": _by_meshio(".vtk"),
    "vtu": _meshes(".vtu", XML),
    "msh": _by_meshio(".msh"),
    "vtk poly data": Reader(".vtk", _read_poly_data, _poly_data, damage.MIXED, (FileError, MeshError)),
    "medit": _meshes(".mesh", damage.TEXT),
    "glb": _meshes(".glb", GLB, _nested_glb, _posed_glb),
    "gltf": _meshes(".gltf", JSON),
    "bcc": Reader(".bcc", read_yarns, joined(*(written(write_yarns, small_yarns, suffix=".bcc", curve=curve)
                                                for curve in BCC_CURVES)), damage.BINARY, YARN_ERRORS),
    "obj yarns": Reader(".obj", read_yarns, written(write_yarns, small_yarns, suffix=".obj"), errors=YARN_ERRORS),
    "pyp": Reader(".pyp", read_yarns, written(write_yarns, small_yarns(True), suffix=".pyp"), errors=YARN_ERRORS),
    "usda": _usd(".usda"),
    "usdc": _usd(".usdc"),
    "moving glb": Reader(".glb", later("stitchmesh.read_moving_mesh"), _moving_glb, GLB, (FileError, MeshError)),
    "usd mesh": Reader(".usda", _read_usd_mesh, joined(_usd_mesh_seeds, _usd_skin), USD, (FileError, MeshError),
                       has_own_process=True),
    "hdf5 yarns": hdf5(read_yarns, written(write_yarns, small_yarns, small_yarns(True), suffix=".h5"), _odd_hdf5),
    "hdf5 stitches": hdf5(read_stitches, written(write_stitches, small_fabric, suffix=".h5")),
    "hdf5 labels": hdf5(later("stitchmesh.read_labeling"), _labeling),
    "smobj": Reader(".smobj", read_stitches, written(write_stitches, small_fabric, suffix=".smobj")),
    "checkpoint": Reader(".smc", lambda path: later("stitchmesh.yarnrelax.checkpoint.read_state")(path, {"yarns": "1"}),
                         _checkpoint, CHECKPOINT, (FileError, ParameterError)),
    "checkpoint yarns": Reader(".smc", _read_checkpoint_yarns, _checkpoint, CHECKPOINT),
    "frame": Reader(".smc", later("stitchmesh.mixed.output.frames.read_frame"), _frame, CHECKPOINT),
    "yarn chunks": Reader(".yarns", read_yarns, written(write_yarns, small_yarns, suffix=".yarns"), damage.BINARY,
                          YARN_ERRORS),
    "traced stitches": Reader(".st", read_stitches, lambda folder: [
        b"0 s a -1 -1 2 -1 1 0 0\n0 s a -1 -1 3 -1 0 0 0\n0 e c 0 -1 -1 -1 0 0.7 0\n0 e c 1 -1 -1 -1 1 0.7 0\n"]),
    "face mesh": Reader(".smobj", read_face_mesh, lambda folder: [EVERY_RECORD.encode()]),
    "face library": Reader(".sf", read_face_library, lambda folder: [LIBRARY.encode()]),
    "textured obj": Reader(".obj", later("stitchmesh.mixed.cloth.from_obj.read_textured_obj"), lambda folder: [
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"]),
    "sewing pattern": Reader(".obj", later("stitchmesh.shaping.panels.read_panels.read_panels"), _sewing_patterns,
                             errors=(FileError, MeshError)),
    "viewed": hdf5(READ_VIEWED, _labeling, written(write_stitches, small_fabric, suffix=".h5"),
                   written(write_yarns, small_yarns, suffix=".h5")),
    "viewed table": Reader(".csv", READ_VIEWED, lambda folder: [b"iteration,seconds,residual\n1,0.5,0.1\n"]),
}  # fmt: skip
"""Readers by name."""

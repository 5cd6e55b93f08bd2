# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Animations that other programs write: glTF with morph targets, joints and nodes, USD with skeletons, Alembic."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io.mesh_sequences import read_moving_mesh, write_moving_mesh
from stitchmesh.io.meshes import write_mesh
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.vertex_motion import MovingMesh, VertexMotion
from tests.io.test_glb import Head, head, skinned, write

CENTIMETRES = 100.0
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
SINGLE = 1e-6
"""Rounding of single precision, for coordinates of about 1."""


def animated(
    tree: Head, buffer: bytes, *channels: tuple[int, str, list[float], Any], interpolation: str = "LINEAR"
) -> tuple[Head, bytes]:
    """Add an animation; a channel is a node, what changes of it, the times of keys, and the numbers at them."""
    animation: dict[str, Any] = {"channels": [], "samplers": []}
    for node, path, keys, values in channels:
        numbers = []
        for array in (np.array(keys, "<f4"), np.array(values, "<f4")):
            kind = {3: "VEC3", 4: "VEC4"}[array.shape[1]] if array.ndim > 1 else "SCALAR"
            numbers.append(len(tree["accessors"]))
            tree["accessors"].append({"bufferView": len(tree["bufferViews"]), "componentType": 5126,
                                      "count": len(array), "type": kind})  # fmt: skip
            tree["bufferViews"].append({"buffer": 0, "byteOffset": len(buffer), "byteLength": array.nbytes})
            buffer += array.tobytes()
        animation["channels"].append({"sampler": len(animation["samplers"]), "target": {"node": node, "path": path}})
        animation["samplers"].append({"input": numbers[0], "output": numbers[1], "interpolation": interpolation})
    tree["animations"] = [animation]
    return tree, buffer


def square() -> tuple[Head, bytes]:
    """A square of two triangles that repeat the two points between them, with a morph target that lifts it by 2 m."""
    tree = head()
    points, lift = SQUARE[[0, 1, 2, 0, 2, 3]], np.tile(np.array([0, 0, 2], "<f4"), (6, 1))
    tree["meshes"][0]["primitives"] = [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 1}]}]
    tree["accessors"] = [{"bufferView": n, "componentType": 5126, "count": 6, "type": "VEC3"} for n in range(2)]
    tree["bufferViews"] = [{"buffer": 0, "byteOffset": 72 * n, "byteLength": 72} for n in range(2)]
    return tree, points.tobytes() + lift.tobytes()


def test_morph_targets_move_and_points_that_are_repeated_are_one_vertex(tmp_path):
    path = write(tmp_path / "m.glb", *animated(*square(), (0, "weights", [0.5, 1.5], [0.0, 1.0])))
    found = read_moving_mesh(path, frames_per_second=4.0)
    assert found.mesh.polygons == [[0, 1, 2], [0, 2, 3]]
    np.testing.assert_array_equal(found.motion.times, [0.5, 0.75, 1.0, 1.25, 1.5])
    for number, part in enumerate((0.0, 0.25, 0.5, 0.75, 1.0)):  # exact in single precision
        expected = CENTIMETRES * (SQUARE + np.array([0, 0, 2 * part]))
        np.testing.assert_array_equal(found.motion.vertices[number], expected)


@pytest.mark.parametrize(
    ("interpolation", "values", "heights"),
    [
        ("STEP", [0.0, 1.0], [0.0, 0.0, 2.0]),
        # the tangents before and behind each key with its number between them: 3 t^2 - 2 t^3 + t (1 - t)^2 at 1/2
        ("CUBICSPLINE", [0.0, 0.0, 1.0, 0.0, 1.0, 0.0], [0.0, 2 * (0.5 + 0.125), 2.0]),
    ],
)
def test_keys_are_interpolated_as_the_file_says(tmp_path, interpolation, values, heights):
    channel = (0, "weights", [0.0, 1.0], values)
    path = write(tmp_path / "m.glb", *animated(*square(), channel, interpolation=interpolation))
    found = read_moving_mesh(path, frames_per_second=2.0)
    np.testing.assert_allclose(found.motion.vertices[:, 0, 2], CENTIMETRES * np.array(heights), rtol=SINGLE)


def test_joints_carry_the_points_while_they_turn(tmp_path):
    tree, buffer = skinned()
    turned = [[0, 0, 0, 1], [0, 0, np.sqrt(0.5), np.sqrt(0.5)]]  # by a quarter turn about z
    path = write(tmp_path / "m.glb", *animated(tree, buffer, (1, "rotation", [0.0, 1.0], turned)))
    found = read_moving_mesh(path, frames_per_second=3.0)
    for number, angle in enumerate(np.radians([0, 30, 60, 90])):
        point = np.array([1.0 + 3.0, 0.0])  # the second point behind the shift of the joint
        expected = [np.cos(angle) * point[0], np.sin(angle) * point[0], 1.0]
        np.testing.assert_allclose(found.motion.vertices[number, 1] / CENTIMETRES, expected, atol=4 * SINGLE)
    np.testing.assert_array_equal(found.motion.vertices[0, 2:], found.motion.vertices[3, 2:])  # of the other joint


def test_a_node_moves_with_the_nodes_around_it(tmp_path):
    tree, buffer = square()
    tree["nodes"] = [{"children": [1], "scale": [2, 2, 2]}, {"mesh": 0}]
    channels = (0, "translation", [0.0, 1.0], [[0, 0, 0], [1, 0, 0]]), (1, "scale", [0.0, 1.0], [[1, 1, 1], [3, 3, 3]])
    found = read_moving_mesh(write(tmp_path / "m.glb", *animated(tree, buffer, *channels)), frames_per_second=1.0)
    np.testing.assert_allclose(found.motion.vertices[1], CENTIMETRES * (6 * SQUARE + [1, 0, 0]), rtol=SINGLE)


def test_a_text_and_a_binary_file_hold_the_same_animation(tmp_path):
    tree, buffer = animated(*square(), (0, "weights", [0.0, 1.0], [0.0, 1.0]))
    tree["buffers"][0]["uri"] = "m.bin"
    (tmp_path / "m.bin").write_bytes(buffer)
    (tmp_path / "m.gltf").write_text(json.dumps(tree))
    assert read_moving_mesh(tmp_path / "m.gltf").motion.vertices.shape == (31, 4, 3)


def without(tree: Head, *_: object) -> None:
    del tree["animations"]


def twice(tree: Head, *_: object) -> None:
    tree["nodes"] = [{"mesh": 0, "name": "skirt"}, {"mesh": 0}]
    tree["scenes"][0]["nodes"] = [0, 1]


HARMS = {
    "no animation": (without, "has no animation; expected a mesh that moves"),
    "two meshes": (twice, r"has 2 meshes \(skirt, node 1\); expected one mesh that moves; export it alone"),
    "no mesh": (lambda tree: tree["nodes"][0].pop("mesh"), "has no mesh"),
    "keys": (lambda tree: tree["animations"][0]["samplers"][0].update(input=3), "times of the keys .* do not increase"),
    "numbers": (lambda tree: tree["accessors"][3].update(count=1), "the weights of an animation have 1 numbers for 2"),
    "sampler": (lambda tree: tree["animations"][0]["channels"][0].update(sampler=4), "names sampler 4 of 1"),
    "node": (lambda tree: tree["animations"][0]["channels"][0]["target"].update(node=9), "names node 9 of 1"),
    "kind": (lambda tree: tree["animations"][0]["samplers"][0].update(interpolation="HERMITE"), "'HERMITE', expected"),
}  # fmt: skip


@pytest.mark.parametrize("harm", HARMS)
def test_an_animation_that_cannot_be_read_costs_an_error_of_a_line(tmp_path, harm):
    tree, buffer = animated(*square(), (0, "weights", [0.0, 1.0], [1.0, 0.0]))
    change, words = HARMS[harm]
    change(tree)
    with pytest.raises(FileError, match=words) as caught:
        read_moving_mesh(write(tmp_path / "m.glb", tree, buffer))
    assert "\n" not in str(caught.value)


def test_a_file_that_is_cut_short_and_very_many_frames_are_refused(tmp_path):
    path = write(tmp_path / "m.glb", *animated(*square(), (0, "weights", [0.0, 1e9], [0.0, 1.0])))
    with pytest.raises(FileError, match=r"its animation of 1e\+09 s has 3e\+10 frames"):
        read_moving_mesh(path)
    path.write_bytes(path.read_bytes()[:-8])
    with pytest.raises(FileError, match=r"a chunk of .* bytes ends beyond it"):
        read_moving_mesh(path)


@pytest.mark.parametrize("suffix", [".ply", ".stl", ".glb"])
def test_folders_hold_frames_of_any_format(tmp_path, suffix):
    for number in range(3):
        frame = Mesh.from_polygons(SQUARE + np.array([0, 0, number]), [[0, 1, 2], [0, 2, 3]])
        write_mesh(tmp_path / f"walk.{number}{suffix}", frame)
    found = read_moving_mesh(tmp_path)
    np.testing.assert_allclose(found.motion.vertices[2], SQUARE + np.array([0, 0, 2]), rtol=SINGLE)


def test_vertices_at_one_place_are_joined_only_if_they_stay_together(tmp_path):
    """Four squares around a point; the file repeats the points between left and right, which part at one end."""
    left = np.array([[x, y, 0] for y in range(3) for x in range(2)], float)
    first = np.concatenate([left, left + np.array([1, 0, 0])])
    second = first.copy()
    second[10] += 0.25
    squares = [[0, 1, 3, 2], [2, 3, 5, 4]]
    mesh = Mesh.from_polygons(first, [*squares, *([6 + vertex for vertex in face] for face in squares)])
    moving = MovingMesh(mesh, VertexMotion(np.array([0.0, 1.0]), np.array([first, second])))
    write_moving_mesh(tmp_path / "torn.usda", moving)
    found = read_moving_mesh(tmp_path / "torn.usda")
    assert found.mesh.polygons == [[0, 1, 3, 2], [2, 3, 5, 4], [1, 6, 7, 3], [3, 7, 9, 8]]
    np.testing.assert_array_equal(found.motion.vertices[1, [5, 8]], second[[5, 10]])


SKELETON = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Y"
    timeCodesPerSecond = 10
)
def SkelRoot "root"
{
    def Skeleton "bones" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {
        uniform token[] joints = ["a"]
        uniform matrix4d[] bindTransforms = [((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))]
        uniform matrix4d[] restTransforms = [((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))]
        rel skel:animationSource = </root/bones/move>
        def SkelAnimation "move"
        {
            uniform token[] joints = ["a"]
            float3[] translations.timeSamples = { 0: [(0, 0, 0)], 5: [(0, 0, 1)] }
            quatf[] rotations = [(1, 0, 0, 0)]
            half3[] scales = [(1, 1, 1)]
            uniform token[] blendShapes = ["wide"]
            float[] blendShapeWeights.timeSamples = { 0: [0], 5: [0.5] }
        }
    }
    def Mesh "cloth" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        rel skel:skeleton = </root/bones>
        int[] primvars:skel:jointIndices = [0, 0, 0, 0] (
            interpolation = "vertex"
            elementSize = 1
        )
        float[] primvars:skel:jointWeights = [1, 1, 1, 1] (
            interpolation = "vertex"
            elementSize = 1
        )
        uniform token[] skel:blendShapes = ["wide"]
        rel skel:blendShapeTargets = </root/cloth/wide>
        def BlendShape "wide"
        {
            uniform vector3f[] offsets = [(0, 0, 0), (4, 0, 0), (4, 0, 0), (0, 0, 0)]
        }
    }
}
"""


def test_joints_and_blend_shapes_of_usd_move_the_points(tmp_path):
    path = tmp_path / "skin.usda"
    path.write_text(SKELETON)
    found = read_moving_mesh(path)
    np.testing.assert_allclose(found.motion.times, [0.0, 0.5])
    np.testing.assert_allclose(found.motion.vertices[0], CENTIMETRES * SQUARE, atol=CENTIMETRES * SINGLE)
    wide = SQUARE * np.array([3, 1, 1]) + np.array([0, 0, 1])
    np.testing.assert_allclose(found.motion.vertices[1], CENTIMETRES * wide, atol=CENTIMETRES * 3 * SINGLE)
    assert path.read_text() == SKELETON


def write_alembic(path: Path, *, frames: int = 3, names: tuple[str, ...] = ("cloth",), faces: int = 4) -> None:
    """Write squares, clockwise as in Alembic, in a transform that moves along x while the squares move along z."""
    abc, geometry = pytest.importorskip("alembic3d.Abc"), pytest.importorskip("alembic3d.AbcGeom")
    sampling = pytest.importorskip("alembic3d.AbcCoreAbstract").TimeSampling(0.25, 0.0)
    imath = pytest.importorskip("imath")
    archive = abc.OArchive(str(path))
    number = archive.addTimeSampling(sampling)
    outer = geometry.OXform(archive.getTop(), "outer")
    outer.getSchema().setTimeSampling(number)
    meshes = [geometry.OPolyMesh(outer, name) for name in names]
    for mesh in meshes:
        mesh.getSchema().setTimeSampling(number)
    kept = []  # the library keeps no array until the archive is written
    for frame in range(frames):
        corners, counts, points = imath.IntArray(4), imath.IntArray(1), imath.V3fArray(4)
        counts[0] = 4 if frame == 0 else faces
        for corner in range(4):
            corners[corner] = 3 - corner
            points[corner] = imath.V3f(*SQUARE[corner, :2].tolist(), 0.5 * frame)
        kept.append((corners, counts, points))
        for mesh in meshes:
            mesh.getSchema().set(geometry.OPolyMeshSchemaSample(points, corners, counts))
        moved = geometry.XformSample()
        moved.setTranslation(imath.V3d(frame, 0, 0))
        outer.getSchema().set(moved)


def test_alembic_is_read_where_its_transforms_place_it(tmp_path):
    write_alembic(tmp_path / "cloth.abc")
    found = read_moving_mesh(tmp_path / "cloth.abc", unit="dm")
    np.testing.assert_array_equal(found.motion.times, [0.0, 0.25, 0.5])
    for frame in range(3):  # exact in single precision
        np.testing.assert_array_equal(found.motion.vertices[frame], 10.0 * (SQUARE + np.array([frame, 0, 0.5 * frame])))
    assert found.mesh.polygons == [[0, 1, 2, 3]] or found.mesh.face_vector_area[0, 2] > 0.0  # seen from outside


def test_alembic_that_cannot_be_read_costs_an_error_of_a_line(tmp_path):
    write_alembic(tmp_path / "two.abc", names=("a", "b"))
    with pytest.raises(FileError, match=r"has 2 meshes \(/outer/a, /outer/b\); expected one mesh that moves"):
        read_moving_mesh(tmp_path / "two.abc")
    (tmp_path / "cut.abc").write_bytes((tmp_path / "two.abc").read_bytes()[:700])
    with pytest.raises(FileError, match="is not a valid Alembic file"):
        read_moving_mesh(tmp_path / "cut.abc")


def test_alembic_without_its_package_is_refused_with_the_remedy(tmp_path, monkeypatch):
    monkeypatch.setattr("stitchmesh.io.mesh_formats.alembic_mesh.find_spec", lambda name: None)
    (tmp_path / "cloth.abc").write_bytes(b"Ogawa")
    with pytest.raises(FileError, match=r"is not installed; install it by `pip install stitchmesh\[alembic\]`"):
        read_moving_mesh(tmp_path / "cloth.abc")

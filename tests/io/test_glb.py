# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Binary glTF: the head is followed by our own code, whose result is compared with that of trimesh."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from stitchmesh.errors import FileError
from stitchmesh.io.mesh_formats.glb import DEEPEST, read_glb_polygons

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 2, 0]], "<f4")
CORNERS = np.array([0, 1, 2, 0, 2, 3], "<u2")
Head = dict[str, Any]


def head() -> Head:
    """Return the head of a file of two triangles; a fifth point belongs to none."""
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 60}, {"buffer": 0, "byteOffset": 60, "byteLength": 12}],
        "buffers": [{"byteLength": 72}],
    }  # fmt: skip


def write(path: Path, tree: Head, buffer: bytes = POINTS.tobytes() + CORNERS.tobytes()) -> Path:
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    return path


def turning(path: Path) -> list[tuple[float, ...]]:
    """Return the corners of the triangles that we read, each from its least corner on, in an order of their own."""
    points, faces = read_glb_polygons(path)
    return ordered(points[np.array(faces)])


def ordered(triangles: np.ndarray) -> list[tuple[float, ...]]:
    places = np.round(triangles, 5) + 0.0  # Both programs multiply the same matrices, in another order.
    return sorted(min(tuple(np.roll(one, turn, axis=0).ravel()) for turn in range(3)) for one in places)


def test_nested_turned_scaled_and_mirrored_meshes_lie_where_another_program_sees_them(tmp_path):
    scene, turned = trimesh.Scene(), trimesh.transformations
    box, ball = trimesh.creation.box((1, 2, 3)), trimesh.creation.icosphere(1)
    scene.add_geometry(box, node_name="a", transform=turned.rotation_matrix(0.7, [1, 2, 3], [0.1, 0.2, 0.3]))
    mirrored = turned.compose_matrix(scale=[1, 2, -3], angles=[0.1, 0.2, 0.3], translate=[4, 5, 6])
    scene.add_geometry(ball, node_name="b", parent_node_name="a", transform=mirrored)
    scene.add_geometry(box, node_name="c", parent_node_name="b", transform=turned.translation_matrix([1, 0, 0]))
    scene.export(tmp_path / "m.glb")
    seen = trimesh.load_scene(tmp_path / "m.glb", process=False).to_mesh()
    assert turning(tmp_path / "m.glb") == ordered(np.asarray(seen.vertices)[seen.faces])


def test_a_transform_in_parts_is_that_of_another_program(tmp_path):
    tree = head()
    tree["nodes"] = [{"mesh": 0, "translation": [1, 2, 3], "rotation": [0.5, 0.5, 0.5, 0.5], "scale": [1, 2, 3]}]
    seen = trimesh.load_scene(write(tmp_path / "m.glb", tree), process=False).to_mesh()
    assert turning(tmp_path / "m.glb") == ordered(np.asarray(seen.vertices)[seen.faces])


def test_strips_fans_and_points_without_corners_are_triangles(tmp_path):
    square, bent = [0, 1, 3, 2], [0, 1, 2, 3]
    found = {}
    for mode, corners in ((5, square), (6, bent)):
        tree = head()
        tree["meshes"][0]["primitives"][0]["mode"] = mode
        tree["accessors"][1]["count"] = 4
        buffer = POINTS.tobytes() + np.array([*corners, 0, 0], "<u2").tobytes()
        found[mode] = read_glb_polygons(write(tmp_path / "m.glb", tree, buffer))[1]
    assert found == {5: [[0, 1, 3], [1, 2, 3]], 6: [[1, 2, 0], [2, 3, 0]]}
    tree = head()
    del tree["meshes"][0]["primitives"][0]["indices"]
    assert read_glb_polygons(write(tmp_path / "m.glb", tree))[1] == [[0, 1, 2]]


def test_sparse_and_quantised_positions_are_read(tmp_path):
    tree = head()
    changed = {"bufferView": 2, "componentType": 5123}
    tree["accessors"][0]["sparse"] = {"count": 1, "indices": changed, "values": {"bufferView": 3}}
    tree["bufferViews"] += [{"buffer": 0, "byteOffset": 72, "byteLength": 4},
                            {"buffer": 0, "byteOffset": 76, "byteLength": 12}]  # fmt: skip
    buffer = POINTS.tobytes() + CORNERS.tobytes() + struct.pack("<HH3f", 2, 0, 5, 6, 7)
    assert read_glb_polygons(write(tmp_path / "m.glb", tree, buffer))[0][2].tolist() == [5, 6, 7]
    tree = head()
    tree["accessors"][0] |= {"componentType": 5120, "normalized": True}
    tree["bufferViews"][0]["byteStride"] = 4
    points = np.zeros((15, 4), "i1")
    points[:5, :3] = [[0, 0, 0], [127, 0, 0], [127, 127, 0], [-128, 127, 0], [0, 0, 0]]
    found = read_glb_polygons(write(tmp_path / "m.glb", tree, points.tobytes() + CORNERS.tobytes()))[0]
    assert found.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [-1, 1, 0]]


def nested(tree: Head, depth: int) -> None:
    """Put the mesh into a number of nodes within each other, each of which moves it by 1 m."""
    tree["nodes"] = [{"children": [number + 1], "translation": [1, 0, 0]} for number in range(depth)] + [{"mesh": 0}]


def test_nodes_within_each_other_are_followed_to_a_stated_depth(tmp_path):
    tree = head()
    nested(tree, DEEPEST - 1)
    assert read_glb_polygons(write(tmp_path / "m.glb", tree))[0][:, 0].min() == DEEPEST - 1


HARMS: dict[str, tuple[Callable[[Head], object], str]] = {
    "instances": (lambda tree: tree.update(nodes=[{"mesh": 0}] * 1000, scenes=[{"nodes": [*range(1000)]}]),
                  "more than 100 times as many"),
    "primitives": (lambda tree: tree["meshes"][0].update(primitives=tree["meshes"][0]["primitives"] * 1000),
                   "more than 100 times as many"),
    "depth": (lambda tree: nested(tree, DEEPEST), f"lies in {DEEPEST} others; expected less than {DEEPEST}, join them"),
    "cycle": (lambda tree: tree.update(nodes=[{"mesh": 0, "children": [1]}, {"children": [0]}]), "lies in itself"),
    "two parents": (lambda tree: tree.update(nodes=[{"children": [1, 1]}, {"mesh": 0}]), "in two nodes"),
    "count": (lambda tree: tree["accessors"][0].update(count=2**62), "more than 100 times as many"),
    "negative": (lambda tree: tree["accessors"][0].update(count=-1), "has -1 elements"),
    "beyond": (lambda tree: tree["accessors"][0].update(count=6000), "ends beyond its bytes"),
    "offset": (lambda tree: tree["bufferViews"][0].update(byteOffset=-8), "ends beyond its bytes"),
    "stride": (lambda tree: tree["bufferViews"][0].update(byteStride=2**40), "ends beyond its bytes"),
    "corner": (lambda tree: tree["accessors"][1].update(bufferView=0, byteOffset=12, count=6), "names point"),
    "no bytes": (lambda tree: tree["accessors"][0].pop("bufferView"), "has no bytes"),
    "file": (lambda tree: tree["buffers"][0].update(uri="/etc/passwd"), "expected a file in its folder"),
    "file above": (lambda tree: tree["buffers"][0].update(uri="a/../../b.bin"), "expected a file in its folder"),
    "other address": (lambda tree: tree["buffers"][0].update(uri="https://a.org/b.bin"), "a file in its folder"),
    "extension": (lambda tree: tree.update(extensionsRequired=["KHR_materials_x", "ACME_hair"]), "extension ACME_hair"),
    "copies": (lambda tree: tree["nodes"][0].update(extensions={"EXT_mesh_gpu_instancing": {}}), "gpu_instancing"),
    "meshopt": (lambda tree: (tree["buffers"].append({"byteLength": 60}), tree["bufferViews"][0].update(
                buffer=1, extensions={"EXT_meshopt_compression": {}})), "compressed by EXT_meshopt"),
    "joints": (lambda tree: (tree["nodes"][0].update(skin=0), tree.update(skins=[{"joints": [3]}])), "not in"),
    "no weights": (lambda tree: (tree["nodes"][0].update(skin=0), tree.update(skins=[{"joints": [0]}])), "no weight"),
    "many joints": (lambda tree: (tree.update(skins=[{"joints": [0] * 10**5}], scenes=[{"nodes": [*range(100)]}],
                    nodes=[{"mesh": 0, "skin": 0}] * 100)), "more than 100 times as many"),
    "matrix": (lambda tree: tree["nodes"][0].update(matrix=[1.0] * 15), "has 15 numbers"),
    "overflow": (lambda tree: tree["nodes"][0].update(scale=[1e308] * 3, translation=[1e308] * 3), "must be finite"),
    "node": (lambda tree: tree["scenes"][0].update(nodes=[7]), "names node 7 of 1"),
    "kind": (lambda tree: tree.update(nodes={"a": 1}), "expected a list"),
    "compressed": (lambda tree: tree.update(extensionsRequired=["KHR_draco_mesh_compression"]), "compressed by KHR"),
}  # fmt: skip
"""What a head may state, and words of the error."""


@pytest.mark.parametrize("harm", HARMS)
def test_a_head_that_states_too_much_or_nonsense_costs_an_error_of_a_line(tmp_path, harm):
    change, words = HARMS[harm]
    tree, corners = head(), np.tile(CORNERS, 5000)
    tree["accessors"][1]["count"], tree["bufferViews"][1]["byteLength"] = len(corners), corners.nbytes
    change(tree)
    with pytest.raises(FileError, match=words) as caught:
        read_glb_polygons(write(tmp_path / "m.glb", tree, POINTS.tobytes() + corners.tobytes()))
    assert "\n" not in str(caught.value)


def skinned() -> tuple[Head, bytes]:
    """Return a head and a buffer: of five points, the joint of node 1 carries two, and that of node 2 the others."""
    tree = head()
    tree["nodes"] = [{"mesh": 0, "skin": 0, "translation": [9, 9, 9]},
                     {"translation": [0, 0, 1]}, {"scale": [2, 2, 2]}]  # fmt: skip
    tree["scenes"][0]["nodes"] = [0, 1, 2]
    tree["skins"] = [{"joints": [1, 2], "inverseBindMatrices": 4}]
    tree["meshes"][0]["primitives"][0]["attributes"] |= {"JOINTS_0": 2, "WEIGHTS_0": 3}
    joints, weights = np.zeros((5, 4), "u1"), np.zeros((5, 4), "u1")
    joints[2:, 0], weights[:, 0] = 1, 255
    bind = np.tile(np.eye(4, dtype="<f4"), (2, 1, 1))
    bind[0, 3, 0] = 3.0  # The matrices are stored by columns: a shift by 3 along x.
    parts = [POINTS.tobytes(), CORNERS.tobytes(), joints.tobytes(), weights.tobytes(), bind.tobytes()]
    ends = np.cumsum([0, *map(len, parts)]).tolist()
    tree["bufferViews"] = [{"buffer": 0, "byteOffset": start, "byteLength": len(part)}
                           for start, part in zip(ends, parts, strict=False)]  # fmt: skip
    tree["accessors"] += [{"bufferView": 2, "componentType": 5121, "count": 5, "type": "VEC4"},
                          {"bufferView": 3, "componentType": 5121, "normalized": True, "count": 5, "type": "VEC4"},
                          {"bufferView": 4, "componentType": 5126, "count": 2, "type": "MAT4"}]  # fmt: skip
    return tree, b"".join(parts)


def test_the_joints_of_a_skin_carry_the_points_and_the_node_does_not(tmp_path):
    points, _ = read_glb_polygons(write(tmp_path / "m.glb", *skinned()))
    expected = np.concatenate([POINTS[:2] + np.array([3, 0, 1]), 2 * POINTS[2:]])
    np.testing.assert_array_equal(points, expected)


def test_morph_targets_move_the_points_by_the_weights_of_the_node_or_of_the_mesh(tmp_path):
    tree = head()
    tree["meshes"][0] |= {"weights": [0.5]}
    tree["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}]
    for node, scale in ((None, 1.5), ([2.0], 3.0)):
        tree["nodes"] = [{"mesh": 0} | ({} if node is None else {"weights": node})]
        np.testing.assert_array_equal(read_glb_polygons(write(tmp_path / "m.glb", tree))[0], scale * POINTS)


def test_numbers_lie_in_the_head_or_in_a_file_beside_it(tmp_path):
    tree, buffer = head(), POINTS.tobytes() + CORNERS.tobytes()
    (tmp_path / "two words.bin").write_bytes(buffer)
    for uri in ("two%20words.bin", "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()):
        tree["buffers"][0]["uri"] = uri
        (tmp_path / "m.gltf").write_text(json.dumps(tree))
        assert turning(tmp_path / "m.gltf") == ordered(POINTS[CORNERS].reshape(-1, 3, 3))


def test_points_and_lines_are_left_out_in_one_line(tmp_path, caplog):
    tree = head()
    tree["meshes"][0]["primitives"] += [{"attributes": {"POSITION": 0}, "mode": mode} for mode in (0, 1)]
    assert len(read_glb_polygons(write(tmp_path / "m.glb", tree))[1]) == 2
    said = "left out primitives, which the surface does not need: points or lines (2)"
    assert caplog.messages == [f"{tmp_path / 'm.glb'}: {said}"]

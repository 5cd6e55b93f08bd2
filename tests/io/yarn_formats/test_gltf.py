# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""glTF files: closed tubes in metres with outward faces, the radius and the colours of the yarns."""

from __future__ import annotations

import json
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io import read_yarns, write_yarns
from stitchmesh.io.any_file import read_any
from stitchmesh.io.yarn_formats import gltf
from stitchmesh.yarn import YarnSet
from tests.gallery import shared
from tests.io.yarn_sets import ring

RADII = [0.1, 0.2, 0.15]
SIDES, SECTIONS = gltf.DETAIL[0][1:]
FLOAT32 = 2.0**-24


def linked_and_open() -> YarnSet:
    """Return two rings, one of them away from the origin, and a straight open yarn of 8 cm along y."""
    straight = np.stack([np.zeros(11), np.arange(11.0) - 5, np.full(11, 3.0)], axis=1)
    curves = [ring([0, 0, 0]), ring([5, 1, 0], 2.0), straight]
    return YarnSet.from_curves(curves, closed=[True, True, False], radius=RADII)


def loaded(path: Path) -> trimesh.Trimesh:
    """Return the meshes of a file as one, each at its place; only a single mesh without a place keeps its normals."""
    scene = trimesh.load_scene(path, process=False)
    (first, *others) = scene.geometry.values()
    place, _ = scene.graph[scene.graph.nodes_geometry[0]]
    return first if not others and np.array_equal(place, np.eye(4)) else scene.to_mesh()


def header(path: Path) -> dict:
    content = path.read_bytes()
    magic, version, size, length = struct.unpack_from("<4sIII", content)
    assert (magic, version, size) == (b"glTF", 2, len(content))
    return json.loads(content[20 : 20 + length])


@pytest.fixture
def file(tmp_path) -> Path:
    write_yarns(tmp_path / "y.glb", linked_and_open())
    return tmp_path / "y.glb"


def test_tubes_are_closed_and_face_outward(file):
    mesh = loaded(file)
    assert mesh.is_watertight and mesh.is_winding_consistent
    bodies = mesh.split()
    assert len(bodies) == 3
    assert all(body.is_watertight and body.volume > 0 for body in bodies)
    assert sorted(body.euler_number for body in bodies) == [0, 0, 2]  # Two tori, and the closed tube of the open yarn.


def test_vertices_are_at_the_radius_with_normals_away_from_the_yarn(file):
    yarns, mesh = linked_and_open(), loaded(file)
    centres = np.concatenate(yarns.sampled(SECTIONS))
    rings = mesh.vertices.reshape(-1, SIDES, 3)
    np.testing.assert_allclose(rings.mean(axis=1), 0.01 * centres, atol=0.07 * FLOAT32)  # Metres in float32.
    counts = [len(points) for points in yarns.sampled(SECTIONS)]
    radius = 0.01 * np.repeat(yarns.radius, counts)[:, None, None]
    outward = (rings - 0.01 * centres[:, None]) / radius
    np.testing.assert_allclose(mesh.vertex_normals.reshape(-1, SIDES, 3), outward, atol=8 * FLOAT32 / min(RADII))


def test_each_colour_is_a_mesh_with_a_material_in_linear_light(tmp_path):
    """Base colours of glTF are linear; IEC 61966-2-1 gives the conversion from sRGB."""
    palette = [[170, 34, 51], [1, 2, 3], [250, 240, 230]]
    yarns = replace(linked_and_open(), colour=[2, 0, 2], palette=palette)
    write_yarns(tmp_path / "y.glb", yarns)
    tree = header(tmp_path / "y.glb")
    assert [mesh["name"] for mesh in tree["meshes"]] == ["yarns 0", "yarns 2"]
    for mesh, number in zip(tree["meshes"], (0, 2), strict=True):
        (primitive,) = mesh["primitives"]
        surface = tree["materials"][primitive["material"]]["pbrMetallicRoughness"]
        light = ((np.array(palette[number]) / 255 + 0.055) / 1.055) ** 2.4  # These colours lie above the linear part.
        np.testing.assert_allclose(surface["baseColorFactor"], [*light, 1.0], rtol=1e-12)
    scene = trimesh.load_scene(tmp_path / "y.glb", process=False)
    counts = [SIDES * len(points) for points in yarns.sampled(SECTIONS)]
    assert [len(mesh.vertices) for mesh in scene.geometry.values()] == [counts[1], counts[0] + counts[2]]


def test_tubes_have_the_apparent_radius(tmp_path):
    yarns = replace(linked_and_open(), drawn_radius=[0.17, 0.34, 0.25])
    write_yarns(tmp_path / "y.glb", yarns)
    rings = loaded(tmp_path / "y.glb").vertices.reshape(-1, SIDES, 3)
    radius = np.linalg.norm(rings - rings.mean(axis=1, keepdims=True), axis=2)
    counts = [len(points) for points in yarns.sampled(SECTIONS)]
    expected = 0.01 * np.repeat(yarns.drawn_radius, counts)[:, None]
    np.testing.assert_allclose(radius, np.broadcast_to(expected, radius.shape), atol=0.2 * FLOAT32)


def test_a_mesh_of_more_vertices_than_16_bits_number_has_parts_that_fit_together(tmp_path, monkeypatch):
    """The triangles of all parts are those of the whole mesh, so that the volume is the same."""
    yarns = linked_and_open()
    write_yarns(tmp_path / "whole.glb", yarns)
    monkeypatch.setattr(gltf, "MOST_VERTICES", 500)
    write_yarns(tmp_path / "parts.glb", yarns)
    tree = header(tmp_path / "parts.glb")
    counts = [accessor["count"] for accessor in tree["accessors"] if accessor["type"] == "VEC3"]
    assert max(counts) <= 500 and len(tree["meshes"]) > 2
    whole, parts = loaded(tmp_path / "whole.glb"), loaded(tmp_path / "parts.glb")
    assert len(parts.faces) == len(whole.faces)
    assert parts.volume == pytest.approx(whole.volume, rel=1e-12)  # the same numbers in another order


def test_the_coarse_level_has_few_sections_and_small_numbers(tmp_path):
    yarns = linked_and_open()
    write_yarns(tmp_path / "y.glb", yarns, detail="coarse")
    mesh, tree = loaded(tmp_path / "y.glb"), header(tmp_path / "y.glb")
    sides, stride = gltf.COARSE_SIDES, gltf.COARSE_STRIDE
    kept = [points[::stride] for points in yarns.sampled(gltf.COARSE_SAMPLES)]
    kept[2] = np.concatenate([kept[2], yarns.sampled(1)[2][-1:]])  # the end of the open yarn
    assert mesh.is_watertight and mesh.volume > 0
    middles = mesh.vertices.reshape(-1, sides, 3).mean(axis=1)
    # Half a step of the box, which is at most 0.5 cm wider than the yarns; metres.
    rounding = 0.5 * 0.01 * (np.ptp(np.concatenate(kept), axis=0).max() + 0.5) / (2.0 * gltf.STEPS)
    np.testing.assert_allclose(middles, 0.01 * np.concatenate(kept), atol=rounding)
    assert tree["extensionsRequired"] == ["KHR_mesh_quantization"]
    normals = normals_of(tmp_path / "y.glb", tree)
    outward = mesh.vertices.reshape(-1, sides, 3) - middles[:, None]
    outward /= np.linalg.norm(outward, axis=2, keepdims=True)
    # Half a step of 127, and two roundings of a place over the radius.
    np.testing.assert_allclose(normals, outward, atol=0.5 / 127 + 4.0 * rounding / (0.01 * min(RADII)))


def normals_of(path: Path, tree: dict) -> np.ndarray:
    """Return the normals of the only mesh of a coarse file, shape (rings, sides, 3): rows of four bytes, in 127ths."""
    content = path.read_bytes()
    accessor = tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["NORMAL"]]
    assert accessor["normalized"] and accessor["componentType"] == 5120
    view = tree["bufferViews"][accessor["bufferView"]]
    start = 20 + struct.unpack_from("<I", content, 12)[0] + 8 + view["byteOffset"]
    rows = np.frombuffer(content, dtype="i1", count=4 * accessor["count"], offset=start)
    return rows.reshape(-1, gltf.COARSE_SIDES, 4)[:, :, :3] / 127.0


def test_a_level_of_detail_that_a_file_cannot_have_is_refused(tmp_path):
    with pytest.raises(ParameterError, match="detail: got 'rough'; expected one of fine, coarse"):
        write_yarns(tmp_path / "y.glb", linked_and_open(), detail="rough")
    with pytest.raises(ParameterError, match=r"detail: .*y\.bcc holds curves and no tubes"):
        write_yarns(tmp_path / "y.bcc", linked_and_open(), detail="coarse")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("read", [read_yarns, read_any])
def test_reading_tubes_as_yarns_is_an_error(file, read):
    with pytest.raises(FileError, match="a glTF file of yarns holds tubes and not the curves of the yarns") as caught:
        read(file)
    assert "\n" not in str(caught.value)


@pytest.mark.nightly
def test_a_published_glove_becomes_closed_tubes(tmp_path):
    """The volume is the area of the polygon times the lengths of the chords, each narrowed at its ends by cos(d / 2).

    The formula is of the second order in the angle d between successive rings.
    """
    radius, sides, sections = 0.0873, 8, 2
    glove = read_yarns(shared("yarns/glove.bcc"), radius=radius)
    write_yarns(tmp_path / "glove.glb", glove)
    mesh = loaded(tmp_path / "glove.glb")
    assert len(mesh.faces) == 2 * sides * sections * len(glove.points)
    expected, turns = 0.0, []
    for points in glove.sampled(sections):
        chord = np.roll(points, -1, axis=0) - points
        length = np.linalg.norm(chord, axis=1)
        cosine = np.einsum("ij,ij->i", chord, np.roll(chord, 1, axis=0)) / (length * np.roll(length, 1))
        turns.append(np.arccos(np.clip(cosine, -1, 1)))
        narrowed = np.cos(turns[-1] / 2)
        expected += float(length @ (narrowed + np.roll(narrowed, -1)) / 2)
    expected *= sides / 2 * np.sin(2 * np.pi / sides) * radius**2 * 1e-6
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    # The tolerance covers the next order, and the twist distributed over a yarn, at most pi (see test_tube_mesh.py).
    fourth = np.mean(np.concatenate(turns) ** 4) / 24
    spread = np.tan(np.pi / sides) / 3 * np.pi / min(map(len, turns))
    assert volume == pytest.approx(expected, rel=fourth + spread)

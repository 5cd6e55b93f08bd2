# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Meshes of USD stages: all of them, where they lie, outside out; and what is read of stages with curves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io import read_mesh, write_mesh, write_yarns
from stitchmesh.io.any_file import read_any
from stitchmesh.mesh import Mesh
from stitchmesh.yarn import YarnSet
from tests.fuzz.reader import small_yarns
from tests.gallery import tube

TRIANGLE = """        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
"""


def stage(folder: Path, *prims: str) -> Path:
    path = folder / "m.usda"
    head = '#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Y"\n)\n'
    path.write_text(head + "".join(f"def Xform \"x{n}\"\n{{\n{prim}}}\n" for n, prim in enumerate(prims)))
    return path


def placed(words: str = "", orientation: str = "") -> str:
    """Return a mesh with an operation on its transform, such as ``double3 xformOp:scale = (1, 1, -1)``."""
    order = f'    uniform token[] xformOpOrder = ["{words.split()[1]}"]\n' if words else ""
    body = f"{TRIANGLE}        uniform token orientation = \"{orientation}\"\n" if orientation else TRIANGLE
    return f"    {words}\n{order}    def Mesh \"a\"\n    {{\n{body}    }}\n"


def test_all_meshes_are_joined_in_centimetres_and_faces_look_outwards(tmp_path, caplog):
    moved = "double3 xformOp:translate = (0, 0, 2)"
    mirrored = "double3 xformOp:scale = (1, 1, -1)"
    ball = '    def Sphere "ball"\n    {\n    }\n'
    turned = placed(mirrored), placed("", "leftHanded"), placed(mirrored, "leftHanded")
    path = stage(tmp_path, placed(moved), *turned, ball)
    mesh = read_mesh(path)
    assert mesh.face_count == 4
    np.testing.assert_array_equal(mesh.face_vector_area[:, 2] > 0, [True, False, False, True])
    assert mesh.vertices.max() == 200.0 and mesh.vertices[:, 0].max() == 100.0
    assert caplog.messages == [f"{path}: left out prims, which the surface does not need: Sphere (1)"]


def test_a_stage_of_curves_is_yarns_and_another_one_a_mesh(tmp_path):
    write_yarns(tmp_path / "yarns.usdc", small_yarns())
    write_mesh(tmp_path / "mesh.usdc", tube(6, 2))
    assert type(read_any(tmp_path / "yarns.usdc")) is YarnSet
    mesh = read_any(tmp_path / "mesh.usdc")
    assert type(mesh) is Mesh and mesh.face_count == 12
    with pytest.raises(FileError, match="has no faces; expected prims of type Mesh, or of type BasisCurves for yarns"):
        read_mesh(tmp_path / "yarns.usdc")

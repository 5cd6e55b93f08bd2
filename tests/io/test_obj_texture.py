# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Texture vertices and groups of OBJ files."""

from __future__ import annotations

from pathlib import Path

import pytest

from stitchmesh.errors import FileError
from stitchmesh.io.mesh_formats.obj_texture import ObjTexture, read_obj_texture

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
TEXTURE = "vt 0 0\nvt 2 0\nvt 2 2\nvt 0 2\n"


def read(folder: Path, text: str) -> ObjTexture:
    path = folder / "square.obj"
    path.write_text(text)
    return read_obj_texture(path)


def test_corners_with_normals_and_counted_back_name_the_same_texture_vertices(tmp_path):
    forward = read(tmp_path, SQUARE + TEXTURE + "f 1/2/1 2/3/1 3/4/1 4/1/1\n")
    back = read(tmp_path, SQUARE + TEXTURE + "f 1/-3 2/-2 3/-1 4/-4\n")
    assert forward.face_texture == back.face_texture == [[1, 2, 3, 0]]
    assert forward.texture[2] == (2.0, 2.0)


def test_corners_without_texture_vertices_leave_the_texture_out(tmp_path):
    read_without = read(tmp_path, SQUARE + TEXTURE + "o front\nusemtl wool\nf 1//1 2//1 3//1 4//1\n")
    assert read_without.texture == read_without.face_texture == []
    assert read_without.group == [("front", "", "wool")]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SQUARE + "vt 0 x\nf 1 2 3 4\n", "line 5: got 'vt 0 x'; expected 'vt u v' with finite numbers"),
        (SQUARE + "vt nan 0\nf 1 2 3 4\n", "line 5: got 'vt nan 0'"),
        (SQUARE + TEXTURE + "f 1/1 2/2 3/3 4/9\n", "line 9: texture vertex 9 does not exist; the file has 4"),
        (SQUARE + TEXTURE + "f 1/1 2/2 3/3 4/0\n", "line 9: texture vertex 0 does not exist"),
        (SQUARE + TEXTURE + "f 1/1 2/2 3/3 4/-5\n", "line 9: texture vertex -5 does not exist"),
        (SQUARE + TEXTURE + "f 1/1 2/2 3/3 4\n", "line 9: a corner has no texture vertex, and others have one"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path, text, message):
    with pytest.raises(FileError, match=message):
        read(tmp_path, text)

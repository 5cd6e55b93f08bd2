# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import MeshError
from stitchmesh.faces.face_mesh import FaceMesh
from stitchmesh.faces.face_type import FaceType
from stitchmesh.io.stitch_formats.face_meshes import read_face_mesh
from tests.faces.face_files import WEAVE, flat_file


@pytest.fixture(scope="module")
def weave(tmp_path_factory) -> FaceMesh:
    path: Path = tmp_path_factory.mktemp("faces") / "weave.smobj"
    path.write_text(flat_file(WEAVE, ["01", "10"]))
    return read_face_mesh(path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"face_start": [0]}, "got no faces"),
        ({"vertices": np.full((16, 3), np.nan)}, "a coordinate is not finite"),
        ({"source_line": [1, 2]}, r"source_line: got shape \(2,\); expected \(4,\)"),
        ({"face_start": [0, 3, 8, 12, 16]}, "face 0.*: got 3 corners; its type over .* has 4"),
        ({"joins": [[1, 7], [1, 2]], "reverses": [True, True]}, "face 0, side 1: is joined twice"),
        ({"face_type": [0, 1]}, r"face_type: got shape \(2,\); expected \(4,\)"),
        ({"face_type": [0, 1, 1, 5]}, "face_type 3: got 5; expected 0 to 1"),
    ],
)
def test_faces_that_do_not_fit_are_refused(weave, changes, message):
    with pytest.raises(MeshError, match=message):
        replace(weave, **changes)


@pytest.mark.parametrize(
    ("labels", "stands"),
    [
        (("-l1", "+y1", "+l1", "-y1"), True),
        (("-lX", "+y1", "+l1", "-y1"), True),
        (("-l2", "+y1", "+l1", "-y1"), False),
        (("+l1", "+y1", "+l1", "-y1"), False),
        (("-l1", "+y1", "-y1"), False),
    ],
)
def test_a_varying_count_stands_for_any_count_and_nothing_else_does(labels, stands):
    knit = FaceType("knit+", ("-l1", "+y1", "+l1", "-y1"))
    assert knit.stands_for(FaceType("knit+", labels)) == stands

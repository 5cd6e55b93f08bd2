# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where a scene with a body begins."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.mixed.scene.scene_file import read_scene

BALL = """
[cloth]
rectangle = [4, 4]
edge_length = 0.5
[yarns]
weave = "plain"
ends = 4
picks = 4
[[bodies]]
shape = "ball"
size = [1]
centre = [2, 2, 0.3]
[contact]
thickness = 0.2
"""


def test_a_cloth_that_starts_in_a_body_is_moved_out_where_the_scene_says_so(tmp_path: Path) -> None:
    distances = []
    for end in ("", "start_outside = true\n"):
        path = tmp_path / "scene.toml"
        path.write_text(BALL + end)
        prepared = prepare(read_scene(path))
        distances.append(np.linalg.norm(prepared.vertices - [2.0, 2.0, 0.3], axis=1).min() - 1.0)
    assert distances[0] < -0.5
    assert distances[1] > 0.0  # the ball of triangles lies within the ball of radius 1

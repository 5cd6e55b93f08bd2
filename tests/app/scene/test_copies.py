# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Copies of one surface in the scene of viser: what moves is sent, and what is equal stays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.app.browser.bridge import Bridge
from stitchmesh.app.scene.drawing import Copies
from stitchmesh.app.scene.viser_scene import ViserScene
from stitchmesh.app.server import open_server

TRIANGLE = Copies(
    np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], dtype=np.uint32), (255, 128, 0),
    np.array([[0, 0, 0], [2, 0, 0]], dtype=np.float32),
)  # fmt: skip


@pytest.fixture
def scene() -> Iterator[ViserScene]:
    opened = open_server(port=0)
    yield ViserScene(opened.server, Bridge(opened.server), lambda _stroke: None)
    opened.stop()


def node_of(scene: ViserScene) -> Any:
    return scene._shown["fabric"].nodes[0]


def test_copies_that_move_keep_their_node(scene):
    scene.show("fabric", TRIANGLE)
    node = node_of(scene)
    moved = replace(TRIANGLE, points=TRIANGLE.points + 1, offsets=TRIANGLE.offsets * 2, colour=(0, 0, 255))
    scene.show("fabric", moved)
    assert node_of(scene) is node
    np.testing.assert_array_equal(node.vertices, moved.points)
    np.testing.assert_array_equal(node.batched_positions, moved.offsets)
    np.testing.assert_array_equal(node.batched_colors, [0, 0, 255])


@pytest.mark.parametrize("change", [
    {"triangles": np.array([[0, 2, 1]], dtype=np.uint32)},
    {"offsets": np.zeros((3, 3), dtype=np.float32)},
], ids=["triangles", "number of copies"])  # fmt: skip
def test_copies_of_another_structure_are_drawn_anew(scene, change):
    scene.show("fabric", TRIANGLE)
    node = node_of(scene)
    scene.show("fabric", replace(TRIANGLE, **change))
    assert node_of(scene) is not node
    scene.remove("fabric")
    assert "fabric" not in scene._shown


def test_colours_are_sent_in_linear_light(scene):
    """An sRGB value of 128 of 255 is 21.6 % of the light (IEC 61966-2-1)."""
    scene.show("fabric", TRIANGLE)
    np.testing.assert_array_equal(node_of(scene).batched_colors, [255, 55, 0])

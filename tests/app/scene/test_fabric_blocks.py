# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A fabric drawn in blocks: all of it is drawn once, and an edit changes the arrays of few blocks."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

from stitchmesh.app.scene.drawing import Lines, Surface
from stitchmesh.app.scene.fabric_blocks import BLOCK, FabricBlocks, colours_of_faces
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import StitchMesh
from stitchmesh.patterns.swatch_mesh import plain_piece
from tests.app.null_front import NullScene
from tests.editing.random_edits import random_edit

LARGE = plain_piece(60, 90, 1.0, 0.7)


def show(blocks: FabricBlocks, fabric: StitchMesh, *, edges: bool = True) -> None:
    blocks.show(fabric, colours_of_faces(fabric, "stitch"), edges=edges, takes_strokes=True)


def drawn(scene: NullScene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The areas of the triangles that have one, their colours, and the ends of all edges, in the order of the faces."""
    surfaces = [part for part in scene.drawings.values() if isinstance(part, Surface)]
    lines = [part.segments for part in scene.drawings.values() if isinstance(part, Lines)]
    corners = np.concatenate([part.points[part.triangles] for part in surfaces])
    colours = np.concatenate([part.colours.palette[part.colours.index] for part in surfaces])
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    real = area.any(axis=1)  # Blocks have room for more triangles; the others are single points.
    area, colours = area[real], colours[real]
    return area, colours, np.concatenate(lines) if lines else np.zeros((0, 2, 3))


def arrays(scene: NullScene) -> dict[str, tuple[int, ...]]:
    """The identities of the arrays of each drawing; the scene sends those that are new."""
    found = {}
    for name, part in scene.drawings.items():
        if isinstance(part, Surface):
            found[name] = id(part.points), id(part.triangles), id(part.colours)
        else:
            found[name] = (id(part),)
    return found


def test_all_faces_and_all_edges_are_drawn_once():
    scene = NullScene()
    show(FabricBlocks(scene), LARGE)
    area, colours, edges = drawn(scene)
    assert len(scene.drawings) == 2 * -(-LARGE.face_count // BLOCK)
    assert len(area) == len(colours) == 2 * LARGE.face_count and len(edges) == len(LARGE.edge_side)
    np.testing.assert_allclose(area.sum(axis=0), LARGE.face_vector_area.sum(axis=0), rtol=1e-12)


def test_a_change_of_one_stitch_sends_the_colours_of_one_block_only():
    scene = NullScene()
    blocks = FabricBlocks(scene)
    show(blocks, LARGE)
    kept, before = dict(scene.drawings), arrays(scene)  # The drawings are kept, so that no identity is used again.
    show(blocks, apply_edit(LARGE, Edit("change_stitch", {"faces": [3000], "stitch": "p"})).fabric)
    changed = [name for name, identities in arrays(scene).items() if identities != before[name]]
    assert changed == ["fabric/1"] and arrays(scene)["fabric/1"][:2] == before["fabric/1"][:2]
    assert len(kept) == len(scene.drawings)


def test_a_change_of_the_mesh_sends_few_blocks():
    scene = NullScene()
    blocks = FabricBlocks(scene)
    show(blocks, LARGE)
    kept, before = dict(scene.drawings), arrays(scene)
    show(blocks, apply_edit(LARGE, Edit("bobble", {"face": 630})).fabric)
    changed = {name for name, identities in arrays(scene).items() if identities != before.get(name)}
    assert changed == {"fabric/0", "fabric/0/edges", "fabric/2", "fabric/2/edges"}  # New faces take the last numbers.
    surfaces = [name for name in kept if not name.endswith("edges")]
    assert all(kept[name].triangles is scene.drawings[name].triangles for name in surfaces)  # Changed in place.


@pytest.mark.parametrize("seed", [0, 1])
def test_after_any_edits_the_blocks_are_those_of_the_last_fabric(seed):
    random, fabric, scene = Random(seed), plain_piece(30, 80, 1.0, 0.7), NullScene()
    blocks = FabricBlocks(scene)
    show(blocks, fabric)
    for _ in range(8):
        try:
            fabric = apply_edit(fabric, random_edit(random, fabric)).fabric
        except StitchMeshError:
            continue
        show(blocks, fabric, edges=random.random() < 0.7)
    show(blocks, fabric)
    fresh = NullScene()
    show(FabricBlocks(fresh), fabric)
    found, expected = drawn(scene), drawn(fresh)
    for one, other in zip(found[:2], expected[:2], strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_allclose(found[2], expected[2], atol=0.01)  # Edges keep the height of the first fabric.
    assert set(scene.drawings) == set(fresh.drawings)


def test_odd_rows_have_other_colours_than_even_rows():
    for by in ("stitch", "yarn", "row"):
        colours = colours_of_faces(LARGE, by)
        one, other = (colours.palette[colours.index[LARGE.row == row]] for row in (2, 3))
        assert (one == one[0]).all() and (other == other[0]).all() and (one[0] != other[0]).any()


def test_yarns_have_the_colours_of_the_palette():
    fabric = apply_edit(LARGE, Edit("stripe", {"yarn": 200, "rows": [4]})).fabric
    fabric = apply_edit(fabric, Edit("recolour", {"yarn": 200, "colour": "#123456"})).fabric
    colours = colours_of_faces(fabric, "yarn")
    assert colours.palette[colours.index[fabric.row == 4]].tolist() == [[0x12, 0x34, 0x56]] * 60

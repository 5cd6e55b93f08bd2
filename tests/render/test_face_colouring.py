# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of faces are those of their stitches, rows, yarns and stretch; a polygon mesh has one colour."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.errors import ParameterError
from stitchmesh.labeling import label
from stitchmesh.mesh.palette import make_palette
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.render.colour_scale import DIVERGING
from stitchmesh.render.face_colouring import IRREGULAR, colour_faces
from stitchmesh.render.palette import stitch_colour
from stitchmesh.shaping.report import irregular_faces
from stitchmesh.tessellate import tessellate
from tests.gallery import tube
from tests.render.test_pictures import fabric
from tests.yarnrelax.test_contact_load import floor


def test_stitches_rows_and_yarns_differ_where_they_should():
    cloth = replace(fabric(), palette=make_palette(["navy"]))
    even = cloth.row % 2 == 0
    expected = np.array([stitch_colour(code) for code in cloth.stitch])
    np.testing.assert_array_equal(colour_faces(cloth, "stitch").points[even], expected[even])
    rows = colour_faces(cloth, "row").points
    for row in np.unique(cloth.row):
        assert len(np.unique(rows[cloth.row == row], axis=0)) == 1
    assert len(np.unique(rows, axis=0)) == len(np.unique(cloth.row))
    assert (colour_faces(cloth, "yarn").points[cloth.yarn == 0] == [0, 0, 128]).all()


def test_a_compressed_fabric_is_blue_and_one_colour_is_that_of_all_faces():
    cloth = replace(fabric(), stretch=np.full(int(fabric().side_edge.max()) + 1, 0.9))
    coloured = colour_faces(cloth, "stretch")
    assert (coloured.points == DIVERGING[0]).all() and coloured.key[-1][0] == "-10.0 % stretch"
    assert (colour_faces(cloth, "teal").points == [0, 128, 128]).all()


def test_irregular_stitches_have_their_colours_and_the_others_that_of_their_stretch_from_the_mean():
    narrow = tessellate(label(tube(8, 3, radius=3.0, top_radius=1.5)), stitch_width=0.6)
    plain = (narrow.row == 1) & (narrow.n_top == narrow.n_bottom)
    cloth = apply_edit(narrow, Edit("short_rows", {"faces": np.flatnonzero(plain)[:4].tolist()})).fabric
    coloured = colour_faces(cloth, "irregular")
    fewer, turned = cloth.n_top < cloth.n_bottom, irregular_faces(cloth) & (cloth.n_top == cloth.n_bottom)
    assert fewer.any() and turned.any()
    assert (coloured.points[fewer] == IRREGULAR["decreases"]).all()
    assert (coloured.points[turned] == IRREGULAR["turns"]).all()
    assert (coloured.points[~(fewer | turned)] == stitch_colour(Stitch.KNIT)).all()
    assert coloured.key == (
        (f"decreases  {fewer.sum()}", IRREGULAR["decreases"]), (f"turns  {turned.sum()}", IRREGULAR["turns"]),
    )  # fmt: skip
    even = replace(fabric(), stretch=np.full(int(fabric().side_edge.max()) + 1, 1.2))
    pale = colour_faces(even, "irregular").points  # No stitch differs from the mean; the table has an even length.
    np.testing.assert_allclose(pale, np.broadcast_to(DIVERGING[2], pale.shape), atol=1)


@pytest.mark.parametrize(
    ("mesh", "colour", "message"),
    [
        (floor(), "row", "colour: got 'row' for a polygon mesh, which has no rows; give one colour"),
        (replace(fabric(), stretch=None), "stretch", "stretch: the stitch mesh has none; relax the mesh first"),
        (fabric(), "rwo", "did you mean 'row'?"),
    ],
)
def test_what_a_mesh_has_not_is_refused(mesh, colour, message):
    with pytest.raises(ParameterError) as error:
        colour_faces(mesh, colour)
    assert message in str(error.value)

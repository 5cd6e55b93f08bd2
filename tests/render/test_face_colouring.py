# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of faces are those of their stitches, rows, yarns and stretch; a polygon mesh has one colour."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.palette import make_palette
from stitchmesh.render.colour_scale import DIVERGING
from stitchmesh.render.face_colouring import FACE_COLOUR_BY, colour_faces
from stitchmesh.render.palette import stitch_colour
from tests.render.test_pictures import fabric
from tests.yarnrelax.test_contact_load import floor


def test_each_word_gives_each_face_a_colour():
    cloth = replace(fabric(), stretch=np.full(int(fabric().side_edge.max()) + 1, 0.9))
    for word in FACE_COLOUR_BY:
        assert colour_faces(cloth, word).points.shape == (cloth.face_count, 3)
    assert (colour_faces(cloth, "teal").points == [0, 128, 128]).all()


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


def test_a_compressed_fabric_is_blue():
    cloth = replace(fabric(), stretch=np.full(int(fabric().side_edge.max()) + 1, 0.9))
    coloured = colour_faces(cloth, "stretch")
    assert (coloured.points == DIVERGING[0]).all() and coloured.key[-1][0] == "-10.0 % stretch"


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

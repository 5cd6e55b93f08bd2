# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles chosen by hand."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.from_stitches import cloth_from_stitches
from stitchmesh.mixed.placement.chosen_region import triangles_of_faces, triangles_of_panels
from stitchmesh.selection import select
from tests.editing.fabrics import flat
from tests.mixed.placement.sheets import sheet

CLOTH = sheet(4).cloth


def test_a_panel_is_all_its_triangles() -> None:
    assert np.array_equal(triangles_of_panels(CLOTH, "sheet"), np.arange(32))


def test_stitches_of_a_selection_are_all_their_triangles() -> None:
    fabric = flat(5, 4)
    cloth = cloth_from_stitches(fabric, stitch_width=0.5, course_height=0.4)
    faces = select(fabric, "rows 2-3")
    found = triangles_of_faces(fabric, faces)
    assert len(found) == 2 * len(faces)
    own = set(map(int, fabric.face_vertex[np.isin(fabric.side_face, faces)]))
    assert set(map(int, cloth.triangles[found].ravel())) == own


def test_wrong_panels_and_faces_are_refused() -> None:
    with pytest.raises(ParameterError, match="got panel 'sleeve'"):
        triangles_of_panels(CLOTH, "sleeve")
    with pytest.raises(ParameterError, match="got face 99"):
        triangles_of_faces(flat(5, 4), [99])

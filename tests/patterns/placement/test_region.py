# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns on regions: any set of faces takes a pattern, and the faces around it stay as they were."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import apply_pattern, lay_pattern
from tests.patterns.fabrics import codes, differing, flat, pattern, tube

RIB = pattern("k k p p")


def test_a_region_takes_the_pattern_from_its_own_first_row_and_column():
    faces = [9 * row + column for row in (2, 3) for column in range(2, 6)]
    made = apply_pattern(flat(9, 5), pattern("p k", "k p"), faces=faces)
    assert codes(made) == ["c" * 9, "k" * 9, "kkpkpkkkk", "kkkpkpkkk", "k" * 9]


def test_a_ring_of_faces_is_closed():
    made = apply_pattern(tube(8, 4), RIB, faces=range(16, 24))
    assert codes(made) == ["c" * 8, "k" * 8, "kkppkkpp", "k" * 8]


def test_columns_continue_where_a_region_widens():
    faces = [11 + column for column in range(4, 8)] + [22 + column for column in range(1, 10)]
    made = apply_pattern(flat(11, 3), RIB, faces=faces)
    assert codes(made)[1:] == ["kkkkkkppkkk", "kkppkkppkkk"]


@pytest.mark.parametrize(
    "given", [np.array([20, 21, 29, 30]), (21, 20, 30, 29), {20, 21, 29, 30}, iter([20, 21, 29, 30])]
)
def test_any_iterable_of_faces_is_a_region(given):
    expected = apply_pattern(flat(9, 4), pattern("p"), faces=[20, 21, 29, 30])
    assert differing(apply_pattern(flat(9, 4), pattern("p"), faces=given), expected) == []
    assert (expected.stitch == Stitch.PURL).sum() == 4


def test_faces_laid_and_left_out_are_all_faces_of_the_region():
    fabric, faces = tube(11, 4), np.arange(11, 33)
    laid = lay_pattern(fabric, RIB, faces=faces)
    assert laid.faces_laid + sum(len(part.faces) for part in laid.left_out) == len(faces)
    (part,) = laid.left_out
    assert part.faces.tolist() == [11, 12, 13, 22, 23, 24]
    assert (part.rows, part.wales) == ((1, 2), (0, 2))
    assert str(part).startswith("6 stitches (rows 1-2, wales 0-2): these loops are left over")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"faces": []}, "faces: got an empty region; expected at least one face"),
        ({"faces": [3, 400, -1]}, "faces: 400, -1 do not exist; the mesh has faces 0 to 44"),
        ({"faces": np.zeros(45, dtype=bool)}, r"faces: got bool of shape \(45,\); expected numbers of faces"),
        ({"faces": ["hem"]}, "faces: got <U3 of shape"),
        ({"faces": 3.5}, "faces: got 3.5; expected numbers of faces"),
        ({"faces": [12], "face": 12}, "got a face and a region; expected one of them"),
        ({"faces": [12, 13]}, "its 4 columns are more than any first row of the region has"),
        ({"pattern": "rib2x3"}, "pattern 'rib2x3': is not in the library"),
        ({"pattern": 7}, "pattern: got int; expected a Pattern, a name of the library or the path of a file"),
    ],
)
def test_regions_and_patterns_that_do_not_fit_are_refused(given, message):
    arguments = {"pattern": RIB, **given}
    with pytest.raises(ParameterError, match=message):
        apply_pattern(flat(9, 5), **arguments)


def test_a_value_that_is_no_fabric_is_refused():
    with pytest.raises(ParameterError, match="fabric: got str; expected a StitchMesh, the result of tessellate"):
        apply_pattern("hat.obj", RIB)

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns with other colours are, to the last bit, the yarns that the fabric with these colours generates."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.editing.spiral import make_spiral
from stitchmesh.patterns import apply_pattern, parse_pattern
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.recolouring import changes_colours_only, keeps_yarn_routes, recoloured_yarns
from tests.app.project.projects import same
from tests.editing.fabrics import around, flat

STRIPES = Edit("stripes", {"bands": "2 navy, 1 cream"})
FLOATS = apply_pattern(flat(6, 3), parse_pattern("chart colours:\n011\n"))
OTHER_ORDER = Edit("paste_pattern", {"pattern": "chart colours:\n100\n"})
HIGHER_NUMBER = Edit("paste_pattern", {"pattern": "chart colours:\n022\n"})
CASES = {
    "rings in stripes": (around(), STRIPES, True),
    "another colour of a yarn": (flat(), Edit("recolour", {"yarn": 0, "colour": "navy"}), True),
    "rows that turn in stripes": (flat(), STRIPES, False),
    "a spiral in stripes": (make_spiral(around()), STRIPES, False),
    "one stitch of a ring": (around(), Edit("stripe", {"yarn": 1, "faces": [20]}), False),
    "a flat fabric of another number": (flat(), Edit("stripe", {"yarn": 3, "rows": [0, 1, 2, 3, 4, 5]}), True),
    "floats behind other floats": (FLOATS, OTHER_ORDER, False),
    "floats of a higher number": (FLOATS, HIGHER_NUMBER, True),
}


@pytest.mark.parametrize(("fabric", "edit", "kept"), CASES.values(), ids=CASES)
def test_yarns_keep_their_ways_where_only_colours_change(fabric, edit, kept):
    edited = apply_edit(fabric, edit)
    assert changes_colours_only(edited.changes)
    assert keeps_yarn_routes(fabric, edited.fabric) == kept
    before, after = generate_yarns(fabric), generate_yarns(edited.fabric)
    if kept:
        assert same(recoloured_yarns(before, fabric, edited.fabric), after)
    else:
        assert not np.array_equal(before.points, after.points)


def test_a_change_of_stitches_is_more_than_colours():
    assert not changes_colours_only(apply_edit(flat(), Edit("change_stitch", {"faces": [10], "stitch": "p"})).changes)

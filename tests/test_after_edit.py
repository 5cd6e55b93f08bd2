# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Any edit, then relaxing again, leads to yarns: from the relaxed yarns before the edit, or anew."""

from __future__ import annotations

from functools import cache
from random import Random

import numpy as np
import pytest

from stitchmesh import generate_yarns, label, read_mesh, relax_edited, relax_mesh, relax_yarns, tessellate
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import StitchMesh
from stitchmesh.yarn import YarnSet
from tests.editing.random_edits import _ARGUMENTS
from tests.gallery import GARMENTS
from tests.nightly import mostly_at_night

pytestmark = pytest.mark.decides

HAT = next(path for path in GARMENTS if path.stem == "hat")


COARSE, FINE = 2.2, 1.6
"""Stitch widths [cm]. The coarse hat takes a third of the time."""
NEEDS_FINE = ("bobble", "set_cable", "ungraft")
"""On the coarse hat yarns of the others start too close, and the cable starts warm: here it is relaxed anew."""
POSSIBLE = tuple(name for name in _ARGUMENTS if name not in ("clear_cable", "graft"))
"""A hat has one border and no cable."""
TELLING = ("twist_loop", "insert_row")
"""Edits that change a loop and a row; both of them on the coarse hat."""


@cache
def fabric(stitch_width: float) -> StitchMesh:
    surface = read_mesh(HAT)
    return relax_mesh(tessellate(label(surface), stitch_width=stitch_width), surface=surface, device="cpu").fabric


@cache
def relaxed(stitch_width: float) -> YarnSet:
    before = fabric(stitch_width)
    yarns = generate_yarns(before, quality="draft")
    return relax_yarns(yarns, quality="draft", keep_shape=before, device="cpu").yarns


def first_possible(name: str, before: StitchMesh) -> StitchMesh | None:
    """Return a fabric after the first possible of some random edits of that name, None if none is possible."""
    wide = Edit("split_course_edge", {"side": int(before.left_wale[100]) - 1})
    base = apply_edit(before, wide).fabric if name == "add_wale_edge" else before  # It divides an increase.
    for seed in range(40):
        try:
            return apply_edit(base, Edit(name, _ARGUMENTS[name](Random(seed), base))).fabric
        except StitchMeshError:
            continue
    return None


@pytest.mark.parametrize("name", mostly_at_night(POSSIBLE, by_day=TELLING))
def test_every_edit_and_relaxing_again_leads_to_yarns(name):
    width = FINE if name in NEEDS_FINE else COARSE
    after = first_possible(name, fabric(width))
    assert after is not None
    made = relax_edited(relaxed(width), fabric(width), after, quality="draft", device="cpu")
    assert made.report["converged"] and made.report["certificate"] == "unchanged"
    assert (made.report["warm"] > 0.0) == (not any("anew" in note for note in made.report["notes"]))
    # A spiral moves every ring of stitches. Loops of a cable that cross, and loops of another pattern among loops that
    # lean as far as they do at rest, may be too close for a warm start.
    assert made.report["warm"] > 0.3 or name in ("spiral", "set_cable", "paste_pattern")


@pytest.mark.nightly
def test_a_row_and_a_bobble_in_it_are_evened_out_and_start_warm():
    """The stitches of the new rows are a quarter as high as others, too crowded for a bobble."""
    middle = int(np.flatnonzero(fabric(FINE).row == fabric(FINE).row.max() // 2)[3])
    row = apply_edit(fabric(FINE), Edit("insert_row", {"face": middle})).fabric
    row = apply_edit(row, Edit("insert_row", {"face": middle})).fabric
    new = int(np.flatnonzero(row.row == fabric(FINE).row[middle] + 1)[5])
    after = apply_edit(row, Edit("bobble", {"face": new})).fabric
    with pytest.raises(StitchMeshError, match="relax the stitch mesh first"):
        generate_yarns(after, yarn_radius=float(relaxed(FINE).radius[0]), quality="draft")
    made = relax_edited(relaxed(FINE), fabric(FINE), after, quality="draft", device="cpu")
    assert made.report["converged"] and made.report["warm"] > 0.7
    assert len(made.report["notes"]) == 1 and made.report["notes"][0].startswith("evened out the stitches")
    assert made.fabric.face_count == after.face_count and not np.array_equal(made.fabric.vertices, after.vertices)


def test_an_edit_that_changes_no_position_keeps_the_fabric():
    after = apply_edit(fabric(COARSE), Edit("change_stitch", {"faces": [100], "stitch": "p"})).fabric
    made = relax_edited(relaxed(COARSE), fabric(COARSE), after, quality="draft", device="cpu")
    assert made.fabric is after and made.report["notes"] == [] and made.report["warm"] > 0.97

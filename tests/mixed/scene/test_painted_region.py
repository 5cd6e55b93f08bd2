# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles that are painted into a region, and out of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.mixed.scene.region_section import RegionSection, marked_triangles, with_triangles, without_triangles
from tests.mixed.small_scene import MIDDLE, SWINGING

CLOTH = SWINGING.cloth.cloth()
EVERY = np.arange(len(CLOTH.triangles))
BOXED = RegionSection(boxes=(MIDDLE,))
INSIDE = BOXED.triangles(CLOTH)
OUTSIDE = np.setdiff1d(EVERY, INSIDE)
SECTIONS = {
    "none": RegionSection(yarns="none"), "box": BOXED, "faces": RegionSection(faces=(0, 1, 5)),
    "both": RegionSection(boxes=(MIDDLE,), faces=(0, int(INSIDE[0]))), "all": RegionSection(yarns="all"),
    "automatic": RegionSection(yarns="automatic", nodes=9, boxes=(MIDDLE,)),
}  # fmt: skip


@pytest.mark.parametrize("section", SECTIONS.values(), ids=SECTIONS)
def test_painting_is_union_and_difference(section):
    before = marked_triangles(section, CLOTH)
    for painted in (INSIDE[:2], OUTSIDE[:3], EVERY[::2], EVERY[:0]):
        more, less = with_triangles(section, CLOTH, painted), without_triangles(section, CLOTH, painted)
        assert np.array_equal(marked_triangles(more, CLOTH), np.union1d(before, painted))
        assert np.array_equal(marked_triangles(less, CLOTH), np.setdiff1d(before, painted))
        assert (more.yarns == "automatic") == (section.yarns == "automatic")


def test_a_box_stays_until_it_loses_a_triangle():
    assert with_triangles(BOXED, CLOTH, INSIDE) == BOXED
    assert with_triangles(BOXED, CLOTH, OUTSIDE[:2]).boxes == (MIDDLE,)
    assert without_triangles(BOXED, CLOTH, OUTSIDE) == BOXED
    less = without_triangles(BOXED, CLOTH, INSIDE[:1])
    assert less.boxes == () and less.faces == tuple(INSIDE[1:].tolist())


def test_yarns_nowhere_forget_their_boxes_when_something_is_painted():
    """A box that is not used must not come back with the first stroke."""
    painted = with_triangles(replace(BOXED, yarns="none"), CLOTH, OUTSIDE[:1])
    assert painted == RegionSection(faces=(int(OUTSIDE[0]),))

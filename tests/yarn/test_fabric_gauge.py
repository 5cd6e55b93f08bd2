# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The gauge of stitches and of the yarns that were made of them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stitchmesh.labeling import label
from stitchmesh.tessellate import tessellate
from stitchmesh.yarn.stitch_size import fabric_gauge, yarn_gauge
from stitchmesh.yarn.yarn_set import YarnSet
from stitchmesh.yarngen import generate_yarns
from tests.gallery import grid


@pytest.fixture(scope="module")
def flat():
    """A piece of 12 x 8 stitches of 0.5 x 0.4 cm, and its yarns as drawn."""
    fabric = tessellate(label(grid(4, 2, width=1.5, height=1.6)), stitch_width=0.5, stitch_height=0.4)
    return fabric, generate_yarns(fabric, quality="draft")


def test_yarns_as_drawn_have_the_gauge_of_their_stitches(flat):
    """Each stitch is drawn alike in its face, so that the middles of neighbours are as far apart as the faces."""
    fabric, yarns = flat
    made, drawn = fabric_gauge(fabric), yarn_gauge(yarns, fabric)
    assert (made.stitches, made.rows) == pytest.approx((20.0, 25.0))
    assert (drawn.stitches, drawn.rows) == pytest.approx((20.0, 25.0), rel=1e-9)


def test_yarns_that_have_shrunk_have_more_stitches_in_10_cm(flat):
    fabric, yarns = flat
    drawn = yarn_gauge(replace(yarns, points=yarns.points * [0.8, 0.5, 1.0]), fabric)
    assert (drawn.stitches, drawn.rows) == pytest.approx((20.0 / 0.8, 25.0 / 0.5), rel=1e-9)


def test_yarns_of_no_stitch_have_no_gauge(flat):
    fabric, yarns = flat
    curve = yarns.points[:20]
    assert yarn_gauge(YarnSet.from_curves([curve], closed=[False], radius=0.01), fabric) is None

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A knitted garment that a body cuts is put round it before its yarns are relaxed."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.pipeline.options import RelaxOptions
from stitchmesh.pipeline.yarn_relaxation import relax_with_options
from stitchmesh.quality import quality_with
from tests.gallery import tube
from tests.mixed.contact.bodies import ball, box

MIDDLE = (0.0, 3.0, 0.0)


@pytest.fixture(scope="module")
def knitted():
    """The stitches and the yarns of a tube of radius 3 cm."""
    fabric = sm.tessellate(sm.label(tube(12, 6)), stitch_width=1.2)
    return fabric, sm.generate_yarns(fabric, quality="draft")


def depth(yarns, mesh) -> float:
    """How deep the middle of a yarn is in a body [cm]."""
    return -float((sm.body_distance(yarns, mesh, device="cpu") + yarns.radius[yarns.segment_yarn]).min())


def test_a_tube_goes_round_a_ball_that_is_wider(knitted):
    fabric, yarns = knitted
    body = ball(3.4, 3, MIDDLE)  # 0.4 cm wider than the tube, which is 0.1 cm narrower between its corners
    assert depth(yarns, body) > 0.4
    worn = sm.dressed(yarns, fabric, [sm.Body(body)], device="cpu")
    assert depth(worn.yarns, body) < 0.0 and worn.depth == pytest.approx(depth(yarns, body))
    # Yarns of 0.39 cm in loops twice as thick lie round the ball: the rows at its middle are 2 pi 4.0 cm long instead
    # of 2 pi 2.9 cm, and no side of a stitch is stretched more than that.
    assert 3.4 / 3.0 < (worn.fabric.side_length / fabric.side_length).max() < 4.0 / 2.9
    assert np.array_equal(worn.yarns.rest_length, yarns.rest_length)
    changed = sm.linking_certificate(worn.yarns, device="cpu") != sm.linking_certificate(yarns, device="cpu")
    assert changed.nnz == 0


def test_yarns_outside_stay_to_the_last_bit(knitted):
    fabric, yarns = knitted
    worn = sm.dressed(yarns, fabric, [sm.Body(ball(2.0, 2, MIDDLE))], device="cpu")
    assert worn.yarns is yarns and worn.fabric is fabric and worn.depth == 0.0


def test_a_limb_that_goes_through_the_garment_is_named(knitted):
    fabric, yarns = knitted
    arm = box((6.0, 0.5, 0.5), MIDDLE)  # it leaves the tube on both sides
    with pytest.raises(ParameterError, match=r"goes through the garment near -?3, [234], -?[01] cm .*limbs"):
        sm.dressed(yarns, fabric, [sm.Body(arm)], device="cpu")


def test_a_relaxation_with_a_body_begins_outside_of_it(knitted):
    fabric, yarns = knitted
    body = sm.Body(ball(4.0, 2, MIDDLE))
    options = RelaxOptions(terms=[body])
    few = quality_with("draft", max_iterations=20)
    with pytest.raises(SolverError, match="give the fabric of the yarns"):
        relax_with_options(yarns, options, quality=few, device="cpu")
    relaxed = relax_with_options(yarns, options, quality=few, device="cpu", fabric=fabric)
    assert depth(relaxed.yarns, body.mesh) < 0.0
    assert relaxed.report["dressed"]["depth_cm"] == pytest.approx(depth(yarns, body.mesh))

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of stitches."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.render.palette import ODD_ROW, STITCH_COLOURS, stitch_colours


def test_every_stitch_has_its_own_colour():
    assert set(STITCH_COLOURS) == set(Stitch)
    for (first, one), (second, other) in itertools.combinations(STITCH_COLOURS.items(), 2):
        # Five steps of 255 in one channel are the smallest visible difference of neighbouring colours.
        assert np.abs(np.subtract(one, other)).max() >= 5, f"{first.name} and {second.name}"


@pytest.mark.parametrize("stitch", VOCABULARY)
def test_increases_are_warm_and_decreases_cool(stitch):
    red, _, blue = STITCH_COLOURS[stitch]
    making = VOCABULARY[stitch]
    if making.n_bottom > 1:
        assert blue > red
    elif making.n_top > 1 and "s" not in making.made:
        assert red > blue


def test_odd_rows_are_darker():
    even, odd = stitch_colours([Stitch.KY, Stitch.KY], [2, 3])
    np.testing.assert_array_equal(odd, np.round(np.array(STITCH_COLOURS[Stitch.KY]) * ODD_ROW))
    np.testing.assert_array_equal(even, STITCH_COLOURS[Stitch.KY])

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings check themselves; many colours become a palette."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app.scene.drawing import Colours, Surface
from stitchmesh.errors import ParameterError

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def test_few_colours_are_kept_exactly_and_many_are_nearest_ones_of_a_cube():
    colours = np.random.default_rng(1).integers(0, 256, (5000, 3)).astype(np.uint8)
    few = Colours.of(colours[np.arange(1000) % 200])
    np.testing.assert_array_equal(few.palette[few.index], colours[np.arange(1000) % 200])
    made = Colours.of(colours)
    off = np.abs(made.palette[made.index].astype(int) - colours.astype(int))
    assert len(made.palette) == 252
    # half a step of the cube, 255 / 5 / 2 and 255 / 6 / 2, and the rounding of its colours
    assert (off.max(axis=0) <= [26, 22, 26]).all()


@pytest.mark.parametrize(
    ("index", "palette", "message"),
    [([0, 1], [[0, 0, 0]], "index 1 in a palette of 1"), ([0], np.zeros((300, 3)), "palette of 300; expected 1 to 256"),
     ([], np.zeros((0, 3)), "palette of 0")],
)  # fmt: skip
def test_wrong_palettes_are_refused(index, palette, message):
    with pytest.raises(ParameterError, match=message):
        Colours(np.array(index, dtype=np.uint8), np.array(palette, dtype=np.uint8))


def test_a_surface_needs_a_colour_for_each_triangle_or_for_each_point():
    palette = np.zeros((1, 3), dtype=np.uint8)
    Surface(SQUARE, TWO, Colours(np.zeros(2, dtype=np.uint8), palette))
    Surface(SQUARE, TWO, Colours(np.zeros(4, dtype=np.uint8), palette), flat=False)
    with pytest.raises(ParameterError, match="got 4 colours for 2 triangles"):
        Surface(SQUARE, TWO, Colours(np.zeros(4, dtype=np.uint8), palette))

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Thumbnails of patterns."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.patterns.language.parse import parse_pattern
from stitchmesh.patterns.library import read_pattern
from stitchmesh.render.thumbnails.pattern_thumbnail import pattern_thumbnail


def pixels(name: str, size: int = 48) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(pattern_thumbnail(read_pattern(name), size))), dtype=np.float64)


def test_yarn_covers_most_of_the_picture_up_to_its_borders():
    picture = pixels("stockinette")
    assert picture.shape == (48, 48, 3)
    edges = [picture[0], picture[-1], picture[:, 0], picture[:, -1]]
    assert all(np.ptp(edge, axis=0).min() > 0 for edge in edges)


def test_ribs_differ_in_colour_column_by_column():
    # Half of the columns of a rib are purl, which is bluish; plain knit is not.
    blue = lambda picture: (picture[..., 2] - picture[..., 0]).mean(axis=0)  # noqa: E731
    assert np.ptp(blue(pixels("rib2x2"))) > 2 * np.ptp(blue(pixels("stockinette")))


def test_a_pattern_of_several_yarns_has_the_colours_of_its_yarns():
    colours = pixels("checks").reshape(-1, 3)
    ranked = colours[np.argsort(colours.sum(axis=1))]
    dark, light = ranked[10], ranked[-10]  # Below a few pixels of shadow, above none.
    assert dark[2] > dark[0] and light[0] > light[2]  # Denim and cream, the stock colours of two yarns.


@pytest.mark.parametrize("size", [15, 513])
def test_a_size_that_is_out_of_range_is_refused(size):
    with pytest.raises(ParameterError, match=f"got a size of {size} pixels; expected 16 to 512"):
        pattern_thumbnail(read_pattern("moss"), size)


def test_a_pattern_that_does_not_close_is_refused():
    with pytest.raises(PatternError, match="to repeat upwards"):
        pattern_thumbnail(parse_pattern("row 1 RS: k1 yo\nrow 2 WS: p2"))

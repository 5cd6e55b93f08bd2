# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts of patterns: their knit and purl stitches, the first row last, and patterns that are refused."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mixed.layout.knit_chart import knit_chart
from stitchmesh.patterns import parse_pattern, pattern_names, read_pattern


def test_rows_are_listed_from_the_last_to_the_first():
    chart = knit_chart(read_pattern("rib2x2"))
    np.testing.assert_array_equal(chart, [[0, 0, 1, 1], [0, 0, 1, 1]])
    pattern = read_pattern("moss")
    chart = knit_chart(pattern)
    first = [cell.stitch == Stitch.KNIT for cell in pattern.rows[0].sections[1]]
    np.testing.assert_array_equal(chart[-1], first)
    assert len(chart) == len(pattern.rows)


def test_every_pattern_of_knit_and_purl_stitches_has_a_chart_and_no_other():
    for name in pattern_names():
        pattern = read_pattern(name)
        cells = [cell for row in pattern.rows for cell in row.sections[1]]
        loops = [loop for row in pattern.rows for loop in row.loop_sections[1]]
        plain = all(cell.stitch in (Stitch.KNIT, Stitch.PURL) and not any(cell.twist) for cell in cells)
        plain = plain and not any(loop.shift or loop.layer or loop.twist for loop in loops)
        if plain:
            assert knit_chart(pattern).shape == (len(pattern.rows), len(pattern.rows[0].sections[1]))
        else:
            with pytest.raises(ParameterError, match=r"expected .*; lay the pattern on a stitch mesh instead"):
                knit_chart(pattern)


def test_what_is_refused():
    with pytest.raises(ParameterError, match=r"row 1, stitch 1 of the tile: got yo; expected knit or purl"):
        knit_chart(parse_pattern("row 1 RS: k, k2tog, yo", "lace"))
    with pytest.raises(ParameterError, match="expected a Pattern"):
        knit_chart([[1]])

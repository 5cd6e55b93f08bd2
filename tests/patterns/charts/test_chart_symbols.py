# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every stitch has a symbol of its own within its squares, and an instruction."""

from __future__ import annotations

import pytest

from stitchmesh.mesh.stitch import CODES, VOCABULARY
from stitchmesh.patterns.charts.chart_symbols import chart_symbol, word_instruction
from stitchmesh.patterns.charts.knit_chart import mirrored_word, read_square

CABLES = ("c4f", "c4b", "c6f", "t3f", "t3b", "1/2lpc", "cross(1 2 0; 0 0 1: k2tog k)")


def test_no_two_stitches_have_one_symbol():
    symbols = {chart_symbol(code) for code in (*CODES, *CABLES, "t", "ktbl", "none")}
    assert len(symbols) == len(CODES) + len(CABLES) + 3


@pytest.mark.parametrize("word", [*CODES, *CABLES, "t", "none", "ktbl", "k+1"])
def test_symbols_stay_in_their_squares(word):
    symbol = chart_symbol(word)
    assert symbol.columns == read_square(word).columns
    for mark in symbol.marks:
        assert all(0.0 <= x <= symbol.columns and 0.0 <= y <= 1.0 for x, y in mark.points)


@pytest.mark.parametrize("word", ["k2tog", "sk", "2/1lpc"])
def test_the_lines_of_a_mirrored_word_are_mirrored(word):
    def lines(symbol, mirror):
        return sorted(
            tuple((round(symbol.columns - x if mirror else x, 6), y) for x, y in mark.points)
            for mark in symbol.marks
            if mark.kind in ("line", "strand")
        )

    def unordered(symbol, mirror=False):
        return sorted(sorted(points) for points in lines(symbol, mirror))

    assert unordered(chart_symbol(word), mirror=True) == unordered(chart_symbol(mirrored_word(word)))


def test_every_word_says_what_a_knitter_does():
    assert word_instruction("k2tog") == VOCABULARY[CODES["d12k"]].instruction
    assert word_instruction("c4f") == "cable of 4 loops, the loops in front cross to the left"
    assert word_instruction("ktbl").endswith("through the back leg")
    assert word_instruction("none") == "no stitch"
    assert "works both together" in word_instruction("t")

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitches of each word, on the right side, on the wrong side and in a chart."""

from __future__ import annotations

import re

import pytest

from stitchmesh.errors import PatternError
from stitchmesh.mesh.stitch import CODES, VOCABULARY, Stitch, from_wrong_side
from stitchmesh.patterns import Cell, Loop, Pattern, parse_pattern
from stitchmesh.patterns.language.text_charts import LEAF, LETTERS
from stitchmesh.patterns.language.words import ABBREVIATIONS
from tests.gallery import ROOT

DOCUMENT = (ROOT / "docs" / "patterns.md").read_text()
MEANINGS = {
    "yo": "y", "k2tog": "d12k", "ssk": "d21k", "skp": "d21k", "p2tog": "d12p", "ssp": "d21p", "k3tog": "d123k",
    "sssk": "d321k", "sk2p": "d312k", "s2kp": "d231k", "cdd": "d231k", "p3tog": "d123p", "sssp": "d321p",
    "kfb": "pk", "pfb": "kp", "kyok": "kyk", "sl": "b", "slwyib": "b", "slwyif": "f", "m1": "y-1", "m1l": "y-1",
    "m1r": "y+1", "ktbl": "k~-1", "ptbl": "p~-1", "k1tbl": "k~-1", "p1tbl": "p~-1", "sl1": "b", "sl1wyib": "b",
    "sl1wyif": "f", "k3": "k k k", "yo2": "y y", "sl2wyif": "f f", "k2tbl": "[k~-1]*2", "K2TOG": "d12k",
}  # fmt: skip


def row_of(words: str, side: str = "RS") -> Pattern:
    return parse_pattern(f"row 1 {side}: {words}")


def stitches(words: str, side: str = "RS") -> list[Stitch]:
    return [cell.stitch for cell in row_of(words, side).rows[0].cells]


@pytest.mark.parametrize(("word", "codes"), MEANINGS.items())
def test_an_abbreviation_equals_its_codes(word, codes):
    # two more loops, so that every row is worked on loops and makes loops
    assert row_of(f"k2 {word}").rows == row_of(f"k2 {codes}").rows


def test_every_abbreviation_is_tested_and_documented():
    assert set(ABBREVIATIONS) <= set(MEANINGS)
    words = set(re.findall(r"`([^`\n]+)`", DOCUMENT))
    assert set(ABBREVIATIONS) <= words
    assert set(LETTERS) <= words
    assert {code.upper() for code in LEAF} <= {word.upper() for word in words}


def test_a_code_is_read_as_seen_from_the_side_that_works_it():
    for code, stitch in CODES.items():
        assert stitches(f"k2 {code}") == [stitch, Stitch.KNIT, Stitch.KNIT]
        assert stitches(f"k2 {code}", "WS") == [Stitch.PURL, Stitch.PURL, from_wrong_side(stitch)]
        chart = parse_pattern(f"chart:\n  k2 {code}")
        assert [cell.stitch for cell in chart.rows[0].cells] == [Stitch.KNIT, Stitch.KNIT, stitch]


def test_a_row_that_is_turned_twice_is_unchanged():
    for code, stitch in CODES.items():
        if VOCABULARY[stitch].made not in ("s", "sy", "ys"):
            assert from_wrong_side(from_wrong_side(stitch)) == stitch
            turned = VOCABULARY[from_wrong_side(stitch)].code
            assert row_of(f"k2 {code}", "RS").rows[0].cells == row_of(f"{turned} p2", "WS").rows[0].cells


def test_right_side_words_run_from_right_to_left():
    assert stitches("k p yo") == [Stitch.YARN_OVER, Stitch.PURL, Stitch.KNIT]
    assert stitches("k p yo", "WS") == [Stitch.PURL, Stitch.KNIT, Stitch.YARN_OVER]


@pytest.mark.parametrize(("right", "wrong"), [("k2tog", "p2tog"), ("ssk", "ssp"), ("k3tog", "p3tog"), ("sssk", "sssp")])
def test_decreases_of_the_wrong_side_lean_as_knitters_say(right, wrong):
    # p2tog on the wrong side is the same stitch as k2tog on the right side
    assert row_of(f"k {right}").rows[0].cells == row_of(f"{wrong} p", "WS").rows[0].cells


def test_twists_are_given_for_each_loop_and_mirrored_with_the_row():
    assert row_of("kyk+0-1+1").rows[0].cells == (Cell(Stitch.KYK, (0, -1, 1)),)
    assert row_of("pyp+0-1+1", "WS").rows[0].cells == (Cell(Stitch.KYK, (1, -1, 0)),)
    assert row_of("k2tog~+0-1").rows[0].loops == (Loop(), Loop(twist=-1))


def test_a_back_leg_twists_the_loop_below():
    pattern = parse_pattern("row 1 RS: k ktbl\nrow 2 WS: k ptbl")
    assert pattern.loops_above(0) == (Loop(), Loop(twist=-1))  # the stitch of row 2 at the right
    assert pattern.loops_above(1) == (Loop(twist=-1), Loop())  # the stitch of row 1 at the left, one repeat up


def test_a_loop_cannot_be_twisted_twice_but_can_be_untwisted():
    with pytest.raises(PatternError, match=r"line 2, column 1: row 2: loop 1 from the left is twisted twice"):
        parse_pattern("row 1 RS: k-1\nrow 2 RS: ktbl")
    assert parse_pattern("row 1 RS: k+1\nrow 2 RS: ktbl").loops_above(0) == (Loop(),)


def test_yarns():
    pattern = parse_pattern("row 1 RS yarn 1: k2 p@3 k0002@2")
    assert [cell.yarn for cell in pattern.rows[0].cells] == [2, 2, 3, 1, 1]
    assert pattern.yarn_count == 4


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("k2tgo", "did you mean k2tog"),
        ("xylophone", r"got 'xylophone'; expected a stitch such as k, p2, yo, k2tog, c4f"),
        ("k\0", r"got 'k\\x00'; expected a stitch"),
        ("k0", "got 'k0'; expected a count of 1 or more"),
        ("kyk+1", "got 'kyk\\+1'; expected a twist for each of its loops or for none: 3 on top and 1 below"),
        ("c4f+1", r"expected no twists on c4f"),
        ("c5f", r"expected an even number of loops, or write 3/2lc"),
        ("t1b", "expected 2 loops or more"),
        ("2/0lc", "got 2 loops over 0; expected at least 1 of each"),
        ("k+2", "got 'k\\+2'"),
    ],
)
def test_the_message_for_an_unknown_word_gives_its_place(words, found):
    with pytest.raises(PatternError, match=r"lace: line 1, column 13: .*" + found):
        parse_pattern(f"row 1 RS: k {words}", "lace")

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The text language: rows, repeats, sections, charts and tucks; the message for a bad text gives its place."""

from __future__ import annotations

import re

import pytest

from stitchmesh.errors import PatternError
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import format_pattern, parse_pattern
from tests.gallery import ROOT

EXAMPLES = re.findall(r"```knit\n(.*?)```", (ROOT / "docs" / "patterns.md").read_text(), re.DOTALL)
CHARS = {Stitch.KNIT: "k", Stitch.PURL: "p", Stitch.YARN_OVER: "o"}


def picture(text: str) -> list[str]:
    """Return the rows of a pattern from the bottom up, as seen from the right side."""
    rows = parse_pattern(text).rows
    return ["".join(CHARS.get(cell.stitch, "?") for cell in row.cells) for row in rows]


def test_the_examples_of_the_document_can_be_read():
    assert len(EXAMPLES) == 5
    for text in EXAMPLES:
        pattern = parse_pattern(text)
        assert pattern.closes
        assert parse_pattern(format_pattern(pattern)) == pattern


def test_counts_groups_and_commas_are_equivalent():
    assert picture("row 1 RS: [k2 p]*2") == picture("row 1 RS: k2, p, k k p1") == ["pkkpkk"]
    assert picture("row 1 RS: [[k p]*2 k]*2") == ["kpkpkkpkpk"]
    assert picture("row 1 RS: k2,\n  p2  # the row continues\n") == ["ppkk"]


def test_rows_can_be_written_together_and_repeated():
    text = "rows 2, 4-5 WS: p k2\nrow 1 RS: k3\nrow 3: repeat 1\nrows 6-9: repeat 2-1\n"
    assert picture(text) == ["kkk", "kpp", "kkk", "kpp", "kpp", "kpp", "kkk", "kpp", "kkk"]


def test_names_come_from_the_text_or_from_the_file():
    assert parse_pattern("row 1 RS: k", "plain").name == "plain"
    pattern = parse_pattern('pattern "Plain # one"  # a comment\nsource "A book"\nround 1: k')
    assert (pattern.name, pattern.source) == ("Plain # one", "A book")


@pytest.mark.parametrize("text", ["row 1 RS: k2 | p k | k3", "row 1 WS: p3 | p k | p2", "chart:\nk3 | k p | k2"])
def test_bars_separate_the_borders_from_the_tile(text):
    row = parse_pattern(text).rows[0]
    assert (row.left, row.right, row.bottoms, row.tops) == (3, 2, (3, 2, 2), (3, 2, 2))
    assert [cell.stitch for cell in row.sections[1]] == [Stitch.KNIT, Stitch.PURL]


def test_a_border_can_be_missing_at_one_side():
    row = parse_pattern("row 1 RS: | k p | k3").rows[0]
    assert (row.left, row.right) == (3, 0)


def test_loop_counts_must_agree_in_each_section():
    pattern = parse_pattern("row 1 RS: k | [yo k]*2 | k\nrow 2 WS: p | p4 | p")
    assert (pattern.width, pattern.height, pattern.closes) == (2, 2, False)
    assert pattern.rows[0].tops == (1, 4, 1)
    with pytest.raises(PatternError, match="row 2: its left border is worked on 2 loops, but the row below leaves 1"):
        parse_pattern("row 1 RS: k | k2 | k\nrow 2 RS: k | k | k2")


def test_a_pattern_closes_when_it_can_repeat_upwards():
    assert parse_pattern("row 1 RS: yo k\nrow 2 RS: k2tog").closes
    assert not parse_pattern("row 1 RS: yo k\nrow 2 RS: k2").closes


def test_charts_list_the_top_row_first_unless_upwards():
    assert picture("chart letters:\nkpk\nppp\n") == ["ppp", "kpk"]
    assert picture("chart letters upwards:\nkpk\nppp\n\n# done\n") == ["kpk", "ppp"]
    assert picture("chart:\n k p k\n [p]*3\n") == ["ppp", "kpk"]


def test_signs_of_charts():
    row = parse_pattern("chart letters:\nk/o.\\o^oo").rows[0]
    codes = [cell.stitch for cell in row.cells]
    yarn_over = Stitch.YARN_OVER
    assert codes == [
        Stitch.KNIT, Stitch.D12K, yarn_over, Stitch.D21K, yarn_over, Stitch.D231K, yarn_over, yarn_over
    ]  # fmt: skip


def test_codes_of_leaf_have_one_character_for_each_loop():
    text = "KYSF2UBY3YP"
    row = parse_pattern(f"chart leaf:\n{text}").rows[0]
    assert row.n_bottom == row.n_top == len(text)
    yarn_over = Stitch.YARN_OVER
    assert [cell.stitch for cell in row.cells] == [
        Stitch.KNIT, yarn_over, Stitch.D21K, Stitch.SLIP_FRONT, Stitch.D12K, yarn_over, Stitch.SLIP_BACK,
        yarn_over, Stitch.D312K, yarn_over, Stitch.PURL,
    ]  # fmt: skip


def test_colours_of_charts():
    pattern = parse_pattern("chart colours:\n01z\n100")
    assert [[cell.yarn for cell in row.cells] for row in pattern.rows] == [[1, 0, 0], [0, 1, 35]]
    assert [cell.yarn for cell in parse_pattern("chart letters yarn 2:\nkk").rows[0].cells] == [2, 2]


@pytest.mark.parametrize(("above", "stitch"), [("k", Stitch.D12K), ("p", Stitch.D12P)])
def test_a_tuck_is_worked_together_with_its_yarn_over(above, stitch):
    pattern = parse_pattern(f"row 1 RS: p t\nrow 2 RS: p {above}")
    assert [cell.stitch for cell in pattern.rows[0].cells] == [Stitch.SY, Stitch.PURL]
    assert [cell.stitch for cell in pattern.rows[1].cells] == [stitch, Stitch.PURL]
    assert pattern.closes


def test_tucks_of_the_last_row_are_worked_by_the_first():
    pattern = parse_pattern("row 1 RS: k t\nrow 2 WS: k t")  # fisherman's rib
    assert pattern.closes
    assert [[cell.stitch.name for cell in row.cells] for row in pattern.rows] == [["SY", "D12K"], ["D12P", "YS"]]


@pytest.mark.parametrize("word", ["t", "yo k2tog", "ktbl", "sl", "c2f"])
def test_only_knit_and_purl_work_a_tuck(word):
    with pytest.raises(PatternError, match=r"line 2, column 1: got .* above a tuck; only a plain k or p"):
        parse_pattern(f"row 1 RS: k t\nrow 2 RS: k {word}\nrow 3 RS: k k")


BAD = {
    "": r"line 1, column 1: got the end of a pattern without rows; expected row 1 RS",
    "# nothing\n\n": "got the end of a pattern without rows",
    'pattern "x"': "got the end of a pattern without rows",
    "row 1 RS:": r"line 1, column 10: got the end of the line; expected stitches, such as k2 p2",
    "row 1 RS: none": "expected stitches",
    "row 1 RS: yo": "a tile on 0 loops that leaves 1",
    "row RS: k": r"line 1, column 5: got 'RS'; expected the number of a row, or a range such as 3-4",
    "row 0 RS: k": "expected rows numbered 1 to",
    "row 1: k": r"line 1, column 6: got ':'; expected RS or WS before it",
    "round 1 WS: k": "a round has the right side facing",
    "row 1 RS k": r"line 1, column 10: got 'k'; expected ':'",
    "row 2 RS: k": "got row 2, but not row 1; expected all rows from 1",
    "row 1 RS: k\nrow 1 WS: k": r"line 2, column 5: got row 1 a second time",
    "rows 1, 1 RS: k": "got row 1 a second time",
    "rows 1-2: repeat 3-4": "got row 3 to repeat; expected rows that are written above",
    "rows 1-2 RS: k\nrows 3-5: repeat 1-2": "got 2 rows to repeat for 3; expected a whole number of repeats",
    "row 1 RS: k\nrow 2 RS: repeat 1": "leave RS and WS out",
    "row 1 RS: k\nrow 2: repeat 1 k": r"column 17: got 'k'; expected the end of the line",
    "row 1 RS: k2\nrow 2 RS: k3": "row 2: its tile is worked on 3 loops, but the row below leaves 2",
    "row 1 RS: [k2 p": r"line 1, column 11: got '\[' without its partner",
    "row 1 RS: k2 ]": r"column 14: got '\]'; expected a stitch",
    "row 1 RS: " + "[" * 40: "expected at most 32 nested brackets",
    "row 1 RS: k | p": r"column 13: got '\|'; expected no bars, or two",
    "row 1 RS: [k | p]": r"column 14: got '\|'; expected a stitch",
    "row 1 RS: | | k": "a tile on 0 loops",
    "row 1 RS: k*x": r"got 'x'; expected the number of repeats",
    "row 1 RS: k*0": r"got '0'; expected the number of repeats, 1 to",
    "row 1 RS: [[k*9999]*9999]*9999": "got more than 100000 stitches in a row",
    "row 1 RS yarn x: k": "got 'x'; expected the number of a yarn",
    "knit 2": r"line 1, column 1: got 'knit'; expected pattern, source, colours, row",
    "pattern Plain": "expected a text in quotes",
    'pattern "Plain" x': "got 'x'; expected the end of the line",
    'pattern "Plain': r"line 1, column 9: got a quote without its partner",
    "chart:": "got a chart without lines",
    "chart leaf: k": "got 'k'; expected the chart on the lines below",
    "chart runes:\nk": "got 'runes'; expected letters, leaf, colours, upwards, yarn or ':'",
    "chart:\nk k\nk": "line 3, column 1: got 1 columns where the chart's first line has 2",
    "chart letters:\nkk\nkkk": "line 3, column 1: got 3 columns where",
    "chart:\n c4f\n k2": "got 2 columns where the chart's first line has 4",
    "chart letters:\nkz": r"line 2, column 2: got 'z'; expected one of k p",
    "chart leaf:\nKYX": r"line 2, column 2: got 'YX'; expected one of K P F B YS 2U Y3Y",
    "chart colours:\n0-": r"line 2, column 2: got '-'; expected the number of a yarn",
    "chart letters:\nk|k": "got 1 bars; expected none, or two",
    "chart letters:\n...": "a tile on 0 loops",
    "chart:\nk\n\nrow 1 RS: k": "line 4, column 1: got 'row'; expected nothing more: a pattern consists",
    "row 1 RS: k\nchart:\nk": "got 'chart'; expected nothing more",
}


@pytest.mark.parametrize(("text", "found"), BAD.items())
def test_the_message_for_a_bad_text_gives_its_place(text, found):
    with pytest.raises(PatternError, match=found) as caught:
        parse_pattern(text, "shawl.knit")
    assert str(caught.value).startswith("shawl.knit: line ")
    assert "\n" not in str(caught.value)

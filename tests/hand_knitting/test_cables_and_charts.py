# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cables and charts in written instructions: each crossing is explained once, and a chart shows what the text says."""

from __future__ import annotations

import re

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.hand_knitting import knitting_instructions
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.courses import top_sides
from stitchmesh.patterns import apply_pattern, parse_pattern, pattern_mesh, read_pattern
from stitchmesh.tessellate import tessellate
from tests.gallery import ROOT
from tests.hand_knitting.stitch_charts import chart_fabric

SEVERAL_CABLES = """row 1 RS: p1 c4f p1 c6b p1 c8f c2b
row 2 WS: p23
row 3 RS: p1 k4 p1 k6 p1 k10
row 4 WS: p23"""
CABLE_WORD = re.compile(r"c\d+[fb]|cross \d+/\d+ (?:front|back)|cross to [\d-]+ front to back [\d-]+")


def cable_words(text: str) -> tuple[set[str], list[str]]:
    """Return the words for cables in the rows of a text, and those that its legend explains."""
    lines = text.splitlines()
    rows = [line for line in lines if line.startswith(("Row ", "Round "))]
    legend = lines[lines.index("Words") + 1 : lines.index("", lines.index("Words"))]
    explained = [line.strip().partition(":")[0] for line in legend if CABLE_WORD.match(line.strip())]
    return {word for row in rows for word in CABLE_WORD.findall(row)}, explained


def several_crossings() -> StitchMesh:
    """Return a fabric with crossings of unequal bundles and one whose loops have an order of their own."""
    fabric = chart_fabric([" ".join(["co"] * 9), *[" ".join(["k"] * 9)] * 3])
    sides = top_sides(fabric, np.flatnonzero(fabric.row == 1))
    for name, arguments in (
        ("cross_cable", {"side": sides[0], "left": 1, "right": 2, "front": "left"}),
        ("cross_cable", {"side": sides[3], "left": 2, "right": 1, "front": "left"}),
        ("set_cable", {"side": sides[6], "destinations": [2, 1, 0], "layers": [2, 1, 0]}),
    ):
        fabric = apply_edit(fabric, Edit(name, arguments)).fabric
    return fabric


@pytest.mark.parametrize("name", ["cable-work", "moss-cable"])
def test_each_cable_of_the_library_is_explained_once(name):
    fabric = pattern_mesh(read_pattern(name), 2, 2, stitch_width=1, stitch_height=1)
    used, explained = cable_words(knitting_instructions(fabric))
    assert used and sorted(used) == sorted(explained)


def test_cables_of_several_widths_are_explained_each():
    fabric = pattern_mesh(parse_pattern(SEVERAL_CABLES), 1, 1, stitch_width=1, stitch_height=1)
    text = knitting_instructions(fabric)
    assert cable_words(text) == ({"c2b", "c4f", "c6b", "c8f"}, ["c2b", "c4f", "c6b", "c8f"])
    assert "  c2b: hold the next st in back, knit the following st, then the st held\n" in text
    assert "  c6b: hold the next 3 sts in back, knit the following 3 sts, then the 3 sts held\n" in text
    assert "  c8f: hold the next 4 sts in front, knit the following 4 sts, then the 4 sts held\n" in text


def test_crossings_of_any_form_are_explained_each():
    text = knitting_instructions(several_crossings())
    used, explained = cable_words(text)
    assert len(used) == 3 and sorted(used) == sorted(explained)
    meaning = "hold the next st in back, work the following 2 sts, then the st held, as the next words say"
    assert f"  cross 1/2 back: {meaning}\n" in text
    order = "bring sts 1 to 3 into the order 3-2-1, st 3 in front, behind it 2, behind it 1"
    assert f"  cross to 3-2-1 front to back 3-2-1: {order}; work them as the next words say\n" in text


def test_the_rounds_of_a_chart_are_those_of_the_text():
    """A round with a crossing is a line of its own, although its stitches are knitted like those of the next round."""
    hat = tessellate(label(read_mesh(ROOT / "assets" / "meshes" / "hat.obj")), stitch_width=1.2)
    text = knitting_instructions(apply_pattern(hat, read_pattern("braid-cables")))
    crossed = {int(number) for number in re.findall(r"^Round (\d+):.*c4[fb]", text, re.MULTILINE)}
    charted = set()
    for first, last, repeat, chart in re.findall(
        r"^Chart of stitches, rounds (\d+) to (\d+)(.*):\n((?: {7}.*\n)+)", text, re.MULTILINE
    ):
        height = int(found[1]) if (found := re.search(r"(\d+) rounds", repeat)) else int(last) - int(first) + 1
        lines = [line.split() for line in chart.splitlines()]
        assert [int(number) for _, number in lines] == list(range(int(first) + height - 1, int(first) - 1, -1))
        for symbols, number in lines:
            again = range(int(number), int(last) + 1, height)
            assert {*again} <= crossed if "x" in symbols else not {*again} & crossed
            charted |= {*again}
    assert charted & crossed, "the charts have crossings"


def test_the_symbols_of_a_crossing_say_which_loops_are_in_front():
    """The left bundle comes to the right in front of the others; of three loops in one order, the first is in front."""
    lines = knitting_instructions(several_crossings()).splitlines()
    assert "     2 xx/x//xx/" in lines and "  / knit, crosses to the right in front of the others" in lines
    assert not any(line.startswith("  \\") for line in lines)


def test_charts_of_stitches_and_of_colours_show_one_repeat_of_a_grid():
    rows = [" ".join(["co"] * 6), "k p k p k p", "k k p k k p", "k p k p k p", "k k p k k p", "d12k k k k k"]
    lines = knitting_instructions(chart_fabric(rows)).split("\n")
    first = lines.index("Chart of stitches, rows 1 to 4 (one repeat: 2 rows, 2 times):")
    assert lines[first + 1 : first + 5] == [
        "     2 ..-..-",
        "       .-.-.- 1",
        "  . knit on the right side",
        "  - purl on the right side",
    ]
    fabric = chart_fabric(["co co co co"] + ["k k k k"] * 2, ring=True, yarns=["0000", "0101", "1010"])
    lines = knitting_instructions(fabric).split("\n")
    first = lines.index("Chart of colours, rounds 1 to 2 (one repeat: 2 sts, 2 times):")
    assert lines[first + 1 : first + 3] == ["       BA 2", "       AB 1"]

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One text for several sizes: each size is read back as it would be alone, and lines of some sizes only say so."""

from __future__ import annotations

import pytest

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.hand_knitting import graded_instructions, knitting_instructions, parse_instructions, written_pieces
from stitchmesh.hand_knitting.sizes import check_size_name, instructions_of_size, names_of_sizes
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.patterns import pattern_mesh, read_pattern
from stitchmesh.tessellate import tessellate
from tests.chosen_patterns import CHOSEN_PATTERNS
from tests.gallery import tube


def cylinder(radius: float, height: float) -> StitchMesh:
    """A plain tube of stitches 1 cm wide and high."""
    return tessellate(label(tube(8, 3, radius=radius, height=height / 3)), stitch_width=1.0, stitch_height=1.0)


def check_round_trip(fabrics: dict[str, StitchMesh]) -> str:
    text = graded_instructions(fabrics)
    assert names_of_sizes(text) == tuple(fabrics)
    for name, fabric in fabrics.items():
        assert parse_instructions(text, size=name) == written_pieces(fabric), name
    return text


def test_numbers_that_differ_are_written_once_for_each_size():
    text = check_round_trip({"S": cylinder(5.0, 9.0), "M": cylinder(6.4, 12.0), "L": cylinder(7.6, 9.0)})
    assert "Sizes: S (M, L)." in text
    assert "Cast on 32 (40, 48) sts; join in the round." in text
    assert "Round 1: k32 (40, 48)." in text
    assert "Rounds 2 to 8 (11, 8): as round 1." in text
    assert "only:" not in text


def test_lines_of_some_sizes_name_them():
    flat, ribbed = (pattern_mesh(read_pattern(name), 4, 6, stitch_width=1.0, stitch_height=1.0)
                    for name in ("stockinette", "rib2x2"))  # fmt: skip
    text = check_round_trip({"plain": flat, "ribbed": ribbed, "10 years": flat})
    assert any(line.startswith("Size ribbed only: Row") for line in text.splitlines())
    assert any(line.startswith("Sizes plain (10 years) only: Row") for line in text.splitlines())


def test_sizes_may_have_other_pieces():
    text = check_round_trip({"round": cylinder(5.0, 9.0), "flat": pattern_mesh(
        read_pattern("rib2x2"), 2, 2, stitch_width=1.0, stitch_height=1.0)})  # fmt: skip
    assert "Size round only: Piece 1, worked in rounds" in text
    assert "Size flat only: Piece 1, worked to and fro" in text


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_patterns_of_two_widths_and_heights_are_read_back(name):
    pattern = read_pattern(name)
    check_round_trip({
        size: pattern_mesh(pattern, width, height, stitch_width=1.0, stitch_height=1.0)
        for size, width, height in (("S", 2, 2), ("M", 3, 3), ("L", 4, 2))
    })  # fmt: skip


def test_one_size_reads_as_a_text_without_sizes():
    fabric = cylinder(5.0, 9.0)
    text = graded_instructions({"M": fabric}, ["Yarn: 12 m."])
    assert "Sizes: M." in text and "Yarn: 12 m." in text
    alone = knitting_instructions(fabric, charts=False).partition("Piece 1")[2]
    assert text.partition("Piece 1")[2] == alone


def test_lines_keep_their_numbers():
    text = graded_instructions({"S": cylinder(5.0, 9.0), "M": cylinder(6.4, 12.0)})
    assert len(instructions_of_size(text, "M").splitlines()) == len(text.splitlines())
    damaged = text.replace("Round 1: k32 (40).", "Round 1: k32 (boo).")
    number = damaged.splitlines().index("Round 1: k32 (boo).") + 1
    with pytest.raises(PatternError, match=f"line {number}"):
        parse_instructions(damaged, size="M")


def test_a_size_is_named_if_there_are_sizes():
    text = graded_instructions({"S": cylinder(5.0, 9.0), "M": cylinder(6.4, 12.0)})
    with pytest.raises(PatternError, match="got the sizes S, M; name one of them"):
        parse_instructions(text)
    with pytest.raises(PatternError, match="size 'XL'; expected one of S, M"):
        parse_instructions(text, size="XL")
    with pytest.raises(PatternError, match="of one size only"):
        parse_instructions(knitting_instructions(cylinder(5.0, 9.0)), size="M")
    with pytest.raises(PatternError, match="got sizes S, XS; expected some of S, M"):
        parse_instructions(text + "Sizes S (XS) only: Round 99: k3.\n", size="M")


@pytest.mark.parametrize("name", ["", " S", "S,M", "S (M)", "a/b", "a" * 41, "S: M", "1.5"])
def test_names_that_separate_sizes_or_folders_are_refused(name):
    with pytest.raises(ParameterError, match="size"):
        check_size_name(name)


def test_no_sizes_are_refused():
    with pytest.raises(ParameterError, match="got 0; expected 1 to 30"):
        graded_instructions({})

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Images of tile codes: one pixel for each character when reading and writing; other colours are refused."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from stitchmesh.errors import FileError, PatternError
from stitchmesh.patterns import parse_leaf_codes, parse_pattern, read_leaf_chart, read_pattern, write_leaf_chart
from stitchmesh.patterns.charts.leaf_chart import PALETTE
from tests.gallery import ROOT
from tests.patterns.language.test_leaf_codes import TEXT, WRITTEN


def painted(path, text):
    """Write a PNG of characters that has no palette."""
    pixels = [[PALETTE[character] for character in line] for line in text.splitlines()]
    Image.fromarray(np.array(pixels, dtype=np.uint8)).save(path)


@pytest.mark.parametrize("name", WRITTEN)
def test_round_trip(tmp_path, name):
    pattern = read_pattern(name)
    write_leaf_chart(tmp_path / f"{name}.leaf.png", pattern)
    assert read_pattern(tmp_path / f"{name}.leaf.png").rows == pattern.rows
    assert read_pattern(tmp_path / f"{name}.leaf.png").name == name


def test_a_pixel_is_a_character_and_the_top_row_of_pixels_is_the_last_row(tmp_path):
    painted(tmp_path / "a.png", TEXT)
    assert read_leaf_chart(tmp_path / "a.png") == parse_leaf_codes(TEXT, "a")
    write_leaf_chart(tmp_path / "b.png", parse_leaf_codes(TEXT))
    with Image.open(tmp_path / "a.png") as one, Image.open(tmp_path / "b.png") as other:
        assert np.array_equal(np.asarray(one), np.asarray(other.convert("RGB")))


def test_the_palette_has_a_colour_for_each_character_and_is_documented():
    assert set("".join(TEXT.split())) == set(PALETTE)
    assert len(set(PALETTE.values())) == 9
    document = (ROOT / "docs" / "patterns.md").read_text()
    for character, colour in PALETTE.items():
        assert f"| `{character}` | `#{bytes(colour).hex()}` |" in document


def test_the_message_gives_the_pixel_of_a_colour_without_a_character(tmp_path):
    painted(tmp_path / "a.leaf.png", TEXT)
    with Image.open(tmp_path / "a.leaf.png") as image:
        pixels = np.array(image)
    pixels[0, 2] = 1, 2, 3
    Image.fromarray(pixels).save(tmp_path / "a.leaf.png")
    with pytest.raises(PatternError, match="row 3, stitch 3 from the left: got colour #010203; expected one of the 9"):
        read_pattern(tmp_path / "a.leaf.png")


def test_the_message_gives_the_pixels_of_characters_that_form_no_code(tmp_path):
    painted(tmp_path / "a.leaf.png", "KKK\nK3Y")
    with pytest.raises(PatternError, match=r"a\.leaf\.png: line 2, column 2: got '3Y'; expected one of K P F B YS"):
        read_pattern(tmp_path / "a.leaf.png")


def test_other_files_and_patterns_without_codes_are_refused(tmp_path):
    (tmp_path / "a.leaf.png").write_bytes(b"no picture")
    with pytest.raises(FileError, match="is not a whole PNG"):
        read_pattern(tmp_path / "a.leaf.png")
    with pytest.raises(FileError, match=r"expected one of \.png"):
        write_leaf_chart(tmp_path / "a.jpg", parse_leaf_codes("K"))
    with pytest.raises(PatternError, match="row 1, stitch 1: got y, no tile"):
        write_leaf_chart(tmp_path / "b.leaf.png", parse_pattern("row 1 RS: k2tog yo"))
    assert not (tmp_path / "b.leaf.png").exists()

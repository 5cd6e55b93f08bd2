# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts come from files of every kind and go back; damaged files are refused by one line."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image, PngImagePlugin

from stitchmesh.errors import FileError, PatternError, StitchMeshError
from stitchmesh.patterns import parse_pattern, read_pattern
from stitchmesh.patterns.charts.chart_image import TEXT_KEY
from stitchmesh.patterns.charts.chart_operations import repeat
from stitchmesh.periodic.charts.chart_files import chart_image, chart_of, parse_chart, read_chart, write_chart
from stitchmesh.periodic.charts.chart_picture import LARGEST_SQUARE, LONGEST_SIDE, MARGIN, chart_picture, write_pattern
from stitchmesh.periodic.weave.library import read_weave


@pytest.mark.parametrize("name", ["peerie"])
def test_a_chart_of_colours_is_read_from_its_image(name):
    chart = chart_of(read_pattern(name))
    suffix, content = chart_image(chart)
    again = read_chart(f"a{suffix}", content)
    assert suffix == ".png"
    assert (again.chart.yarns == chart.yarns).all()
    assert again.pattern().rows == read_pattern(name).rows


@pytest.mark.parametrize("name", ["eyelet-lace", "rib2x2"])
def test_other_stitches_are_an_image_of_tile_codes(name):
    chart = parse_chart("KKYS\n2UPP").chart if name == "eyelet-lace" else chart_of(read_pattern(name))
    suffix, content = chart_image(chart)
    assert suffix == ".leaf.png"
    assert read_chart(f"a{suffix}", content).pattern().rows == chart.pattern().rows


@pytest.mark.parametrize("name", ["satin-2x3", "double-plain-stitched"])
def test_a_weave_is_an_image_of_dark_and_light(name):
    weave = read_weave(name)
    suffix, content = chart_image(chart_of(weave))
    assert read_chart(f"a{suffix}", content).pattern().matrix == weave.matrix


def test_an_image_has_no_cables():
    with pytest.raises(PatternError, match="tile codes have none"):
        chart_image(chart_of(read_pattern("rope-cable")))


@pytest.mark.parametrize(
    ("name", "content"),
    [("a.knit", b"chart letters:\nkp\npk"), ("a.weave", b"01\n10"), ("a.txt", b"01\n10"), ("a.leaf", b"KP\nPK"),
     ("a.txt", b'weave "Plain"\n01\n10'), ("a.txt", b"row 1 RS: k p")],
)  # fmt: skip
def test_texts_of_every_kind(name, content):
    written = read_chart(name, content)
    assert written.pattern() == write_chart(written.chart).pattern()


def test_a_text_that_can_be_read_keeps_its_form():
    text = "row 1 RS: k p  # a comment\n"
    assert read_chart("a.knit", text.encode()).text == text
    assert parse_chart("0 1\n1 0", digits_are_weave=True).pattern().matrix == ((0, 1), (1, 0))


@pytest.mark.parametrize(
    ("name", "content"),
    [("a.png", b"no picture"), ("a.png", b""), ("a.knit", b""), ("a.knit", b"\0\1"), ("a.knit", b"row 1 RS: q"),
     ("a.weave", b"01\n1x"), ("a", b"k"), ("../../a.knit", b"chart"), ("a.txt", b"\xff\xfe")],
)  # fmt: skip
def test_damaged_files_are_refused_by_one_line(name, content):
    with pytest.raises(StitchMeshError) as caught:
        read_chart(name, content)
    assert "\n" not in str(caught.value)
    assert "/tmp" not in str(caught.value)


@pytest.mark.parametrize("name", ["rope-cable", "jacquard3", "feather-and-fan", "double-plain-stitched"])
def test_a_picture_with_symbols_holds_its_chart(name):
    source = read_weave(name) if name.startswith("double") else read_pattern(name)
    content = chart_picture(chart_of(source))
    assert content.startswith(b"\x89PNG")
    assert read_chart(f"{name}.chart.png", content).pattern() == source


@pytest.mark.parametrize("suffix", [".knit", ".png"])
def test_a_pattern_is_read_from_the_file_to_which_it_was_written(tmp_path, suffix):
    write_pattern(tmp_path / f"own{suffix}", read_pattern("horseshoe-cable"))
    assert read_pattern(tmp_path / f"own{suffix}") == read_pattern("horseshoe-cable")


def test_a_pattern_is_not_written_to_another_suffix(tmp_path):
    with pytest.raises(FileError, match=r"\.knit"):
        write_pattern(tmp_path / "own.svg", read_pattern("seed"))
    assert not list(tmp_path.iterdir())


def test_a_compressed_text_that_is_far_longer_than_its_picture_is_refused():
    content, text = BytesIO(), PngImagePlugin.PngInfo()
    text.add_text(TEXT_KEY, "K" * 900_000, zip=True)
    Image.fromarray(np.zeros((2, 2, 3), np.uint8)).save(content, "PNG", pnginfo=text)
    with pytest.raises(FileError, match=r"^chart\.png: the text of its chart is too long"):
        read_chart("chart.png", content.getvalue())


def test_the_squares_of_a_picture_have_the_colours_of_their_yarns():
    chart = chart_of(parse_pattern('colours "#102030, #a0b0c0"\nchart colours:\n01\n11'))
    image = np.asarray(Image.open(BytesIO(chart_picture(chart))))
    centres = image[MARGIN + LARGEST_SQUARE // 2 :: LARGEST_SQUARE, MARGIN + LARGEST_SQUARE // 2 :: LARGEST_SQUARE]
    assert centres[:2, :2].tolist() == [[[16, 32, 48], [160, 176, 192]], [[160, 176, 192], [160, 176, 192]]]


def test_the_picture_of_the_largest_chart_is_bounded():
    content = chart_picture(repeat(chart_of(parse_pattern("chart letters:\n" + "kp" * 25)), 500, 1))
    image = Image.open(BytesIO(content))
    assert max(image.size) <= LONGEST_SIDE + 2 * MARGIN
    assert read_chart("a.png", content).chart.shape == (500, 50)

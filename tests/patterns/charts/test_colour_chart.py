# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colour charts: pixels and stitches agree, and images that are not charts are refused."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from stitchmesh.errors import FileError, ParameterError, PatternError
from stitchmesh.patterns import chart_palette, parse_pattern, read_colour_chart, read_pattern, write_colour_chart
from stitchmesh.patterns.language.writing import format_pattern
from tests.gallery import shared

RED, GREEN, BLUE = (255, 0, 0), (0, 255, 0), (0, 0, 255)
TEXT = "chart colours:\n012\n110"


def yarns(pattern):
    return [[cell.yarn for cell in row.cells] for row in pattern.rows]


@pytest.mark.parametrize("name", ["peerie", "lice"])
def test_round_trip(tmp_path, name):
    pattern = read_pattern(name)
    palette = np.array([[250, 240, 230], [10, 20, 130]])
    write_colour_chart(tmp_path / "c.png", pattern, palette)
    assert read_colour_chart(tmp_path / "c.png").rows == pattern.rows
    assert read_colour_chart(tmp_path / "c.png", palette[::-1]).rows != pattern.rows
    np.testing.assert_array_equal(chart_palette(tmp_path / "c.png")[:2], palette)


def test_each_pixel_is_a_stitch_and_the_lowest_row_of_pixels_is_row_one(tmp_path):
    write_colour_chart(tmp_path / "c.png", parse_pattern(TEXT), [RED, GREEN, BLUE])
    with Image.open(tmp_path / "c.png") as image:
        pixels = np.asarray(image.convert("RGB"))
    assert pixels.tolist() == [[list(RED), list(GREEN), list(BLUE)], [list(GREEN), list(GREEN), list(RED)]]
    assert read_pattern(tmp_path / "c.png").rows == parse_pattern(TEXT).rows


def test_colours_without_a_palette_are_numbered_by_first_use(tmp_path):
    image = np.array([[RED, GREEN, BLUE], [GREEN, GREEN, RED]], dtype=np.uint8)
    Image.fromarray(image).save(tmp_path / "c.png")
    assert yarns(read_colour_chart(tmp_path / "c.png")) == [[0, 0, 1], [1, 0, 2]]
    assert chart_palette(tmp_path / "c.png").tolist() == [list(GREEN), list(RED), list(BLUE)]
    assert yarns(read_colour_chart(tmp_path / "c.png", [RED, GREEN, BLUE])) == [[1, 1, 0], [0, 1, 2]]


def test_the_message_gives_the_place_of_a_colour_that_no_yarn_has(tmp_path):
    write_colour_chart(tmp_path / "c.png", parse_pattern(TEXT), [RED, GREEN, BLUE])
    with pytest.raises(PatternError, match="row 2, stitch 3 from the left: got colour #0000ff; expected one of the 2"):
        read_colour_chart(tmp_path / "c.png", [RED, GREEN])


def test_bad_images_are_refused(tmp_path):
    path = tmp_path / "c.png"
    path.write_bytes(b"no picture")
    with pytest.raises(FileError, match="is not a whole PNG"):
        read_colour_chart(path)
    write_colour_chart(path, parse_pattern(TEXT), [RED, GREEN, BLUE])
    path.write_bytes(path.read_bytes()[:-30])
    with pytest.raises(FileError, match="is not a whole PNG"):
        read_colour_chart(path)
    Image.fromarray(np.zeros((2, 2, 3), dtype=np.uint8)).save(path)
    frames = b"acTL" + bytes(8)  # No frame of an animation: the library of images warns of it.
    chunk = struct.pack(">I", 8) + frames + struct.pack(">I", zlib.crc32(frames))
    path.write_bytes(path.read_bytes()[:33] + chunk + path.read_bytes()[33:])
    with pytest.raises(FileError, match="is not a whole PNG"):
        read_colour_chart(path)
    Image.fromarray(np.zeros((2, 2, 4), dtype=np.uint8)).save(path)
    with pytest.raises(FileError, match="transparent pixels"):
        read_colour_chart(path)
    Image.new("1", (3000, 2000)).save(path)
    with pytest.raises(FileError, match="3000 x 2000 pixels"):
        read_colour_chart(path)
    shades = np.stack(np.meshgrid(np.arange(20), np.arange(20), [0]), axis=-1)[:, :, 0].astype(np.uint8)
    Image.fromarray(shades).save(path)
    with pytest.raises(PatternError, match="got 400 colours; expected 256 at most"):
        read_colour_chart(path)
    with pytest.raises(FileError, match=r"expected one of \.png \.gif \.bmp \.tif"):
        read_colour_chart(tmp_path / "c.jpg")
    Image.new("RGB", (2, 2)).save(tmp_path / "c.jpg")
    with pytest.raises(FileError, match="JPG does not keep the colour of each pixel; save the chart as PNG, GIF"):
        read_pattern(tmp_path / "c.jpg")
    pictures = [Image.new("RGB", (2, 2), colour) for colour in (RED, BLUE)]
    pictures[0].save(tmp_path / "c.gif", save_all=True, append_images=pictures[1:])
    with pytest.raises(FileError, match="holds 2 pictures; expected one"):
        read_pattern(tmp_path / "c.gif")
    (tmp_path / "c.bmp").write_bytes(b"no picture")
    with pytest.raises(FileError, match="is not a whole BMP"):
        read_pattern(tmp_path / "c.bmp")
    with pytest.raises(FileError, match="there is no such file"):
        read_colour_chart(tmp_path / "d.png")


@pytest.mark.parametrize(
    ("palette", "found"),
    [([RED], "got 1 colours for yarns 0 to 2"), ([1, 2, 3], r"got shape \(3,\)"), ("red", "expected rows of red"),
     ([RED, GREEN, (0, 0, 256)], "beyond 0 to 255"), ([RED, GREEN, (0, 0, np.nan)], "beyond 0 to 255")],
)  # fmt: skip
def test_bad_palettes_are_refused(tmp_path, palette, found):
    with pytest.raises(ParameterError, match=found):
        write_colour_chart(tmp_path / "c.png", parse_pattern(TEXT), palette)


@pytest.mark.parametrize("row", ["k p", "k | k | k", "k+1", "ktbl"])
def test_only_plain_knit_stitches_make_a_colour_chart(tmp_path, row):
    with pytest.raises(PatternError, match="row 1: holds more than plain knit stitches"):
        write_colour_chart(tmp_path / "c.png", parse_pattern(f"row 1 RS: {row}"), [RED])


def test_a_chart_keeps_its_colours_however_they_are_stored(tmp_path):
    """The first colour from the lower left has number 0, unless the file has a palette of its own."""
    pixels = np.array([[[0, 128, 0], [255, 0, 0]], [[255, 0, 0], [0, 128, 0]]], dtype=np.uint8)
    Image.fromarray(pixels).save(tmp_path / "rgb.png")
    assert read_colour_chart(tmp_path / "rgb.png").palette == ((255, 0, 0), (0, 128, 0))
    pattern = parse_pattern('colours "navy, cream, #aa2233"\nchart colours:\n0122\n2100\n')
    write_colour_chart(tmp_path / "own.png", pattern, pattern.palette)
    read = read_colour_chart(tmp_path / "own.png")
    assert read.palette == pattern.palette and read.rows == pattern.rows
    given = read_colour_chart(tmp_path / "rgb.png", [[0, 128, 0], [255, 0, 0]])
    assert given.palette == ((0, 128, 0), (255, 0, 0))


def test_colours_are_a_statement_of_a_pattern():
    pattern = parse_pattern('colours "navy, #aa2233"\nchart colours:\n01\n')
    assert pattern.palette == ((0, 0, 128), (0xAA, 0x22, 0x33))
    assert parse_pattern(format_pattern(pattern)) == pattern
    with pytest.raises(PatternError, match=r"line 1, column 9: colour: got ' navvy'.*did you mean 'navy'"):
        parse_pattern('colours "red, navvy"\nchart colours:\n01\n')
    with pytest.raises(PatternError, match='expected a text in quotes, such as colours "cream, navy"'):
        parse_pattern("colours red\nchart colours:\n01\n")


def test_digits_alone_in_a_text_file_are_a_chart_of_colours(tmp_path, caplog):
    (tmp_path / "chart.txt").write_text("\n0011\n2100\n")
    pattern = read_pattern(tmp_path / "chart.txt")
    assert pattern.rows == parse_pattern("chart colours:\n0011\n2100\n").rows and pattern.name == "chart"
    assert "chart.txt: read as a chart of yarn colours" in caplog.text
    (tmp_path / "bad.txt").write_text("0011\n210\n")
    with pytest.raises(PatternError, match=r"bad.txt.*line 2.*3 columns where the chart's first line has 4"):
        read_pattern(tmp_path / "bad.txt")


@pytest.mark.parametrize("suffix", [".gif", ".tif"])
def test_every_lossless_image_is_the_same_chart(tmp_path, suffix):
    pixels = np.array([[RED, GREEN, BLUE], [GREEN, GREEN, RED]], dtype=np.uint8)
    Image.fromarray(pixels).save(tmp_path / f"c{suffix}")
    read = read_pattern(tmp_path / f"c{suffix}")
    assert yarns(read) == [[0, 0, 1], [1, 0, 2]] and read.palette == (GREEN, RED, BLUE)


def test_greys_of_16_bits_are_the_nearest_greys_of_8_bits(tmp_path):
    greys = np.array([[0, 257 * 100], [257 * 100, 65535]], dtype=np.uint16)
    Image.fromarray(greys).save(tmp_path / "c.png")
    read = read_pattern(tmp_path / "c.png")
    assert yarns(read) == [[0, 1], [2, 0]] and read.palette == ((100, 100, 100), (255, 255, 255), (0, 0, 0))


def test_instructions_that_people_write_are_refused_in_a_line_that_says_what_is_read():
    with pytest.raises(PatternError, match=r"line 1: got '\(RS\)', as in instructions that people write; expected the"):
        read_pattern(shared("cases/field/11-knitspeak.txt"))

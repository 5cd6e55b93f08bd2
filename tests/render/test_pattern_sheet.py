# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A pattern to take home states the measures, the yarn and the rows of its fabric, and is written as a PDF."""

from __future__ import annotations

import re
import zlib
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.hand_knitting import knitting_instructions
from stitchmesh.patterns import apply_pattern, parse_pattern, read_pattern
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.periodic.weave.library import read_weave
from stitchmesh.quality import quality_named
from stitchmesh.render.pattern_sheet import PatternSheet, garment_sheet, swatch_sheet, write_pattern_sheet
from stitchmesh.yarn.yarn_presets import Gauge, Yarn
from stitchmesh.yarngen import generate_yarns
from tests.editing.fabrics import around, flat

FABRIC = apply_pattern(around(12, 7), parse_pattern('colours "cream, navy"\nchart colours:\n0001\n0011\n'))
"""A tube of 12 stitches 1 cm wide and 7 rows 0.72 cm high."""


def facts_of(sheet: PatternSheet) -> dict[str, str]:
    return dict(sheet.facts)


def test_measures_are_those_of_the_fabric():
    """The tube is a polygon of 12 sides, so that its circumference is 12 times the side of its stitches."""
    sheet = garment_sheet(FABRIC, title="Tube")
    side = float(FABRIC.side_length[~FABRIC.is_wale].mean())
    around_it = f"{12 * side:.3g} cm ({12 * side / 2.54:.3g} in)"
    high = f"{7 * 0.72:.3g} cm ({7 * 0.72 / 2.54:.3g} in) high"
    assert facts_of(sheet)["Piece 1"] == f"{around_it} around at the first row, {around_it} at most, {high}"
    assert facts_of(sheet)["Stitches"] == "84 in 7 rows"
    flat_piece = facts_of(garment_sheet(flat(7, 6), title="Flat"))
    assert flat_piece["Piece 1"].startswith("7 cm (2.76 in) wide at the first row")
    stated = [part.split() for part in facts_of(sheet)["Finished size"].split(", ")]
    assert [words[-1] for words in stated] == ["wide", "high", "deep"]
    assert [float(words[0]) for words in stated] == pytest.approx(np.ptp(FABRIC.vertices, axis=0), rel=5e-3)  # 3 digits
    assert flat_piece["Finished size"] == "7 cm (2.76 in) wide, 4.32 cm (1.7 in) high"  # no thickness


def test_all_yarn_is_counted_once_by_colour():
    yarns, dk = generate_yarns(FABRIC), Yarn.named("dk")
    sheet = garment_sheet(FABRIC, yarns, title="Tube", yarn=dk)
    assert [(one.letter, one.colour) for one in sheet.amounts] == [("A", "#ece2ce"), ("B", "#000080")]
    metres = sum(one.metres for one in sheet.amounts)
    assert metres == pytest.approx(yarns.lengths.sum() / 100.0, rel=1e-12)  # sums of doubles in another order
    assert sum(one.grams for one in sheet.amounts) == pytest.approx(metres * dk.grams_per_metre, rel=1e-12)
    assert facts_of(sheet)["Needle"].startswith("3.75 to 4.5 mm")


def test_charts_and_text_are_those_of_the_written_instructions():
    sheet = garment_sheet(FABRIC, title="Tube")
    (chart,) = sheet.charts
    assert chart.symbols == (("A", "A", "B", "B"), ("A", "A", "A", "B")) and chart.rows == (1, 2)
    text = knitting_instructions(FABRIC)
    assert "\n".join(chart.lines()) in text and sheet.text in text.replace("\n".join([*chart.lines(), ""]), "")


def pdf_text(content: bytes) -> str:
    """The drawing operators of a PDF, uncompressed."""
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", content, flags=re.DOTALL)
    return b"\n".join(zlib.decompress(part) for part in streams if part[:1] == b"x").decode("latin-1")


def pages_of(content: bytes) -> int:
    return content.count(b"/Type /Page\n") + content.count(b"/Type /Page ")


def test_a_swatch_is_one_page_with_its_rows_in_words(tmp_path):
    source = read_pattern("peerie")
    _fabric, yarns = draw_swatch(source, SwatchOptions(), quality_named("draft"))
    sheet = swatch_sheet(source, yarns, Gauge(20.0, 24.0))
    assert "Row 1 (RS): A: k3, B: k1, A: k2." in sheet.text and "chart colours" not in sheet.text
    write_pattern_sheet(tmp_path / "swatch.pdf", sheet)
    assert pages_of((tmp_path / "swatch.pdf").read_bytes()) == 1
    lasting = swatch_sheet(read_weave("plain"), yarns, Gauge(20.0, 24.0))
    assert lasting.text.startswith("weave")


def test_the_same_pattern_is_the_same_pdf(tmp_path):
    picture = BytesIO()
    Image.fromarray(np.full((20, 30, 3), 120, dtype=np.uint8)).save(picture, format="PNG")
    sheet = garment_sheet(FABRIC, title="Tube of $5 & more", picture=picture.getvalue())
    for name in ("one.pdf", "two.pdf"):
        write_pattern_sheet(tmp_path / name, sheet)
    content = (tmp_path / "one.pdf").read_bytes()
    assert content.startswith(b"%PDF-") and content == (tmp_path / "two.pdf").read_bytes()
    assert pages_of(content) == 2  # facts and charts, and the text
    assert "0 0 0.501960" in pdf_text(content)  # the navy of the chart and of the yarn


def test_a_picture_that_is_none_and_another_suffix_are_refused(tmp_path):
    with pytest.raises(ParameterError, match="picture: is not a whole PNG"):
        write_pattern_sheet(tmp_path / "a.pdf", garment_sheet(FABRIC, title="Tube", picture=b"no picture"))
    assert not (tmp_path / "a.pdf").exists()
    with pytest.raises(FileError, match=r"\.pdf"):
        write_pattern_sheet(tmp_path / "a.txt", garment_sheet(FABRIC, title="Tube"))

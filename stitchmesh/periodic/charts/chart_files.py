# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts of knits and weaves as they are edited: made from patterns, texts and files, and written back."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from stitchmesh.io.atomic import temporary_file
from stitchmesh.mesh.palette import filled_palette
from stitchmesh.patterns import Pattern
from stitchmesh.patterns.charts.chart_image import CHART_IMAGES, picture_text, png_of_numbers
from stitchmesh.patterns.charts.knit_chart import PLAIN, KnitChart, knit_chart
from stitchmesh.patterns.charts.knit_chart_text import KnitChartText, parse_knit_chart, write_knit_chart
from stitchmesh.patterns.charts.leaf_chart import SUFFIX as LEAF_SUFFIX
from stitchmesh.patterns.charts.leaf_chart import leaf_image
from stitchmesh.patterns.language.parse import begins_with_statement
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern, states_a_weave
from stitchmesh.periodic.weave.library import SUFFIX as WEAVE_SUFFIX
from stitchmesh.periodic.weave.library import weave_image
from stitchmesh.periodic.weave.weave_chart import (
    WeaveChart,
    WeaveChartText,
    parse_weave_chart,
    weave_chart,
    write_weave_chart,
)

Chart = KnitChart | WeaveChart
ChartText = KnitChartText | WeaveChartText
CHART_SUFFIXES = (".knit", ".weave", ".wif", ".leaf", ".txt", *CHART_IMAGES)
"""Suffixes of files that hold charts."""
_UNSAFE = re.compile(r"[^\w. -]")


def chart_of(source: Source) -> Chart:
    """Return the chart of a pattern or of a weave.

    Raises:
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    return knit_chart(source) if isinstance(source, Pattern) else weave_chart(source)


def write_chart(chart: Chart) -> ChartText:
    """Write a chart as text that ``parse_chart`` reads."""
    return write_knit_chart(chart) if isinstance(chart, KnitChart) else write_weave_chart(chart)


def parse_chart(text: str, name: str = "chart", *, digits_are_weave: bool = False) -> ChartText:
    """Read the chart of a knit or of a weave from a text, whether or not its rows fit together.

    Args:
        text: a text in the language of patterns or of weaves, or lines of codes or digits alone.
        name: the name of the text in messages, and of the chart if the text gives none.
        digits_are_weave: whether a text without a statement is a weave.

    Raises:
        PatternError: the text cannot be read; the message gives the line and the column.
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    if begins_with_statement(text) and not states_a_weave(text.splitlines()):
        return parse_knit_chart(text, name)
    if digits_are_weave or states_a_weave(text.splitlines()):
        return parse_weave_chart(text, name)
    return parse_knit_chart(text, name)


def read_chart(name: str, content: bytes) -> ChartText:
    """Read a chart from the content of a file.

    Args:
        name: the name of the file, with a suffix of ``CHART_SUFFIXES``.
        content: the content of the file; a picture from ``chart_picture`` holds its chart.

    Raises:
        FileError: the content is empty, damaged or no text.
        PatternError: the file describes no pattern and no weave.
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    # Number of characters of the name of a file that messages show
    own = _UNSAFE.sub("-", Path(name).name)[-80:].lstrip(".") or "chart"
    if own.lower().endswith((".knit", ".weave")) and content and b"\0" not in content:
        text = content.decode("utf-8-sig", errors="replace")
        return parse_chart(text, own, digits_are_weave=own.lower().endswith(WEAVE_SUFFIX))
    held = picture_text(own, content)
    if held is not None:
        return parse_chart(held, own)
    with temporary_file(own, content) as path:
        return write_chart(chart_of(resolve_pattern(path)))


def chart_image(chart: Chart) -> tuple[str, bytes]:
    """Return a chart as the name and the content of a PNG with one pixel for each square.

    Knit stitches in several yarns make a chart of colours, other stitches with tile codes a chart of these codes, and
    weaves a matrix of dark and light.

    Returns:
        The suffix that the name of the file needs, and the content.

    Raises:
        PatternError: the chart holds stitches that have no tile code, or its rows do not fit together.
    """
    if isinstance(chart, WeaveChart):
        return f"{WEAVE_SUFFIX}.png", weave_image(chart.squares)
    if {chart.words[number] for number in np.unique(chart.squares)} == {PLAIN}:
        palette = np.array(chart.palette, dtype=np.uint8).reshape(-1, 3)
        return ".png", png_of_numbers(chart.yarns[::-1], filled_palette(palette, chart.yarn_count))
    return LEAF_SUFFIX, leaf_image(chart.pattern())

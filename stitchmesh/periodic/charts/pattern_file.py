# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns as files that ``read_pattern`` reads: text, or the picture of a chart."""

from __future__ import annotations

from stitchmesh.errors import check_kind
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.patterns import Pattern, format_pattern
from stitchmesh.patterns.charts.knit_chart import knit_chart
from stitchmesh.periodic.charts.chart_picture import chart_picture

TEXT_SUFFIX, PICTURE_SUFFIX = ".knit", ".png"


def pattern_content(pattern: Pattern, suffix: str) -> bytes:
    """Return the content of the file of a pattern.

    Args:
        pattern: the pattern.
        suffix: ``.knit`` for text, or ``.png`` for a picture of its chart, which holds the text too.

    Raises:
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    return format_pattern(pattern).encode() if suffix == TEXT_SUFFIX else chart_picture(knit_chart(pattern))


def write_pattern(path: FilePath, pattern: Pattern) -> None:
    """Write a pattern as text (``.knit``), or as the picture of its chart with its text (``.png``).

    ``read_pattern`` reads both. The file is written atomically.

    Raises:
        FileError: the file has another suffix, or it cannot be written.
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    check_kind("write_pattern", pattern, Pattern)
    write_bytes(path, pattern_content(pattern, suffix_of(path, (TEXT_SUFFIX, PICTURE_SUFFIX))))

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Random charts are patterns that close, and always the same ones."""

from __future__ import annotations

import pytest

from benchmarks.scenes import random_charts as charts
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS

MOST = 160
"""Stitches of the largest chart that the benchmark promises: eight by eight, knitted twice, and ten by sixteen."""


@pytest.mark.parametrize("number", range(4))
def test_a_chart_closes_and_has_knit_and_purl_stitches(number: int) -> None:
    chart = charts.random_chart(number)
    fabric, _yarns = draw_swatch(chart, SwatchOptions(), PRESETS["draft"])
    assert fabric is not None
    assert fabric.face_count <= MOST
    words = charts.chart_text(number).lower().split("\n", 1)[1]
    assert {"k", "p"} <= set(words)


def test_charts_are_always_the_same_and_differ_from_each_other() -> None:
    texts = [charts.chart_text(number).split("\n", 1)[1] for number in range(16)]
    assert texts == [charts.chart_text(number).split("\n", 1)[1] for number in range(16)]
    assert len(set(texts)) > 8  # small welts and ropes repeat

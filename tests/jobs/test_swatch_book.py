# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A swatch book holds what its swatches have: centre lines, measures, and files that read back."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError
from stitchmesh.jobs.book.leaf import SAMPLES, figures_of
from stitchmesh.jobs.sweep.result_table import read_table
from stitchmesh.yarn.polyline import polylines_of_segments

BOOK = sm.SwatchBook(
    patterns=("rib1x1", "stockinette", "plain"), relaxation="frictionless", device="cpu", stretched=False
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a book of three patterns."""
    made = tmp_path_factory.mktemp("book") / "library"
    page = sm.write_book(BOOK, made, workers=0, progress=False)
    assert page == made / "index.html"
    return made


def leaf(folder: Path, name: str) -> dict[str, Any]:
    text = (folder / "leaves" / f"{name}.js").read_text(encoding="utf-8")
    assert text.startswith("show(") and text.endswith(");\n")
    content: dict[str, Any] = json.loads(text[len("show(") : -len(");\n")])
    return content


def test_the_centre_lines_of_a_leaf_are_those_of_the_swatch(folder: Path) -> None:
    table = read_table(folder / "swatches")
    for name, file in zip(table["swatch.pattern"], table["yarns_file"], strict=True):
        yarns, fabric = sm.read_yarns(folder / "swatches" / file), leaf(folder, name)["fabric"]
        steps = np.frombuffer(base64.b64decode(fabric["points"]), dtype="<i2").reshape(-1, 3)
        points = np.array(fabric["middle"]) + np.array(fabric["half"]) * steps / 32_767
        curves = polylines_of_segments(yarns, np.arange(len(yarns.segment_points)), SAMPLES)
        # half a step of 16 bits, and six digits of the middle and of the half of a box of at most 4 cm
        np.testing.assert_allclose(points, np.concatenate(curves.points), rtol=0.0, atol=0.5 * 2.0 / 32_767 + 2e-5)
        assert fabric["counts"] == [len(curve) for curve in curves.points]


def test_the_files_of_a_leaf_are_there_and_read_back(folder: Path) -> None:
    for name in BOOK.patterns:
        for path in leaf(folder, name)["files"]:
            assert (folder / path).is_file()
    assert sm.read_pattern(folder / "files" / "rib1x1.knit").width == 2
    one, fabric = (sm.read_yarns(folder / "files" / f"plain.{suffix}") for suffix in ("h5", "bcc"))
    across, up = leaf(folder, "plain")["fabric"]["tiles"]
    assert one.lattice is not None and one.yarn_count == 4 and fabric.yarn_count == 2 * (across + up)
    picture = folder / "charts" / "rib1x1.png"
    text = sm.write_chart(sm.chart_of(sm.read_pattern("rib1x1"))).text
    assert sm.write_chart(sm.read_chart(picture.name, picture.read_bytes()).chart).text == text


def test_the_width_stands_beside_stockinette_in_the_leaves_of_knits(folder: Path) -> None:
    table = read_table(folder / "swatches")
    spacing = dict(zip(table["swatch.pattern"], table["wale_spacing"], strict=True))
    figures = {name: dict(leaf(folder, name)["figures"]) for name in BOOK.patterns}
    shown = float(figures["rib1x1"]["Width beside stockinette"])
    assert shown == pytest.approx(spacing["rib1x1"] / spacing["stockinette"], abs=0.005)  # two digits are shown
    assert "Width beside stockinette" not in figures["plain"]


def test_a_swatch_that_is_not_at_rest_says_so() -> None:
    row = {"wales": 1, "courses": 2, "width": 1.0, "height": 1.0, "gauge.stitches": 20.0, "gauge.rows": 28.0,
           "thickness": 0.3, "areal_density": 0.03, "loop_length": 1.5, "residual": 0.05,
           "stretch_wale.strain": [0.0, 0.2], "stretch_wale.tension": [0.0, 5000.0]}  # fmt: skip
    assert ("Rest", "not at rest, residual 0.05") in figures_of(row | {"converged": False}, None)
    # 5,000 dyn/cm are 5 N/m
    assert figures_of(row | {"converged": True}, None)[-1] == ("Drawn 20 % along the wales", "5 N/m")


@pytest.mark.parametrize(
    ("names", "message"),
    [(("ribb1x1",), "did you mean rib1x1"), (("../away.knit",), "got the path '../away.knit'"),
     (("seed", "rib1x1", "seed"), "'seed': is given twice")],
)  # fmt: skip
def test_names_that_the_library_does_not_have_once_are_refused(names: tuple[str, ...], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        sm.SwatchBook(patterns=names)

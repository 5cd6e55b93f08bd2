# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Swatches that come to a size: they have it, and the loop length that was found gives it again."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.periodic.swatch import swatch
from stitchmesh.periodic.swatch_to import LOOSENESS, TRUE, swatch_to
from stitchmesh.yarn.yarn_presets import Yarn, needle_for, yarn_names
from stitchmesh.yarnrelax import YarnMaterial

QUICK: dict[str, Any] = {"quality": "draft", "device": "cpu", "progress": False, "relaxation": "frictionless"}


def test_a_free_yarn_meets_stitches_and_rows_and_the_found_lengths_give_them_again() -> None:
    made = swatch_to("stockinette", gauge="22x30", **QUICK)
    assert max(map(abs, made.errors.values())) <= TRUE and not made.notes
    again = swatch(
        "stockinette", loop_length=made.loop_length, yarn_radius=made.yarn_radius, relax_cell=True, **QUICK
    )
    # Stockinette has one state of rest; both ways there end at a residual that leaves less than half a percent.
    assert again.report["gauge"] == pytest.approx(made.swatch.report["gauge"], rel=0.005)


def test_size_scales_with_the_yarn_that_is_found() -> None:
    fine, coarse = (swatch_to("stockinette", gauge=stitches, **QUICK) for stitches in (40, 20))
    # One stitch width decides the radius alone, and fabrics of one looseness are similar; both searches end within
    # half a percent.
    assert coarse.yarn_radius / fine.yarn_radius == pytest.approx(2.0, rel=TRUE)


def test_a_piece_of_a_given_yarn_has_whole_repeats_and_the_width() -> None:
    made = swatch_to("rib1x1", yarn="dk", width=30.0, height=20.0, **QUICK)
    report = made.swatch.report
    assert made.stitches % report["wales"] == 0 and made.rows % report["courses"] == 0
    assert made.size == pytest.approx((made.repeats[0] * report["width"], made.repeats[1] * report["height"]))
    assert abs(made.errors["width"]) <= TRUE and made.yarn_radius == Yarn.named("dk").core_radius
    # The height is met by whole repeats, so that it misses by half a repeat at most.
    assert abs(made.size[1] - 20.0) <= report["height"] / 2.0


def test_rows_that_a_yarn_cannot_have_beside_the_stitches_are_said() -> None:
    made = swatch_to("stockinette", yarn="dk", gauge="22x60", **QUICK)
    assert abs(made.errors["stitches"]) <= TRUE
    (note,) = made.notes
    assert note.startswith("rows 60: reached") and "leave the yarn out" in note


@pytest.mark.parametrize(
    ("pattern", "arguments", "message"),
    [
        ("stockinette", {}, "got no size; expected a gauge, a width or a height"),
        ("stockinette", {"width": -1.0}, "width"),
        ("stockinette", {"gauge": 22, "loop_length": 1.0}, "got loop_length, which follows from the size"),
        ("plain", {"width": 10.0}, "got the weave"),
        ("stockinette", {"gauge": 90, "yarn": "dk"}, f"with the shortest loop, {LOOSENESS[0]:g} yarn diameters"),
    ],
)
def test_what_has_no_size_is_refused(pattern: str, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        swatch_to(pattern, **QUICK, **arguments)


@pytest.mark.parametrize("pattern", ["stockinette", "plain"])
def test_a_swatch_of_a_yarn_has_its_sizes_and_its_material(pattern: str) -> None:
    yarn = Yarn.named("cotton-28-tex")
    given = {"yarn_radius": yarn.core_radius, "mass_per_length": yarn.mass_per_length}
    if pattern == "stockinette":
        given |= {"loop_length": yarn.gauge.loop_length, "drawn_radius": yarn.apparent_radius}
    state = {} if pattern == "plain" else {"relaxation": "frictionless"}
    kept: dict[str, Any] = {"quality": "draft", "device": "cpu", "progress": False, "relax_cell": True} | state
    made = swatch(pattern, yarn=yarn.name, **kept)
    by_hand = swatch(pattern, material=YarnMaterial.of_yarn(yarn), **given, **kept)
    np.testing.assert_array_equal(made.yarns.points, by_hand.yarns.points)
    np.testing.assert_array_equal(made.yarns.drawn_radius, by_hand.yarns.drawn_radius)
    assert made.yarns.made_of == yarn and by_hand.yarns.made_of is None
    loose = swatch(pattern, yarn=yarn, gamma=0.9, **kept)  # Other options stay the caller's.
    assert loose.report["width"] > made.report["width"]


def test_a_named_yarn_is_knitted_on_its_usual_needle() -> None:
    yarns = [Yarn.named(name) for name in yarn_names()]
    found = [needle_for(yarn.loop_length) for yarn in yarns]
    assert found == pytest.approx([np.mean(yarn.needle) for yarn in yarns])
    # Beyond the table the needle is proportional to the loop length.
    assert needle_for(2.0 * yarns[-1].loop_length) == pytest.approx(2.0 * found[-1])

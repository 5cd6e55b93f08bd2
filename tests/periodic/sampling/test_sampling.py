# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""All qualities of a free swatch come to one state, and keep what they promise of its spacings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.periodic.sampling.sampling import path_to, refined
from stitchmesh.periodic.swatch import swatch
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import RelaxCell
from tests.nightly import at_night
from tests.periodic.free_cells import FREE, free_swatch

PROMISE = {"draft": 0.05, "standard": 0.01}
"""Largest relative error of the spacings."""


def sizes(pattern: str, quality: str) -> tuple[float, float]:
    report = free_swatch(pattern, quality).report
    assert report["converged"]
    return report["width"], report["height"]


@pytest.mark.parametrize("quality", ["draft", "standard"])
@pytest.mark.parametrize("pattern", ["plain", *at_night("linen-stitch", "garter")])
def test_each_quality_keeps_its_promise(pattern: str, quality: str) -> None:
    np.testing.assert_allclose(sizes(pattern, quality), sizes(pattern, "reference"), rtol=PROMISE[quality])


@pytest.mark.decides
@pytest.mark.usefixtures("first_state")
@pytest.mark.parametrize(
    ("pattern", "loop"), [("rib1x1", 20.0), *at_night(("cartridge-belt-rib", 20.0), ("slip-stitch-honeycomb", 16.67))]
)
def test_qualities_find_one_state_of_several(pattern: str, loop: float) -> None:
    """The loop lengths, in yarn diameters, are those of repeats with several states of rest."""
    draft, standard = (
        swatch(pattern, quality=quality, device="cpu", **FREE, loop_length=2 * loop * 0.125).report
        for quality in ("draft", "standard")
    )
    assert draft["converged"] and standard["converged"]
    for name in ("width", "height"):
        # the promise of draft, and that of standard on the other side
        assert draft[name] == pytest.approx(standard[name], rel=PROMISE["draft"] + PROMISE["standard"])


def test_the_path_to_a_finer_preset_goes_through_the_coarser_ones() -> None:
    cell = RelaxCell()
    paths = [path_to(quality, cell) for quality in PRESETS.values()]
    assert [len(path) for path in paths] == [1, 2, 3]
    for path, preset in zip(paths, PRESETS.values(), strict=True):
        assert path[:-1] == paths[-1][: len(path) - 1] and path[-1] == refined(preset)
    points = [quality.control_points_per_stitch for quality in paths[-1]]
    assert points == sorted(points)


def test_a_repeat_of_constant_size_has_the_given_quality_alone() -> None:
    for cell in (None, RelaxCell(None, None, shear=False)):
        assert path_to(PRESETS["standard"], cell) == (PRESETS["standard"],)


def test_a_limit_of_iterations_holds_on_the_whole_path() -> None:
    short = replace(PRESETS["reference"], max_iterations=40)
    assert {quality.max_iterations for quality in path_to(short, RelaxCell())} == {40}

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stiffness of a yarn is a property of the yarn, and does not depend on the number of its control points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.periodic.stretch import StretchPath, stretch_test
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, yarn_energies


def test_a_weave_of_four_times_as_many_control_points_pulls_as_much() -> None:
    """With a stiffness for each segment, it would pull four times as much."""
    path = StretchPath(course=(0.0, 0.2), other="held", steps=3)
    coarse, fine = (
        stretch_test("plain", path, quality=replace(PRESETS["standard"], control_points_per_stitch=count), device="cpu")
        for count in (24, 96)
    )
    # the bar is 3 %; splines of 24 control points are 0.1 % off
    np.testing.assert_allclose(coarse.tension[1:], fine.tension[1:], rtol=0.01)


@pytest.mark.parametrize("scale", [0.1, 1.0, 7.0])
def test_the_coefficients_of_the_papers_are_the_energy_of_one_of_their_segments(scale: float) -> None:
    material = YarnMaterial.named("leaf").scaled(scale)
    length, stretch = material.segment_length, 1.01
    line = [[stretch * length * k, 0.0, 0.0] for k in range(4)]
    yarns = YarnSet.from_curves([np.array(line)], closed=[False], radius=0.1 * length, rest_lengths=[[length]])
    energies = yarn_energies(yarns, material)
    # rounding of the coordinates over the strain
    assert energies["stretch"] == pytest.approx(2000.0 * 0.01**2, rel=1e-9)
    assert energies["length"] == pytest.approx(1000.0 * 0.01**2, rel=1e-9)

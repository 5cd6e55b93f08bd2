# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A checkpoint shows the yarns where the relaxation left them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.quality import PRESETS
from stitchmesh.run import Checkpoints, Run
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.checkpoint_yarns import checkpoint_yarns
from tests.yarnrelax.stockinette import flat_patch


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """Yarns, where a relaxation of a few iterations left them, and its folder."""
    folder = tmp_path_factory.mktemp("stopped")
    yarns = flat_patch(3, 3)
    quality = replace(PRESETS["draft"], max_iterations=40)
    relaxed = relax_yarns(
        yarns, material=YarnMaterial.named(), quality=quality, device="cpu", run=Run(checkpoints=Checkpoints(folder, 1))
    )
    return yarns, relaxed.yarns, folder


def test_the_yarns_of_a_checkpoint_are_those_of_the_relaxation(stopped):
    given, relaxed, folder = stopped
    found = checkpoint_yarns(folder / "checkpoint.smc", relaxed)
    # the solver keeps positions in single precision, in radii
    np.testing.assert_allclose(found.points, relaxed.points, atol=1e-5)
    assert np.abs(relaxed.points - given.points).max() > 1e-3  # the relaxation has moved them
    shape = checkpoint_yarns(folder / "checkpoint.smc", given).points  # any positions of the yarns will do
    np.testing.assert_allclose(shape - shape.mean(axis=0), relaxed.points - relaxed.points.mean(axis=0), atol=1e-5)


def test_a_checkpoint_of_other_yarns_is_refused(stopped):
    _, _, folder = stopped
    with pytest.raises(FileError, match=r"holds 108 control points; expected the 144 of the yarns in the same folder"):
        checkpoint_yarns(folder / "checkpoint.smc", flat_patch(4, 3))

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a relaxation does not obey of its run, it refuses."""

from __future__ import annotations

from typing import Any

import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError
from stitchmesh.quality import PRESETS
from tests.yarnrelax.stockinette import periodic_patch


def relaxed_mesh(run: sm.Run[Any]) -> object:
    mesh = sm.read_mesh("swatch")
    return sm.relax_mesh(sm.tessellate(sm.label(mesh), stitch_width=1.0), surface=mesh, run=run).fabric


def relaxed_outline(run: sm.Run[Any]) -> object:
    return sm.natural_outline("garter", columns=2, rows=2, run=run)


def relaxed_in_steps(run: sm.Run[Any]) -> object:
    return sm.relax_through_steps(
        periodic_patch(1, 1), [sm.LoadStep()], terms=[sm.Friction(0.2)], material=sm.YarnMaterial.named(),
        quality=PRESETS["draft"], cell=sm.RelaxCell(), device="cpu", run=run,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("relax", "run", "name"),
    [
        (relaxed_mesh, sm.Run(resume="checkpoint.smc"), "resume"),
        (relaxed_outline, sm.Run(on_state=print), "on_state"),
        (relaxed_in_steps, sm.Run(control=sm.RunControl()), "control"),
    ],
)
def test_what_a_relaxation_does_not_obey_is_refused(relax, run, name):
    with pytest.raises(ParameterError, match=f"run: got {name}, which it does not obey; leave it out"):
        relax(run)

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which functions that relax and examine yarns are called for many computations together (``asking_together``)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stitchmesh.compute.asking_together import Together
from stitchmesh.yarnrelax.cell_stress import cell_stress
from stitchmesh.yarnrelax.linking.certificate import refuse_pull_through
from stitchmesh.yarnrelax.load_steps import relax_through_steps
from stitchmesh.yarnrelax.relax import relax_yarns
from stitchmesh.yarnrelax.relax_partly import relax_partly
from stitchmesh.yarnrelax.together.relax_together import (
    cell_stresses_together,
    refuse_pull_through_together,
    relax_partly_together,
    relax_through_steps_together,
    relax_together,
)


def ways_together() -> dict[Callable[..., Any], Together]:
    """How calls are answered together, the shortest work first."""
    return {
        cell_stress: cell_stresses_together,
        refuse_pull_through: refuse_pull_through_together,
        relax_partly: relax_partly_together,
        relax_yarns: relax_together,
        relax_through_steps: relax_through_steps_together,
    }

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Physical relaxation of yarns (Leaf 2018, section 3; Yuksel 2012, section 6.3)."""

from stitchmesh.yarnrelax.cell import RelaxCell
from stitchmesh.yarnrelax.energies import yarn_energies, yarn_forces
from stitchmesh.yarnrelax.linking import linking_certificate
from stitchmesh.yarnrelax.material import REFERENCE_RADIUS, YarnMaterial
from stitchmesh.yarnrelax.solver import Relaxation, relax_yarns

__all__ = [
    "REFERENCE_RADIUS",
    "RelaxCell",
    "Relaxation",
    "YarnMaterial",
    "linking_certificate",
    "relax_yarns",
    "yarn_energies",
    "yarn_forces",
]

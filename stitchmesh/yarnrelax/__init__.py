# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Physical relaxation of yarns (Leaf 2018, section 3; Yuksel 2012, section 6.3)."""

from stitchmesh.yarnrelax.evaluate import yarn_energies, yarn_forces
from stitchmesh.yarnrelax.linking.certificate import linking_certificate
from stitchmesh.yarnrelax.model.material import REFERENCE_RADIUS, YarnMaterial
from stitchmesh.yarnrelax.relax import Relaxation, relax_yarns
from stitchmesh.yarnrelax.relax_cells import RelaxedCell, RelaxedCells, relax_cells
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

__all__ = [
    "REFERENCE_RADIUS",
    "RelaxCell",
    "Relaxation",
    "RelaxedCell",
    "RelaxedCells",
    "YarnMaterial",
    "linking_certificate",
    "relax_cells",
    "relax_yarns",
    "yarn_energies",
    "yarn_forces",
]

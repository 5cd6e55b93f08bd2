# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from .evaluate import yarn_energies as yarn_energies
from .evaluate import yarn_forces as yarn_forces
from .model.material import REFERENCE_RADIUS as REFERENCE_RADIUS
from .model.material import YarnMaterial as YarnMaterial
from .relax import relax_yarns as relax_yarns
from .relaxation_result import Relaxation as Relaxation
from .solvers.cell_strain import RelaxCell as RelaxCell
from .together.cell_batch import RelaxedCell as RelaxedCell
from .together.relax_cells import RelaxedCells as RelaxedCells

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from .options import MeshRelaxOptions as MeshRelaxOptions
from .relax import RelaxedMesh as RelaxedMesh
from .relax import relax_mesh as relax_mesh
from .relax import relax_mesh_around_edit as relax_mesh_around_edit
from .report import MeshRelaxReport as MeshRelaxReport

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from .options import MeshRelaxOptions as MeshRelaxOptions
from .relax import MeshRelaxReport as MeshRelaxReport
from .relax import relax_mesh as relax_mesh
from .relax import relax_mesh_with_report as relax_mesh_with_report

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from .meshes import read_mesh as read_mesh
from .meshes import write_mesh as write_mesh
from .stitches import read_stitches as read_stitches
from .stitches import write_stitches as write_stitches
from .yarns import read_yarns as read_yarns
from .yarns import write_yarns as write_yarns

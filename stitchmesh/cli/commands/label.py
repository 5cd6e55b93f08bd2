# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``label``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import help_entry
from stitchmesh.cli.options import Rows, Unit
from stitchmesh.io.units import DEFAULT_UNIT


@dataclass(frozen=True)
class Label:
    """Find the knitting rows of a polygon mesh."""

    mesh: Annotated[Positional[str], help_entry("MESH")]
    """polygon mesh: OBJ, PLY, OFF, STL, VTK ..."""
    output: Annotated[str, help_entry("FILE", short="-o")]
    """labeled mesh: .h5 or .smobj"""
    unit: Unit = DEFAULT_UNIT
    rows: Rows = field(default_factory=Rows)

    def run(self) -> None:
        """Find rows and wale directions, and write the labeled mesh."""
        from stitchmesh.io import read_mesh, write_stitches
        from stitchmesh.labeling import label

        mesh = read_mesh(self.mesh, unit=self.unit)
        labeled = label(mesh, seeds=self.rows.seed, flip=self.rows.flip)
        write_stitches(self.output, labeled)
        print(f"{labeled.row.max() + 1} rows of {labeled.face_count} faces")

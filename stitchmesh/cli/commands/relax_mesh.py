# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``relax-mesh``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import READ_STITCHES, WRITTEN_STITCHES


@dataclass(frozen=True)
class RelaxMesh:
    """Even out stitches on the surface."""

    fabric: Annotated[Positional[str], shown("FABRIC", help=READ_STITCHES)]
    surface: Annotated[str, shown("LABELED")]
    """labeled mesh, from `stitchmesh label`"""
    output: Annotated[str, shown("FILE", short="-o", help=WRITTEN_STITCHES)]

    def run(self) -> None:
        """Even stitches on the smooth surface."""
        from stitchmesh.cli.progress import on_terminal
        from stitchmesh.io import read_stitches, write_stitches
        from stitchmesh.meshrelax import relax_mesh_with_report
        from stitchmesh.pipeline import MESH_TOLERANCE, relaxing_progress

        fabric, surface = read_stitches(self.fabric), read_stitches(self.surface)
        with on_terminal() as progress:
            tell = relaxing_progress("meshrelax", MESH_TOLERANCE, progress)
            relaxed, how = relax_mesh_with_report(fabric, surface=surface, progress=tell)
        write_stitches(self.output, relaxed)
        print(f"{how.iterations} iterations, stretch rms {how.rms_stretch:.3f}, at most {how.max_stretch:.3f}")

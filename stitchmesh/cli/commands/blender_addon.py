# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``blender-addon``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from stitchmesh.cli.options import Overwrite
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry


@dataclass(frozen=True)
class BlenderAddonCommand:
    """Write an add-on that knits meshes in Blender, as a zip file."""

    output: Annotated[str, help_entry("FILE.zip", short="-o")]
    """zip file that Blender installs: Edit > Preferences > Add-ons > Install from Disk"""
    overwrite: Overwrite = False

    def run(self) -> None:
        """Write the file, and say how it is installed."""
        from stitchmesh.io.blender_addon import write_blender_addon

        write_blender_addon(self.output)
        say(f"Wrote {self.output}. In Blender: Edit > Preferences > Add-ons > Install from Disk")

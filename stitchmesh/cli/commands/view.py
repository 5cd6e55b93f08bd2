# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``view``."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.serving import Serving
from stitchmesh.cli.words import help_entry


@dataclass(frozen=True)
class View:
    """Look at a file, or follow a running job, in the browser."""

    file: Annotated[Positional[str], help_entry("FILE")]
    """polygon mesh, stitch mesh or yarns, or the output folder of a job"""
    serving: Annotated[Serving, arg(name="")] = field(default_factory=Serving)

    def run(self) -> None:
        """Open the application at the page View, and run it until it is interrupted."""
        from stitchmesh.app.starts import VIEW, view_project

        self.serving.run(partial(view_project, self.file), VIEW)

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands that open the application in the browser: ``app`` and ``view``."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.options import Serving
from stitchmesh.cli.words import help_entry
from stitchmesh.io.units import DEFAULT_UNIT


@dataclass(frozen=True)
class AppCommand:
    """Open the application in the browser: from a mesh to yarns by the mouse."""

    file: Annotated[Positional[str | None], help_entry("FILE", "the last project")] = None
    """polygon mesh, stitch mesh or name of `stitchmesh examples` to start from, or the folder of a project"""
    unit: Annotated[str | None, help_entry("UNIT", f"that of the project of the file, or {DEFAULT_UNIT}")] = None
    """unit of a file that states no unit; with another unit than before, a new project of the file is started"""
    project: Annotated[str | None, help_entry("DIR", "a folder in ~/StitchMesh")] = None
    """folder of the project"""
    serving: Annotated[Serving, arg(name="")] = field(default_factory=Serving)

    def run(self) -> None:
        """Open the project, and run the application until it is interrupted."""
        from stitchmesh.app.project.opening import project_for

        self.serving.run(partial(project_for, self.file, self.project, self.unit))


@dataclass(frozen=True)
class ViewCommand:
    """Look at a file, or follow a running job, in the browser."""

    file: Annotated[Positional[str], help_entry("FILE")]
    """polygon mesh, stitch mesh or yarns, or the output folder of a job"""
    serving: Annotated[Serving, arg(name="")] = field(default_factory=Serving)

    def run(self) -> None:
        """Open the application at the page View, and run it until it is interrupted."""
        from stitchmesh.app.starts import VIEW, view_project

        self.serving.run(partial(view_project, self.file), VIEW)

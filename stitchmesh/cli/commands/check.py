# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``check``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import FileReading


@dataclass(frozen=True)
class Check:
    """Check a file: status 0 if it is sound, else one line and status 2."""

    file: Annotated[Positional[str], shown("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """Reading a file validates it."""
        from stitchmesh.cli.describe import kind_of

        print(f"{self.file}: sound {kind_of(self.reading.read(self.file))}")

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``patterns``."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.cli.say import say


@dataclass(frozen=True)
class Patterns:
    """List the patterns and weaves of the library."""

    def run(self) -> None:
        """Print a table of the knitting patterns and then of the weaves."""
        from stitchmesh.patterns import pattern_names, read_pattern
        from stitchmesh.periodic.weave.library import read_weave, weave_names

        width = max(map(len, (*pattern_names(), *weave_names())))
        say(f"{'name':{width}}    size  yarns  title; source")
        for name in pattern_names():
            found = read_pattern(name)
            size = f"{found.width} x {found.height}"
            say(f"{name:{width}}  {size:>7}  {found.yarn_count:5}  {found.name}; {found.source}")
        for name in weave_names():
            weave = read_weave(name)
            size = f"{len(weave.warps)} x {len(weave.wefts)}"
            say(f"{name:{width}}  {size:>7}  woven  {weave.name}; {weave.source}")

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``yarn``."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Annotated, Literal

from tyro.conf import Positional

from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError

WIDTH = 118
"""Longest line of the table of a yarn."""


@dataclass(frozen=True)
class YarnCommand:
    """List the yarns, or show one in all units and what follows from it."""

    action: Annotated[Positional[Literal["list", "show"]], help_entry("list|show")]
    """list the yarns, or show one of them"""
    name: Annotated[Positional[str | None], help_entry("NAME|FILE", "none")] = None
    """name of the yarn, or its description: a file such as yarn.toml (docs/yarn-materials.md)"""

    def run(self) -> None:
        """Print the table.

        Raises:
            ParameterError: no yarn is named, or there is none of that name.
        """
        from stitchmesh.io.yarn_files import yarn_of
        from stitchmesh.yarnrelax.yarn_figures import yarn_figures

        if self.action == "list":
            self._list()
            return
        if self.name is None:
            raise ParameterError("yarn show: got no yarn; expected a name that `stitchmesh yarn list` names, or a file")
        yarn = yarn_of(self.name)
        say(f"{yarn.name}")
        for figure in yarn_figures(yarn):
            mark = "" if figure.good else "CHECK: "
            lines = textwrap.wrap(f"{figure.value}; {mark}{figure.meaning}", WIDTH - 20)
            say(f"  {figure.name:17} {lines[0]}")
            for line in lines[1:]:
                say(f"{'':20}{line}")

    def _list(self) -> None:
        from stitchmesh.yarn.yarn_description import LIBRARY
        from stitchmesh.yarn.yarn_presets import Yarn, yarn_names

        names = (*yarn_names(), *LIBRARY)
        width = max(map(len, names))
        say(f"{'name':{width}}  {'tex':>7}  {'mm':>6}  {'EA N':>7}  {'EI cN cm2':>9}  stitches in 10 cm")
        for name in names:
            yarn = Yarn.named(name)
            assert yarn.mechanics is not None
            along, bend = yarn.mechanics.axial_stiffness / 1e5, yarn.mechanics.flexural_rigidity / 1e3
            sizes = f"{1e5 * yarn.mass_per_length:7.1f}  {20.0 * yarn.apparent_radius:6.3f}"
            say(f"{name:{width}}  {sizes}  {along:7.3g}  {bend:9.3g}  {yarn.gauge.stitches:.3g}")
        say("Show one with its source: stitchmesh yarn show dk. Knit with it: --yarn dk")

# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``select``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional

from stitchmesh.cli.options import READ_STITCHES, Overwrite
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry

if TYPE_CHECKING:
    from stitchmesh.mesh import IntArray, StitchMesh

PICTURE_SUFFIX = ".png"


@dataclass(frozen=True)
class Select:
    """Show parts of a stitch mesh by name, as counts, a picture or a list."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    selections: Annotated[Positional[tuple[str, ...]], help_entry("SELECTION", "list the names")] = ()
    """parts of the fabric, such as 'hem 6' (docs/selections.md)"""
    output: Annotated[str | None, help_entry("FILE", "none", short="-o")] = None
    """picture (.png) with each selection in its own colour, or a text file of face numbers"""
    overwrite: Overwrite = False

    def run(self) -> None:
        """Print the names or the counts, and write the file."""
        from stitchmesh.io import read_stitches
        from stitchmesh.selection import select

        fabric = read_stitches(self.fabric)
        names = self.selections or tuple(_names(fabric))
        chosen = {name: select(fabric, name) for name in names}
        if self.output is not None:
            self._write(fabric, chosen, self.output)
        for name, faces in chosen.items():
            rows = fabric.row[faces]
            say(f"{name}: {len(faces)} of {fabric.face_count} stitches, in rows {rows.min()} to {rows.max()}")

    def _write(self, fabric: StitchMesh, chosen: dict[str, IntArray], path: str) -> None:
        import numpy as np

        if Path(path).suffix.lower() == PICTURE_SUFFIX:
            from stitchmesh.render.selection_picture import render_selections

            render_selections(fabric, chosen, path)
            return
        from stitchmesh.io.atomic import write_text

        faces = np.unique(np.concatenate(list(chosen.values())))
        write_text(path, "".join(f"{face}\n" for face in faces.tolist()))


def _names(fabric: StitchMesh) -> list[str]:
    """Return the names of borders and parts that the fabric has."""
    from stitchmesh.errors import ParameterError
    from stitchmesh.selection import borders, select
    from stitchmesh.selection.selection import PLACES

    names = [*(border.name for border in borders(fabric)), *PLACES]
    found = []
    for name in dict.fromkeys("tips" if name == "tip" else name for name in names):
        try:
            select(fabric, name)
        except ParameterError:
            continue
        found.append(name)
    return found
